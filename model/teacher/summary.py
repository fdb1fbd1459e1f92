"""What the simulated set is, to tell it again: `python -m teacher.summary` writes evaluation_set.json.

Counts of good and left-out drapes by outfit and fault, and a hash of each outfit's meshes, bodies, poses and drapes.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from pathlib import Path

import numpy as np

from .checks import good
from .drapes import TEACHER, faults, folders_in

OUT = Path(__file__).with_name("evaluation_set.json")


def summary(folders: list[Path]) -> dict:
    """Of a set: totals and an entry for each outfit."""
    outfits = {}
    for folder in folders:
        counts = faults([folder])
        outfits[folder.name] = {
            "good": counts.pop("", 0),
            "left_out": dict(sorted(counts.items())),
            "asked": sha256((folder / "outfit.obj").read_bytes() + (folder / "set.json").read_bytes()),
            "drapes": sha256(b"".join(positions(path) for path in sorted(folder.glob("drape_*.npz")))),
        }
    total = faults(folders)
    on = [json.loads((folder / "set.json").read_text()) for folder in folders]
    return {
        "outfits": len(folders),
        "bodies": sum(len(s["bodies"]) for s in on),
        "good": total.pop("", 0),
        "left_out": dict(sorted(total.items())),
        "by_outfit": outfits,
    }


def positions(path: Path) -> bytes:
    """Of a good drape to the tenth of a millimetre, nothing of others."""
    x = good(path)
    return b"" if x is None else np.round(1e4 * x).astype("<i4").tobytes()


def sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--drapes", type=Path, default=TEACHER)
    p.add_argument("--out", type=Path, default=OUT)
    a = p.parse_args()
    found = summary(folders_in(a.drapes))
    a.out.write_text(json.dumps(found, indent=1) + "\n")
    print({k: v for k, v in found.items() if k != "by_outfit"})


if __name__ == "__main__":
    main()
