"""Drapes that pixel cloth learns from: `python -m pixel_data --minutes 600`, or `--device cuda --batch 256`.

The T-shirt of the method, or with `--garment tie` its necktie, on the reference body in sampled poses of the upper body
(Jin et al. 2020, section 6), relaxed to the least energy of the cloth (`relax.py`). Seeded; chunks that are there
already are kept, so a run can be stopped, and several runs with different `--part` share the work. Both are also
simulated in these poses (`teacher.pixel_drapes`).
"""

from __future__ import annotations

import argparse
import os
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import astuple, dataclass, replace
from itertools import islice
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

import outfits.necktie
from body.anny_body import AnnyBody
from body.humanoid import Rotations
from devices import on
from garment.mirror import mirrored_cloth, mirrored_joints, opposite
from outfits.dataset import save
from outfits.garnet_garments import garnet_garment
from outfits.mesh import GarmentMesh
from pixel_poses import upper_body_poses
from posed_bodies import Bodies
from relax import Worn, follow
from teacher.checks import Judged, Limits, crossing, judge
from teacher.drapes import FREE
from training_data import DATA, BodyBank, Sample, ShapedPoses, load_sample

PIXEL = DATA / "pixel"
#: Vertices per square metre: 2.7 thousand vertices.
DENSITY = 3000
#: Drapes at most and the seed of their poses.
COUNT, SEED = 5120, 9_001
#: Steps of a relaxation, as of `garnet_data`.
STEPS = 640
#: Every tenth drape each is for validation and for the test (section 6.3: 80/10/10).
SPLITS = {"train": range(8), "validation": range(8, 9), "test": range(9, 10)}


@dataclass(frozen=True)
class Source:
    """Where drapes lie."""

    folder: Path
    chunk: int  # drapes of a file

    def files(self, garment: str = "tee") -> list[Path]:
        """Where each chunk lies, in the order of the poses."""
        return [self.folder / garment / f"{k:03d}.npz" for k in range(COUNT // self.chunk)]

    def has(self, garment: str = "tee") -> bool:
        """Whether drapes have been made."""
        return any(path.exists() for path in self.files(garment))

    def load(self, garment: str = "tee") -> dict[str, Drapes]:
        """Every good drape that is there, by split. Raises FileNotFoundError when there is none."""
        if not self.has(garment):
            raise FileNotFoundError(f"no drapes of the {garment} under {self.folder}: make them first")
        drapes = good(self.files(garment), self.chunk)
        return {split: drapes.of(split) for split in SPLITS}


#: By this module, and by `teacher.pixel_drapes`.
RELAXED, SIMULATED = Source(PIXEL, 64), Source(DATA / "pixel_simulated", 8)


@dataclass(frozen=True)
class Drapes:
    """D drapes of one garment on the reference body."""

    x: Tensor  # (D, N, 3) world
    transforms: Tensor  # (D, 36, 3, 4) world from A-pose
    number: Tensor  # (D,) of the pose

    def of(self, split: str) -> Drapes:
        rows = torch.isin(self.number % 10, torch.tensor(list(SPLITS[split])))
        return Drapes(self.x[rows], self.transforms[rows], self.number[rows])

    def with_mirrored(self, sample: Sample) -> Drapes:
        """These, then each as a mirror shows it: twice as many of a symmetric garment."""
        there = opposite(sample.vertices.double().numpy(), sample.tables[2].numpy())
        x, transforms = mirrored_cloth(self.x, there), mirrored_joints(self.transforms)
        return Drapes(*(torch.cat(p) for p in ((self.x, x), (self.transforms, transforms), (self.number,) * 2)))


def shirt(folder: Path = PIXEL, density: int = DENSITY) -> Sample:
    """The T-shirt, prepared; made where it is missing."""
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "tee.npz").exists():
        save(garnet_garment("tee", density), folder / "tee.npz")
    return load_sample(folder / "tee.npz")


def necktie(folder: Path = PIXEL) -> Sample:
    """The necktie, prepared; made where it is missing. Its knot is held where skinning puts it, the rest hangs free."""
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "tie.npz").exists():
        save(outfits.necktie.necktie(), folder / "tie.npz")
    sample = load_sample(folder / "tie.npz")
    height = sample.vertices[:, 1]
    knot = torch.nonzero(height > height.max() - outfits.necktie.KNOT)[:, 0]
    return replace(sample, held=knot, distance=torch.full_like(sample.distance, FREE))


def worn(sample: Sample) -> GarmentMesh:
    """A sample's garment, its vertices in their order."""
    return GarmentMesh("garment", "garment", 0, sample.vertices.double().numpy(), sample.tables[2].numpy())


