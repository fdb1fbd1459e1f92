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
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import load_file
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody
from body.pose_sampling import sample_poses
from evaluation_set import rounded
from garment.waistbands import held
from outfits.held_out import held_out, write_obj
from outfits.resolutions import coarser
from training_data import DATA, random_shape

from .checks import Judged, Limits, crossing, fault, judge
from .colliders import touched
from .weight import pull

if TYPE_CHECKING:
    from .simulation import Cloth, Resting, Settings

Floats = NDArray[np.floating]

TEACHER = DATA / "teacher"
TOILE = Path(__file__).parents[2] / "target" / "release" / "toile"
#: Of bodies and poses; training draws from others.
SEED = 40_000
#: m, moves of the vertices at the start of the second run that tells how far the teacher agrees with itself.
PERTURBED = 0.002
#: m, distance within which garments lie over each other.
LAYERED = 0.05
#: m from the body at which cloth neither lies on it nor is held by it.
FREE = 0.05


@dataclass(frozen=True)
class Size:
    """How many of each."""

    outfits: int = 16  # one of which hardly ever comes to rest
    bodies: int = 2  # of its own for each outfit
    poses: int = 13  # of its own for each outfit
    vertices: int = 1500  # of an outfit at most, about: a drape takes half a minute


def prepare(size: Size, out: Path) -> list[Path]:
    """Writes the outfits and what they are worn on, a folder each. A larger set begins with the smaller one."""
    folders = []
    for i, fine in held_out(size.outfits):
        share = min(1.0, size.vertices / fine.vertex_count)
        outfit = replace(fine, garments=[coarser(g, share) for g in fine.garments])
        folder = out / f"{i:02d}_{outfit.family}"
        folder.mkdir(parents=True, exist_ok=True)
        write_obj(outfit, folder / "outfit.obj")
        rng = np.random.default_rng(SEED + i)
        bodies = [random_shape(rng, 1)[0] for _ in range(size.bodies)]
        poses = sample_poses(size.poses, SEED + i)
        on = {
            "bodies": [{"kind": "phenotypes", "values": values} for values in bodies],
            "poses": [{"kind": "joints", "rotations": {n: rounded(q) for n, q in pose.items()}} for pose in poses],
        }
        (folder / "set.json").write_text(json.dumps(on) + "\n")
        folders.append(folder)
    return folders


def draped(folder: Path, method: str, outfit: Path | None = None) -> dict[str, NDArray]:
    """The service's drapes of an outfit, by default the folder's own (`toile evaluate --keep`)."""
    kept, outfit = folder / method, outfit or folder / "outfit.obj"
    kept.mkdir(exist_ok=True)
    command = [TOILE, "evaluate", "--method", method, "--set", folder / "set.json", "--keep", kept]
    subprocess.run([*command, outfit], check=True, stdout=subprocess.DEVNULL)
    return load_file(kept / f"{outfit.stem}.safetensors")


@dataclass(frozen=True)
class Run:
    """One simulation."""

    folder: Path
    body: int
    pose: int
    perturbed: bool = False

    @property
    def path(self) -> Path:
        """Where the drape is kept."""
        return self.folder / f"drape_{self.body}_{self.pose}{'_again' * self.perturbed}.npz"

    @property
    def name(self) -> str:
        return f"{self.folder.name} body {self.body} pose {self.pose}{' again' * self.perturbed}"


def runs(folders: list[Path], size: Size) -> Iterator[Run]:
    """All simulations, every outfit's first pose first; on its first body that one is simulated twice."""
    for pose in range(size.poses):
        for folder in folders:
            for body in range(size.bodies):
                yield Run(folder, body, pose)
                if body == pose == 0:
                    yield Run(folder, body, pose, perturbed=True)


def simulate(run: Run) -> None:
    """Simulates and keeps one drape, if it is not there yet."""
    if run.path.exists():
        return
    start = load_file(run.folder / "skinning" / "outfit.safetensors")
    end, judged = settled(start, run.body, run.pose, PERTURBED if run.perturbed else 0.0)
    np.savez_compressed(run.path, x=end.x.astype(np.float32), steps=end.steps, **asdict(judged))
    print(f"{run.name}: {end.steps} steps, {judged.fault(Limits()) or 'good'}", flush=True)


def settled(
    start: dict[str, NDArray], body: int, pose: int, moved: float = 0.0, settings: Settings | None = None
) -> tuple[Resting, Judged]:
    """Where an outfit comes to rest from its drape by skinning, vertices `moved` (m) at random; how good that is."""
    # Its kernels take a minute to compile where nothing needs them.
    from .simulation import Settings, equilibrium

    cloth, surface = scene(start, body, pose)
    x = start["resolved"][body, pose]
    already = crossing(x, cloth.triangles)
    x = x + np.random.default_rng(body).normal(0, moved, x.shape).astype(np.float32)
    end = equilibrium(cloth, x, surface, settings or Settings())
    return end, judge(end.x, end.residual, (already, cloth.rest), cloth.triangles, surface)


def scene(start: dict[str, NDArray], body: int, pose: int) -> tuple[Cloth, tuple[Floats, NDArray]]:
    """What drapes, and the skin that it drapes on.

    Where `start` names the vertices of a knot, these hold all of the cloth, or else the skin and waistbands do.
    """
    from .simulation import Cloth

    rest, skin, triangles = start["rest"][body], start["skin"][body], start["triangles"].astype(np.int64)
    tied = "knot" in start
    distance = np.full(len(rest), FREE) if tied else cKDTree(skin).query(rest)[0]
    cloth = Cloth(
        rest, triangles, distance, alone(rest, start["garment"]),
        pull(rest, start["draped"][body, pose], triangles, distance),
        start["knot"] if tied else held(rest, triangles, start["garment"], skin),
    )  # fmt: skip
    return cloth, (start["body"][body, pose], touched(rest, skin, AnnyBody.load()))


def alone(rest: Floats, garment: NDArray) -> NDArray[np.bool_]:
    """Whether no other garment is within `LAYERED` of each vertex, (N,)."""
    out = np.ones(len(rest), bool)
    for g in np.unique(garment):
        mine = garment == g
        if not mine.all():
            out[mine] = cKDTree(rest[~mine]).query(rest[mine])[0] > LAYERED
    return out


def folders_in(out: Path) -> list[Path]:
    """An outfit each."""
    return sorted(f for f in out.iterdir() if (f / "set.json").exists())


def faults(folders: list[Path]) -> Counter[str]:
    """How many drapes are good (empty name) and how many have each fault."""
    return Counter(fault(path) for f in folders for path in f.glob("drape_*.npz"))


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, value in asdict(Size()).items():
        p.add_argument(f"--{name}", type=int, default=value)
    p.add_argument("--out", type=Path, default=TEACHER)
    p.add_argument("--workers", type=int, default=2)
    a = p.parse_args()
    size = Size(a.outfits, a.bodies, a.poses, a.vertices)
    folders = prepare(size, a.out)
    for folder in folders:
        draped(folder, "skinning")
    with ProcessPoolExecutor(a.workers, multiprocessing.get_context("spawn")) as pool:
        list(pool.map(simulate, runs(folders, size)))
    print(dict(faults(folders)))


if __name__ == "__main__":
    main()
