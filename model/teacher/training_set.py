"""Simulated drapes to learn from: `python -m teacher.training_set`.

Coarse outfits of the kinds that are trained on, each on one body of the training bank in some of its poses, simulated
and judged as the evaluation set is (`drapes`), in fewer time steps. Written as `training_data` reads targets. Seeded;
outfits that are there already are kept, so that a run can be stopped, and a larger set begins with the smaller one.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from body.anny_body import AnnyBody
from body.humanoid import Rotations, joint_rotations
from evaluation_set import rounded
from outfits.dataset import save, training_outfit
from outfits.held_out import write_obj
from outfits.mesh import OutfitMesh
from outfits.resolutions import coarser
from relax import chances
from training_data import DATA, TRAINING_BANK, ShapeValues, random_bodies

from .checks import Limits
from .drapes import draped, settled

SIMULATED = DATA / "simulated"
#: Triangles of 5 to 7 cm dip into the body between corners that do not, and coarse layers hardly come to rest.
LIMITS = Limits(residual=5e-3, inside=0.03)


@dataclass(frozen=True)
class Size:
    """How many of each."""

    outfits: int = 300
    poses: int = 8  # of each, on one body
    vertices: int = 600  # of an outfit at most, about


@dataclass(frozen=True)
class Worn:
    """An outfit's body and poses."""

    entry: int  # body of the training bank
    poses: NDArray[np.int64]  # (P,) of it
    values: ShapeValues
    rotations: list[Rotations]

    @classmethod
    def drawn(cls, seed: int, poses: int) -> Worn:
        """At random; every other pose has a leg bent far at the hip, as in relaxation."""
        rng = np.random.default_rng([seed, 21])
        bodies = training_bodies()
        entry = int(rng.integers(len(bodies)))
        values, all_poses = bodies[entry]
        chance = chances(transforms(values, all_poses))
        picked = rng.choice(len(all_poses), poses, replace=False, p=chance)
        return cls(entry, picked, values, [all_poses[p] for p in picked])

    def asked(self) -> dict:
        """As the service's `evaluate` reads it."""
        phenotypes, local = self.values
        rotations = [{name: rounded(q) for name, q in pose.items()} for pose in self.rotations]
        return {
            "bodies": [{"kind": "phenotypes", "values": phenotypes | local}],
            "poses": [{"kind": "joints", "rotations": pose} for pose in rotations],
        }


@cache
def training_bodies() -> list[tuple[ShapeValues, list[Rotations]]]:
    """Bodies and poses of the training bank."""
    return random_bodies(*TRAINING_BANK)


def transforms(values: ShapeValues, poses: list[Rotations]) -> NDArray[np.float32]:
    """World from A-pose of the garment's joints, (P, J, 3, 4)."""
    body = AnnyBody.load()
    shaped = body.shape(*values)
    worlds = [body.world_from_apose(shaped, joint_rotations(body, pose)) for pose in poses]
    return np.stack([body.garment_transforms(shaped, world) for world in worlds]).astype(np.float32)


def coarse(seed: int, vertices: int) -> OutfitMesh:
    """Training's outfit of that seed with about so many vertices at most."""
    fine = training_outfit(seed)
    share = min(1.0, vertices / fine.vertex_count)
    return replace(fine, garments=[coarser(g, share) for g in fine.garments])


def make(seed: int, size: Size, out: Path) -> Counter[str]:
    """Simulates one outfit and keeps its good drapes. How many are good (empty name) and have each fault."""
    # Its kernels take a minute to compile where nothing needs them.
    from .simulation import QUICK

    kept = next(out.glob(f"{seed:07d}_*[0-9].npz"), None)
    if kept is not None:
        return Counter(np.load(kept)["faults"].tolist())
    outfit, worn = coarse(seed, size.vertices), Worn.drawn(seed, size.poses)
    name = f"{seed:07d}_{outfit.family}"
    path, scratch = out / f"{name}_{worn.entry}.npz", out / "scratch" / name
    scratch.mkdir(parents=True, exist_ok=True)
    write_obj(outfit, scratch / "outfit.obj")
    (scratch / "set.json").write_text(json.dumps(worn.asked()))
    start = draped(scratch, "skinning")
    ends = [settled(start, 0, k, settings=QUICK) for k in range(size.poses)]
    faults = [judged.fault(LIMITS) or "" for _, judged in ends]
    good = np.array([not fault for fault in faults])
    x = np.stack([end.x for end, _ in ends]) - lifted(start, worn)[:, None]
    save(outfit, out / "outfits" / f"{name}.npz")
    there = transforms(worn.values, worn.rotations)
    part = path.with_suffix(".part.npz")
    np.savez_compressed(
        part, outfit=name, entry=worn.entry, poses=worn.poses[good], transforms=there[good],
        x=x[good].astype(np.float32), faults=np.array(faults),
    )  # fmt: skip
    part.rename(path)
    print(f"{name}: {int(good.sum())} of {len(good)} good", flush=True)
    return Counter(faults)


def lifted(start: dict[str, NDArray], worn: Worn) -> NDArray[np.float64]:
    """How far the service lifts the body to the ground in each pose, which training does not, (P, 3)."""
    body = AnnyBody.load()
    shaped = body.shape(*worn.values)
    posed = [body.pose(shaped, body.world_from_apose(shaped, joint_rotations(body, pose))) for pose in worn.rotations]
    return (start["body"][0] - np.stack(posed)).mean(1)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, value in asdict(Size()).items():
        p.add_argument(f"--{name}", type=int, default=value)
    p.add_argument("--out", type=Path, default=SIMULATED)
    p.add_argument("--workers", type=int, default=2)
    a = p.parse_args()
    size = Size(a.outfits, a.poses, a.vertices)
    (a.out / "outfits").mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(a.workers, multiprocessing.get_context("spawn")) as pool:
        counts = pool.map(make, range(size.outfits), [size] * size.outfits, [a.out] * size.outfits)
        print(dict(sum(counts, Counter())))


if __name__ == "__main__":
    main()