#: Garments by name.
GARMENTS: dict[str, Callable[[Path], Sample]] = {"tee": shirt, "tie": necktie}


def in_poses(bank: BodyBank, poses: list[Rotations]) -> ShapedPoses:
    """The reference body."""
    return bank.random_entry(AnnyBody.load(), ({}, {}), poses)


class Maker:
    """Relaxes chunks of a garment's drapes on a device; other processes judge them, or with no workers this one."""

    def __init__(self, sample: Sample, device: str = "cpu", workers: int = 0, steps: int = STEPS) -> None:
        self.sample, self.device, self.steps, self.bank = sample, device, steps, BodyBank(0, 0, 0)
        self.pool = ProcessPoolExecutor(workers, get_context("spawn")) if workers else None
        self.already = crossing(self.sample.vertices.double().numpy(), self.sample.tables[2].numpy())

    def make(self, entry: ShapedPoses, batch: int) -> tuple[NDArray[np.float32], list[Judged]]:
        """Cloth in every pose of an entry, (P, N, 3), and its judgements."""
        done = [self.relaxed(entry, poses) for poses in torch.arange(len(entry.vertices)).split(batch)]
        x, tables = np.concatenate(done), (self.sample.tables[2].numpy(), self.bank.triangles.numpy())
        start = (self.already, self.sample.vertices.numpy())
        jobs = [(cloth, start, skin, *tables) for cloth, skin in zip(x, entry.vertices.numpy(), strict=True)]
        return x, list((self.pool.map if self.pool else map)(judged, *zip(*jobs, strict=True)))

    def relaxed(self, entry: ShapedPoses, poses: Tensor) -> NDArray[np.float32]:
        worn, bodies = Worn.of(self.sample, self.bank, entry, len(poses)), Bodies.of(entry, poses)
        sample, worn, bodies = on((self.sample, worn, bodies), self.device)
        return follow(sample, worn, self.bank.to(self.device), bodies, self.steps).cpu().numpy()


def judged(
    x: NDArray[np.float32], start: tuple[NDArray, NDArray], skin: NDArray, triangles: NDArray, skin_triangles: NDArray
) -> Judged:
    """As `judge`; relaxation ends where it ends, so there is no residual."""
    return judge(x.astype(np.float64), 0.0, start, triangles, (skin.astype(np.float64), skin_triangles))


def keep(path: Path, entry: ShapedPoses, x: NDArray[np.float32], found: list[Judged]) -> None:
    """Writes a chunk; the file appears complete or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".part{os.getpid()}.npz")
    np.savez(part, x=x, transforms=entry.transforms.numpy(), judged=np.array([astuple(j) for j in found]))
    part.rename(path)


def good(paths: list[Path], chunk: int) -> Drapes:
    """Every good drape of those chunks that are there, `chunk` poses each."""
    rows = []
    for k, path in enumerate(paths):
        if path.exists():
            kept, number = np.load(path), np.arange(k * chunk, (k + 1) * chunk)
            fine = [Judged(*row).fault(Limits()) is None for row in kept["judged"].tolist()]
            rows.append([torch.as_tensor(v[fine]) for v in (kept["x"], kept["transforms"], number[: len(fine)])])
    return Drapes(*(torch.cat(column) for column in zip(*rows, strict=True)))


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--garment", choices=list(GARMENTS), default="tee")
    p.add_argument("--minutes", type=float, default=60)
    p.add_argument("--part", type=int, default=0, help="which of every --parts chunks to make")
    p.add_argument("--parts", type=int, default=1)
    p.add_argument("--device", default="cpu")
    p.add_argument("--batch", type=int, default=8, help="drapes relaxed at once: 8 for a core, 64 for a GPU")
    p.add_argument("--workers", type=int, default=1, help="processes that judge drapes")
    a = p.parse_args()
    maker, started, faults = Maker(GARMENTS[a.garment](PIXEL), a.device, a.workers), time.time(), Counter()
    poses, chunk = upper_body_poses(COUNT, SEED), RELAXED.chunk
    for k, path in islice(enumerate(RELAXED.files(a.garment)), a.part, None, a.parts):
        if time.time() - started > 60 * a.minutes:
            break
        if path.exists():
            continue
        entry = in_poses(maker.bank, poses[k * chunk : (k + 1) * chunk])
        x, found = maker.make(entry, a.batch)
        keep(path, entry, x, found)
        faults.update(j.fault(Limits()) or "" for j in found)
        print(
            f"{faults.total()} drapes, {round(time.time() - started)} s, good and by fault: {dict(faults)}", flush=True
        )
    if maker.pool:
        maker.pool.shutdown()


if __name__ == "__main__":
    torch.set_num_threads(1)
    main()
