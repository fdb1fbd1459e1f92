"""Simulated drapes of the garments that GarNet drapes: `python -m teacher.garnet_drapes --minutes 120`.

On the bodies of `garnet_data` in captured movement, half of those to train on in its random poses, simulated and judged
as the evaluation set is (`drapes`), in fewer time steps. Drapes that are there already are kept, so that a run can be
stopped; the garments take turns, and test drapes come with the first training poses.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from functools import cache, partial
from itertools import product
from pathlib import Path

import numpy as np

from body.humanoid import Rotations
from garnet_data import SIMULATED, Drape, Split, samples
from outfits.garnet_garments import PATTERNS
from pixel_data import worn
from training_data import ShapeValues

from .checks import Limits
from .garment import simulated

#: Poses of a garment on one body that are asked of the service at once.
TOGETHER = 4


@cache
def bodies(split: Split) -> list[tuple[ShapeValues, list[Rotations]]]:
    """A split's bodies, each with its poses."""
    return split.clothed()


def jobs() -> Iterator[list[Drape]]:
    """All drapes, some of one garment on one body at a time."""
    for first in range(0, max(s.poses for s in SIMULATED.splits), TOGETHER):
        for split in SIMULATED.splits:
            poses = range(first, min(first + TOGETHER, split.poses))
            for body, kind in product(split.worn if poses else (), PATTERNS):
                yield [Drape(kind, split, body, pose) for pose in poses]


def make(together: list[Drape], out: Path, until: float) -> Counter[str]:
    """Simulates what is not there yet, if there is time. How many are good (empty name) and have each fault."""
    missing = [d for d in together if not d.path(out).exists()]
    if not missing or time.time() > until:
        return Counter()
    of = missing[0]
    values, poses = bodies(of.split)[of.body]
    scratch = out / "scratch" / f"{of.garment}_{of.split.name}_{of.body}"
    _, x, found = simulated(worn(samples(out)[of.garment]), [poses[d.pose] for d in missing], scratch, values)
    for drape, cloth, judged in zip(missing, x, found, strict=True):
        path = drape.path(out)
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part.npz")
        np.savez(part, x=cloth, **asdict(judged))
        part.rename(path)
    faults = Counter(j.fault(Limits()) or "" for j in found)
    print(f"{of.garment} of {of.split.name} on body {of.body}: {faults['']} of {len(missing)} good", flush=True)
    return faults


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--minutes", type=float, default=120)
    p.add_argument("--out", type=Path, default=SIMULATED.folder)
    p.add_argument("--workers", type=int, default=2)
    a = p.parse_args()
    samples(a.out)
    until = time.time() + 60 * a.minutes
    with ProcessPoolExecutor(a.workers, multiprocessing.get_context("spawn")) as pool:
        counts = pool.map(partial(make, out=a.out, until=until), jobs())
        print("good and by fault:", dict(sum(counts, Counter())))


if __name__ == "__main__":
    main()
