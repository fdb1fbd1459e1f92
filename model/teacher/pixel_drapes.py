"""Simulated drapes that pixel cloth learns from: `python -m teacher.pixel_drapes --minutes 120`.

The T-shirt of the method, or with `--garment tie` its necktie, on the reference body in the poses of `pixel_data`,
simulated and judged as the evaluation set is (`drapes`), in fewer time steps. Chunks that are there already are kept,
so that a run can be stopped.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

from body.humanoid import Rotations
from pixel_data import COUNT, GARMENTS, PIXEL, SEED, SIMULATED, keep, worn
from pixel_poses import upper_body_poses

from .checks import Limits
from .garment import simulated


def make(job: tuple[Path, list[Rotations]], until: float, garment: str = "tee") -> Counter[str]:
    """Simulates a chunk, if there is time. How many are good (empty name) and have each fault."""
    path, poses = job
    if path.exists() or time.time() > until:
        return Counter()
    sample = GARMENTS[garment](PIXEL)
    scratch, knot = path.parent / "scratch" / path.stem, sample.held.numpy() if garment == "tie" else None
    entry, x, found = simulated(worn(sample), poses, scratch, knot=knot)
    keep(path, entry, x, found)
    faults = Counter(j.fault(Limits()) or "" for j in found)
    print(f"{path.stem}: {faults['']} of {len(poses)} good", flush=True)
    return faults


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--garment", choices=list(GARMENTS), default="tee")
    p.add_argument("--minutes", type=float, default=120)
    p.add_argument("--workers", type=int, default=2)
    a = p.parse_args()
    poses, paths, chunk = upper_body_poses(COUNT, SEED), SIMULATED.files(a.garment), SIMULATED.chunk
    jobs = [(path, poses[k * chunk : (k + 1) * chunk]) for k, path in enumerate(paths)]
    with ProcessPoolExecutor(a.workers, multiprocessing.get_context("spawn")) as pool:
        counts = pool.map(partial(make, until=time.time() + 60 * a.minutes, garment=a.garment), jobs)
        print("good and by fault:", dict(sum(counts, Counter())))


if __name__ == "__main__":
    main()
