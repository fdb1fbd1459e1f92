"""GarNet's time beside the simulator's on the same garment and body, one core: `python -m teacher.race`.

A fine mesh of one of GarNet's garments (`outfits.garnet_garments`); the simulator, in a random pose, from where plain
skinning and the service's resolve put it until it rests (`simulation`), then `toile bench`'s whole drape in a pose of
its own, with the resolve and the GLB: what GarNet takes does not depend on the pose.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import time
from pathlib import Path

from body.pose_sampling import sample_poses
from evaluation_set import rounded
from outfits.garnet_garments import PATTERNS, garnet_garment
from outfits.held_out import write_obj
from training_data import DATA

from .drapes import SEED, TOILE, draped, scene
from .simulation import Settings, Stage, equilibrium

RACE = DATA / "race"


def simulated(folder: Path) -> tuple[float, int]:
    """Seconds and steps until the folder's drape rests; the kernels are compiled before."""
    start = draped(folder, "skinning")
    cloth, surface = scene(start, 0, 0)
    x = start["resolved"][0, 0]
    equilibrium(cloth, x, surface, Settings((Stage(0.002, 1, 1.0),)))
    started = time.perf_counter()
    steps = equilibrium(cloth, x, surface, Settings()).steps
    return time.perf_counter() - started, steps


def bench(outfit: Path, kind: str) -> str:
    """What `toile bench` prints."""
    command = [TOILE, "bench", "--outfit", outfit, "--kind", kind]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def whole(report: str, method: str) -> float:
    """Milliseconds of a drape by a method in `toile bench`'s table. Raises ValueError where there is none."""
    table = [[c.strip() for c in line.strip("| ").split("|")] for line in report.splitlines() if line.startswith("|")]
    (heads,) = (row for row in table if row[0].startswith("stage"))
    (row,) = (row for row in table if row[0] == "whole")
    return float(row[heads.index(method)])


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--kind", choices=list(PATTERNS), default="sweater")
    p.add_argument("--density", type=int, default=9000, help="vertices a square metre")
    p.add_argument("--out", type=Path, default=RACE)
    a = p.parse_args()
    a.out.mkdir(parents=True, exist_ok=True)
    outfit = a.out / "outfit.obj"
    garment = garnet_garment(a.kind, a.density)
    write_obj(garment, outfit)
    pose = {"kind": "joints", "rotations": {name: rounded(q) for name, q in sample_poses(1, SEED)[0].items()}}
    on = {"bodies": [{"kind": "phenotypes", "values": {}}], "poses": [pose]}
    (a.out / "set.json").write_text(json.dumps(on) + "\n")
    seconds, steps = simulated(a.out)
    milliseconds = whole(bench(outfit, a.kind), "garnet")
    print(f"{a.kind} of {garment.vertex_count} vertices: simulator {seconds:.1f} s ({steps} steps), ", end="")
    print(f"garnet {milliseconds:.0f} ms, {1e3 * seconds / milliseconds:.0f} times as fast")


if __name__ == "__main__":
    main()
