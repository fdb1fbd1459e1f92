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
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from outfits.dataset import save
from outfits.garnet_garments import DENSITY, PATTERNS, garnet_garment
from relax import follow
from teacher.checks import Judged, Limits, judge
from training_data import DATA, BodyBank, Sample, ShapedPoses, carry, load_sample

GARNET = DATA / "garnet"
#: Steps of a relaxation: the map must repeat, so cloth comes nearer to rest than targets of DeePSD need.
STEPS = 160


@dataclass(frozen=True)
class Split:
    """Bodies of one set, and poses of each."""

    name: str
    bodies: int
    poses: int
    seed: int

    def bank(self) -> BodyBank:
        return BodyBank(self.bodies, self.poses, self.seed)

    @property
    def worn(self) -> range:
        """Bodies that are dressed: the first of every bank is the reference body, which is for training only."""
        return range(0 if self.name == "train" else 1, self.bodies)


#: No body is in two of them.
SPLITS = (Split("train", 80, 16, 7_001), Split("validation", 5, 8, 7_002), Split("test", 17, 8, 7_003))


@dataclass(frozen=True)
class Drape:
    """One to make."""

    garment: str
    split: Split
    body: int
    pose: int

    def path(self, out: Path) -> Path:
        return out / self.garment / self.split.name / f"{self.body:03d}_{self.pose:02d}.npz"


def drapes(splits: tuple[Split, ...] = SPLITS) -> Iterator[Drape]:
    """All of them; the garments take turns, and test drapes come with the first training poses."""
    for pose in range(max(s.poses for s in splits)):
        for split in splits:
            if pose < split.poses:
                for body, garment in itertools.product(split.worn, PATTERNS):
                    yield Drape(garment, split, body, pose)


def make(drape: Drape, sample: Sample, bank: BodyBank, out: Path) -> str:
    """Relaxes one drape and keeps it with its judgement. Returns its fault, empty for none."""
    entry, path = bank.entries[drape.body], drape.path(out)
    rest, mesh = carry(sample, bank, entry)
    x = follow(sample, rest, mesh, bank, entry, drape.pose, STEPS)[0]
    judged = judged_on(x, rest, sample, entry, drape.pose, bank)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part.npz")
    np.savez(part, x=x.numpy(), **asdict(judged))
    part.rename(path)
    return judged.fault(Limits()) or ""


def judged_on(x: Tensor, rest: Tensor, sample: Sample, entry: ShapedPoses, pose: int, bank: BodyBank) -> Judged:
    """Figures of cloth x (N, 3) by the simulator's measure; relaxation ends where it ends, so no residual."""
    drawn, surface = rest.double().numpy(), (entry.vertices[pose].double().numpy(), bank.triangles.numpy())
    return judge(x.double().numpy(), 0.0, (drawn, drawn), sample.tables[2].numpy(), surface)


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
    p.add_argument("--out", type=Path, default=GARNET)
    a = p.parse_args()
    garments, banks, started, faults = samples(a.out), {s.name: s.bank() for s in SPLITS}, time.time(), Counter()
    for drape in itertools.islice(drapes(), a.part, None, a.parts):
        if time.time() - started > 60 * a.minutes:
            break
        if not drape.path(a.out).exists():
            faults[make(drape, garments[drape.garment], banks[drape.split.name], a.out)] += 1
            if faults.total() % 50 == 0:
                print(f"{faults.total()} drapes, {round(time.time() - started)} s, faults {dict(faults)}", flush=True)
    print(f"{faults.total()} drapes, {round(time.time() - started)} s, good and by fault: {dict(faults)}")


if __name__ == "__main__":
    torch.set_num_threads(1)
    main()
