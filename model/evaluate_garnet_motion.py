"""How near GarNet comes to drapes in captured movement: `python -m evaluate_garnet_motion CLIP`.

Frames spread over a clip of `captured` or a BVH file, on bodies of the test, every garment relaxed in each as for
training (`garnet_data`), beside the warped garment alone (Gundogdu et al. 2020, section 4.2). Drapes are kept, so that
a run can be stopped.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

import numpy as np
import torch

from body.anny_body import AnnyBody
from body.clearance import Clearance
from captured import CLIPS, Pose, clip_of, frames
from evaluate_garnet import HEADER, Figures, measured, network, row
from garnet_data import RELAXED, SPLITS, STEPS, Drape, Maker, Split
from garnet_scenes import load
from nets.garnet import Variant
from outfits.garnet_garments import PATTERNS
from training_data import ShapeValues, random_shape

#: Name and variant of each row.
ROWS: tuple[tuple[str, Variant | None], ...] = (("warped (DQS)", None), ("local", "local"))


@dataclass(frozen=True)
class Captured(Split):
    """The first bodies of the test in captured poses."""

    rotations: tuple[Pose, ...] = field(compare=False, default=())

    def clothed(self) -> list[tuple[ShapeValues, list[Pose]]]:
        return [(shape, list(self.rotations)) for shape in shapes(self.bodies, self.seed)]


def shapes(count: int, seed: int) -> list[ShapeValues]:
    """The first bodies of a split; the very first is the reference body, which is for training."""
    rng = np.random.default_rng(seed)
    return [random_shape(rng, i) for i in range(count)]


def captured(clip: str, count: int, bodies: int) -> Captured:
    """`count` frames of a clip on so many bodies of the test, of which none may meet itself."""
    body, seed = AnnyBody.load(), SPLITS[-1].seed
    clear = tuple(Clearance(body, body.shape(*shape)) for shape in shapes(bodies + 1, seed)[1:])
    poses = frames(clip_of(clip), count, clear)
    return Captured(f"{Path(clip).stem}_{count}", bodies + 1, len(poses), seed, rotations=tuple(poses))


def relaxed(split: Captured, out: Path, batch: int, steps: int = STEPS) -> None:
    """Relaxes what is not there yet of every garment."""
    maker, done = Maker(out, "cpu", 1, (split,), steps), []
    for kind in PATTERNS:
        all_of = [Drape(kind, split, body, pose) for body, pose in product(split.worn, range(split.poses))]
        mine = [d for d in all_of if not d.path(out).exists()]
        for first in range(0, len(mine), batch):
            done += maker.make(mine[first : first + batch])
            print(f"{len(done)} drapes, {kind}", flush=True)
    faults = Counter(f.result() for f in done)
    maker.pool.shutdown()
    print(f"{faults.total()} drapes, good and by fault: {dict(faults)}\n")


def table(split: Captured, out: Path) -> None:
    """Prints the figures of every garment and their mean."""
    print(HEADER)
    found: dict[str, list[Figures]] = {}
    for kind in PATTERNS:
        garment, scenes = load(kind, split, split.bank(), out)
        for name, variant in ROWS:
            if (way := network(kind, variant, "")) is not None:
                of_kind = list(measured(way, garment, scenes))
                found.setdefault(name, []).extend(of_kind)
                print(row(f"{kind}, {name}", of_kind), flush=True)
    for name, figures in found.items():
        print(row(f"all, {name}", figures))


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("clip", metavar="CLIP", help=f"a BVH file, or one of {', '.join(CLIPS)}")
    p.add_argument("--frames", type=int, default=6)
    p.add_argument("--bodies", type=int, default=2)
    p.add_argument("--out", type=Path, default=RELAXED.folder)
    p.add_argument("--batch", type=int, default=8, help="drapes relaxed at once")
    a = p.parse_args()
    split = captured(a.clip, a.frames, a.bodies)
    relaxed(split, a.out, a.batch)
    table(split, a.out)


if __name__ == "__main__":
    torch.set_num_threads(1)
    main()
