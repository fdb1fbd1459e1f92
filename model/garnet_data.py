"""Drapes that GarNet learns from and is tested on: `python -m garnet_data --minutes 60`.

The four garments of the paper's section 4.2 on bodies split into training, validation and test (no body in two of
them), each in random poses, relaxed to the least energy of the cloth (`relax.py`) from the garment as it is drawn, so
that the map from body to drape is repeatable. Seeded; drapes that are there already are kept, so a run can be stopped,
and several runs with different `--part` share the work.
"""

from __future__ import annotations

import argparse
import itertools
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from body.anny_body import AnnyBody
from body.humanoid import Rotations
from captured import captured_poses
from devices import on
from energies import RestMesh
from outfits.dataset import save
from outfits.garnet_garments import DENSITY, PATTERNS, garnet_garment
from posed_bodies import Bodies, stacked
from relax import Worn, follow
from teacher.checks import Limits, crossing, judge
from training_data import DATA, BodyBank, Sample, ShapedPoses, ShapeValues, carry, load_sample, random_bodies

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]

#: Steps of a relaxation: the map must repeat, so cloth comes nearer to rest than targets of DeePSD need.
STEPS = 640


@dataclass(frozen=True)
class Split:
    """Bodies of one set, and poses of each."""

    name: str
    bodies: int
    poses: int
    seed: int
    captured: int = 0  # of the poses, the first; the others are drawn at random

    def clothed(self) -> list[tuple[ShapeValues, list[Rotations]]]:
        """The bodies, each with its poses."""
        found = random_bodies(self.bodies, self.poses, self.seed)
        if not self.captured:
            return found
        rng, movement = np.random.default_rng(self.seed), captured_poses()
        some = [rng.choice(len(movement), self.captured, replace=False) for _ in found]
        return [
            (shape, [movement[k] for k in mine] + poses[self.captured :])
            for (shape, poses), mine in zip(found, some, strict=True)
        ]

    def bank(self) -> BodyBank:
        """The same, posed."""
        bank, body = BodyBank(0, 0, 0), AnnyBody.load()
        bank.entries = [bank.random_entry(body, *one) for one in self.clothed()]
        return bank

    @property
    def worn(self) -> range:
        """Bodies that are dressed: the first of every bank is the reference body, which is for training only."""
        return range(0 if self.name == "train" else 1, self.bodies)


#: No body is in two of them.
SPLITS = (Split("train", 80, 16, 7_001), Split("validation", 5, 8, 7_002), Split("test", 17, 8, 7_003))


@dataclass(frozen=True)
class Source:
    """Where drapes lie, and on which bodies in which poses."""

    folder: Path
    splits: tuple[Split, ...]

    def split(self, name: str) -> Split:
        return next(s for s in self.splits if s.name == name)


#: In random poses.
RELAXED = Source(DATA / "garnet", SPLITS)
#: On the same bodies, in captured movement, half of training's in random poses (`teacher.garnet_drapes`).
SIMULATED = Source(DATA / "garnet_simulated", tuple(replace(s, captured=8) for s in SPLITS))


@dataclass(frozen=True)
class Drape:
    """One to make."""

    garment: str
    split: Split
    body: int
    pose: int

    def path(self, out: Path) -> Path:
        """Where it is kept."""
        return out / self.garment / self.split.name / f"{self.body:03d}_{self.pose:02d}.npz"


def drapes(splits: tuple[Split, ...] = SPLITS) -> Iterator[Drape]:
    """All of them; the garments take turns, and test drapes come with the first training poses."""
    for pose in range(max(s.poses for s in splits)):
        for split in splits:
            if pose < split.poses:
                for body, garment in itertools.product(split.worn, PATTERNS):
                    yield Drape(garment, split, body, pose)


def missing(out: Path, part: int, parts: int, batch: int) -> Iterator[list[Drape]]:
    """What is not there yet, up to `batch` drapes of one garment at once; the garments take turns."""
    mine = [d for d in itertools.islice(drapes(), part, None, parts) if not d.path(out).exists()]
    of_each = [[d for d in mine if d.garment == kind] for kind in PATTERNS]
    for first in range(0, max(map(len, of_each)), batch):
        yield from (d[first : first + batch] for d in of_each if d[first:])


