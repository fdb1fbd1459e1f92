"""Simulated drapes of outfits that training never sees, to judge by: `python -m teacher.drapes`.

Seeded: outfit i on its own random bodies in its own random poses. Each starts where plain skinning and the
service's resolve put it, and settles (`simulation`). What does not come to rest whole and outside (`checks`) is
marked with its fault and counted. Drapes that are there already are kept, so that a run can be stopped.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import subprocess
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import load_file
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody
from body.pose_sampling import sample_poses
from evaluation_set import rounded
from outfits.held_out import held_out, write_obj
from outfits.resolutions import coarser
from training_data import DATA, random_shape

Floats = NDArray[np.floating]

TEACHER = DATA / "teacher"
TOILE = Path(__file__).parents[2] / "target" / "release" / "toile"
#: Of bodies and poses; training draws from others.
SEED = 40_000
#: m, moves of the vertices at the start of the second run that tells how far the teacher agrees with itself.
PERTURBED = 0.002
#: Share of the body's height from which a garment hangs from the shoulders.
SHOULDERS = 0.77
#: m, distance within which garments lie over each other.
LAYERED = 0.05


@dataclass(frozen=True)
class Size:
    """How many of each."""

    outfits: int = 15
    bodies: int = 2  # of its own for each outfit
    poses: int = 12  # of its own for each outfit
    vertices: int = 1200  # of an outfit at most, about: a drape takes half a minute


def prepare(size: Size, out: Path) -> list[Path]:
    """Writes the outfits and what they are worn on, a folder each."""
    poses = sample_poses(size.outfits * size.poses, SEED)
    folders = []
    for i, fine in held_out(size.outfits):
        share = min(1.0, size.vertices / fine.vertex_count)
        outfit = replace(fine, garments=[coarser(g, share) for g in fine.garments])
        folder = out / f"{i:02d}_{outfit.family}"
        folder.mkdir(parents=True, exist_ok=True)
        write_obj(outfit, folder / "outfit.obj")
        rng = np.random.default_rng(SEED + i)
        bodies = [random_shape(rng, 1)[0] for _ in range(size.bodies)]
        mine = poses[i * size.poses : (i + 1) * size.poses]
        on = {
            "bodies": [{"kind": "phenotypes", "values": values} for values in bodies],
            "poses": [{"kind": "joints", "rotations": {n: rounded(q) for n, q in pose.items()}} for pose in mine],
        }
        (folder / "set.json").write_text(json.dumps(on) + "\n")
        folders.append(folder)
    return folders


def draped(folder: Path, method: str) -> dict[str, NDArray]:
    """The service's drapes of a folder's outfit (`toile evaluate --keep`)."""
    kept = folder / method
    kept.mkdir(exist_ok=True)
    command = [TOILE, "evaluate", "--method", method, "--set", folder / "set.json", "--keep", kept]
    subprocess.run([*command, folder / "outfit.obj"], check=True, stdout=subprocess.DEVNULL)
    return load_file(kept / "outfit.safetensors")


def simulate(folder: Path) -> None:
    """Simulates every drape of a folder that is not there yet."""
    # Its kernels take a minute to compile where nothing needs them.
    from .checks import Limits, judge
    from .colliders import touched
    from .simulation import Cloth, Settings, equilibrium
    from .waistbands import held
    from .weight import pull

    start, body = draped(folder, "skinning"), AnnyBody.load()
    triangles = start["triangles"].astype(np.int64)
    for b, p, perturbed in wanted(start["draped"].shape[:2]):
        path = drape_path(folder, b, p, perturbed)
        if path.exists():
            continue
        rest, skin = start["rest"][b], start["skin"][b]
        shoulders = float(skin[:, 1].min() + SHOULDERS * np.ptp(skin[:, 1]))
        distance = cKDTree(skin).query(rest)[0]
        cloth = Cloth(
            rest, triangles, distance, alone(rest, start["garment"]),
            pull(rest, start["draped"][b, p], triangles, distance),
            held(rest, triangles, start["garment"], skin, shoulders),
        )  # fmt: skip
        surface = (start["body"][b, p], touched(rest, skin, body))
        x = start["resolved"][b, p]
        if perturbed:
            x = x + np.random.default_rng(b + 100 * p).normal(0, PERTURBED, x.shape).astype(np.float32)
        end = equilibrium(cloth, x, surface, Settings())
        judged = judge(end.x, end.residual, (start["resolved"][b, p], rest), triangles, surface)
        fault = judged.fault(Limits()) or ""
        np.savez_compressed(path, x=end.x.astype(np.float32), steps=end.steps, fault=fault, **asdict(judged))
        print(
            f"{folder.name} body {b} pose {p}{' again' * perturbed}: {end.steps} steps, {fault or 'good'}", flush=True
        )


def alone(rest: Floats, garment: NDArray) -> NDArray[np.bool_]:
    """Whether no other garment is within `LAYERED` of each vertex, (N,)."""
    out = np.ones(len(rest), bool)
    for g in np.unique(garment):
        mine = garment == g
        if not mine.all():
            out[mine] = cKDTree(rest[~mine]).query(rest[mine])[0] > LAYERED
    return out


def wanted(shape: tuple[int, int]) -> Iterator[tuple[int, int, bool]]:
    """Body, pose, and whether from a perturbed start: every first pose is simulated twice."""
    for b in range(shape[0]):
        for p in range(shape[1]):
            yield b, p, False
            if p == 0:
                yield b, p, True


def drape_path(folder: Path, body: int, pose: int, perturbed: bool) -> Path:
    """Where a drape is kept."""
    return folder / f"drape_{body}_{pose}{'_again' * perturbed}.npz"


def faults(folders: list[Path]) -> Counter[str]:
    """How many drapes are good (empty name) and how many have each fault."""
    return Counter(str(np.load(path)["fault"]) for f in folders for path in f.glob("drape_*.npz"))


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, value in asdict(Size()).items():
        p.add_argument(f"--{name}", type=int, default=value)
    p.add_argument("--out", type=Path, default=TEACHER)
    p.add_argument("--workers", type=int, default=2)
    a = p.parse_args()
    folders = prepare(Size(a.outfits, a.bodies, a.poses, a.vertices), a.out)
    with ProcessPoolExecutor(a.workers, multiprocessing.get_context("spawn")) as pool:
        list(pool.map(simulate, folders))
    print(dict(faults(folders)))


if __name__ == "__main__":
    main()
