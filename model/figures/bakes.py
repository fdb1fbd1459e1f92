"""What a bake changes: `xvfb-run -a python -m figures.bakes summer-dress=ID wide-leg-jumpsuit=ID --data ../data`.

bakes.jpg: demo outfits, by file name, draped as they ship and as the outfit of that id in a data directory is, which
`make bake` has refined: three poses, each before and after.
"""

from __future__ import annotations

import argparse
import subprocess
from pathlib import Path

from PIL import Image

from teacher.drapes import TOILE

from .drawing import cell, grid, of_glb

ROOT = Path(__file__).parents[2]
GALLERY = ROOT / "model" / "artifacts" / "gallery"
POSES = ("sitting", "walk-2", "lunge")


def draped(outfit: str, pose: str, data: Path, scratch: Path) -> Image.Image:
    """The service's drape of an outfit's file, or of the outfit of an id in a data directory."""
    glb = scratch / "drape.glb"
    command = [TOILE, "drape", "--outfit", outfit, "--pose", pose, "--include", "outfit,body", "-o", glb]
    subprocess.run([*command, "--data", data], check=True, capture_output=True)
    return cell(of_glb(glb))


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("outfits", nargs="+", metavar="FILE=ID")
    p.add_argument("--data", type=Path, default=ROOT / "data")
    p.add_argument("--out", type=Path, default=ROOT / "docs" / "pictures")
    p.add_argument("--scratch", type=Path, default=Path("data/figures"))
    a = p.parse_args()
    a.scratch.mkdir(parents=True, exist_ok=True)
    rows = []
    for name, outfit in (pair.split("=") for pair in a.outfits):
        ways = (str(GALLERY / f"{name}.glb"), outfit)
        rows.append([draped(way, pose, a.data, a.scratch) for pose in POSES for way in ways])
    grid(rows, ("before", "after") * len(POSES)).save(a.out / "bakes.jpg", quality=85)


if __name__ == "__main__":
    main()
