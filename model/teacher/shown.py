"""Simulated drapes of demo outfits, which the page shows beside the methods: `python -m teacher.shown`.

On the reference body in preset poses, simulated and judged as the evaluation set is (`drapes`). Good ones are written
under artifacts/simulated, where the service finds them by the outfit's file name; others are told and left out.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors.numpy import save_file

from export import ARTIFACTS
from training_data import DATA

from .checks import Limits
from .drapes import draped, settled

#: Demo outfits whose garments have networks of their own beside the shared one.
OUTFITS = ("hero-t-shirt", "tea-dress", "linen-t-shirt-and-chinos")
POSES = ("standing", "walk-2", "reach")
REFERENCE = {"kind": "phenotypes", "values": {}}


@dataclass(frozen=True)
class Shown:
    """What came to rest of one outfit."""

    poses: tuple[str, ...]
    cloth: NDArray[np.float32]  # (D, N, 3) world, metres, welded order


def ask(scratch: Path, poses: tuple[str, ...]) -> None:
    """Says in a folder what an outfit is to be draped on (`drapes.draped`)."""
    scratch.mkdir(parents=True, exist_ok=True)
    presets = [{"kind": "preset", "id": name} for name in poses]
    (scratch / "set.json").write_text(json.dumps({"bodies": [REFERENCE], "poses": presets}) + "\n")


def simulate(outfit: Path, poses: tuple[str, ...], scratch: Path) -> Shown:
    """Simulates an outfit in preset poses and keeps what is good."""
    ask(scratch, poses)
    start, kept = draped(scratch, "skinning", outfit), {}
    for k, name in enumerate(poses):
        end, judged = settled(start, 0, k)
        fault = judged.fault(Limits())
        print(f"{outfit.stem} {name}: {end.steps} steps, {fault or 'good'}", flush=True)
        if not fault:
            kept[name] = end.x.astype(np.float32)
    return Shown(tuple(kept), np.stack(list(kept.values())) if kept else np.zeros((0, 0, 3), np.float32))


def write(shown: Shown, path: Path) -> None:
    """Writes drapes as the service reads them."""
    path.parent.mkdir(parents=True, exist_ok=True)
    on = [{"body": REFERENCE, "pose": {"kind": "preset", "id": name}} for name in shown.poses]
    save_file({"cloth": shown.cloth}, path, {"drapes": json.dumps(on)})
    path.chmod(0o644)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("outfits", nargs="*", default=OUTFITS, help="names of demo outfits")
    p.add_argument("--poses", nargs="+", default=POSES)
    a = p.parse_args()
    for name in a.outfits:
        shown = simulate(ARTIFACTS / "gallery" / f"{name}.glb", tuple(a.poses), DATA / "shown" / name)
        if shown.poses:
            write(shown, ARTIFACTS / "simulated" / f"{name}.safetensors")


if __name__ == "__main__":
    main()