class Maker:
    """Relaxes drapes on a device, and has other processes judge and keep them."""

    def __init__(
        self, out: Path, device: str, workers: int, splits: tuple[Split, ...] = SPLITS, steps: int = STEPS
    ) -> None:
        self.out, self.device, self.steps = out, device, steps
        self.pool = ProcessPoolExecutor(workers, get_context("spawn"))
        self.banks = {s.name: s.bank() for s in splits}
        self.tables = next(iter(self.banks.values())).to(device)
        self.samples = samples(out)
        self.worn = lru_cache(512)(self._worn)

    def make(self, together: list[Drape]) -> list[Future[str]]:
        """Of one garment; what keeps each from being a target, empty for none."""
        sample, carried = self.samples[together[0].garment], [self.worn(d.garment, d.split, d.body) for d in together]
        bodies = stacked([Bodies.of(self._entry(d), torch.tensor([d.pose])) for d in together])
        worn = Worn.stacked([on_body for on_body, _ in carried])
        x = follow(*on((sample, worn), self.device), self.tables, on(bodies, self.device), self.steps).cpu().numpy()
        starts = [(already, rest.numpy()) for (rest, _), already in carried]
        rows = zip(together, x, starts, bodies.vertices.numpy(), strict=True)
        tables = sample.tables[2].numpy(), self.tables.triangles.cpu().numpy()
        return [self.pool.submit(keep, d.path(self.out), cloth, start, skin, *tables) for d, cloth, start, skin in rows]

    def _entry(self, drape: Drape) -> ShapedPoses:
        return self.banks[drape.split.name].entries[drape.body]

    def _worn(self, garment: str, split: Split, body: int) -> tuple[tuple[Tensor, RestMesh], Ints]:
        """The garment carried to a body, and its edges that cross it there."""
        bank, sample = self.banks[split.name], self.samples[garment]
        rest, mesh = carry(sample, bank, bank.entries[body])
        return (rest, mesh), crossing(rest.double().numpy(), sample.tables[2].numpy())


def keep(path: Path, x: Floats, start: tuple[Ints, Floats], skin: Floats, triangles: Ints, skin_triangles: Ints) -> str:
    """Keeps cloth x (N, 3) with its judgement by the simulator's measure. Returns its fault, empty for none.

    start: as of `judge`, skin (V, 3). Relaxation ends where it ends, so there is no residual.
    """
    judged = judge(x.astype(np.float64), 0.0, start, triangles, (skin.astype(np.float64), skin_triangles))
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part.npz")
    np.savez(part, x=x.astype(np.float32), **asdict(judged))
    part.rename(path)
    return judged.fault(Limits()) or ""


def samples(out: Path, density: int = DENSITY) -> dict[str, Sample]:
    """The garments, prepared; made where they are missing."""
    out.mkdir(parents=True, exist_ok=True)
    for kind in PATTERNS:
        if not (out / f"{kind}.npz").exists():
            save(garnet_garment(kind, density), out / f"{kind}.npz")
    return {kind: load_sample(out / f"{kind}.npz") for kind in PATTERNS}


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--minutes", type=float, default=60)
    p.add_argument("--part", type=int, default=0, help="which of every --parts drapes to make")
    p.add_argument("--parts", type=int, default=1)
    p.add_argument("--out", type=Path, default=RELAXED.folder)
    p.add_argument("--device", default="cpu")
    p.add_argument("--batch", type=int, default=8, help="drapes relaxed at once: 8 for a core, 256 for a GPU")
    p.add_argument("--workers", type=int, default=1, help="processes that judge drapes")
    a = p.parse_args()
    maker, started, done = Maker(a.out, a.device, a.workers), time.time(), []
    for together in missing(a.out, a.part, a.parts, a.batch):
        if time.time() - started > 60 * a.minutes:
            break
        done += maker.make(together)
        print(f"{len(done)} drapes, {round(time.time() - started)} s", flush=True)
    faults = Counter(f.result() for f in done)
    maker.pool.shutdown()
    print(f"{faults.total()} drapes, {round(time.time() - started)} s, good and by fault: {dict(faults)}")


if __name__ == "__main__":
    torch.set_num_threads(1)
    main()
