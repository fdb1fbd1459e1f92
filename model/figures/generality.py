"""What an outfit's mesh may be: `xvfb-run -a python -m figures.generality`, as section 5.5 and figure 7 of the paper.

generality.jpg: one unseen outfit at a quarter of, once and four times the vertices; in four triangulations; outfits
of three layers; ornaments. Draped by `toile drape` in one pose, resolved.
"""

from __future__ import annotations

import argparse
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from body.anny_body import AnnyBody
from outfits.body_fields import body_fields
from outfits.dataset import VALIDATION_SEED
from outfits.families import patterns
from outfits.generate import assemble, generate
from outfits.held_out import held_out, write_obj
from outfits.mesh import OutfitMesh
from outfits.resolutions import coarser, four_times
from outfits.sew import TRIANGULATIONS
from teacher.drapes import TOILE

from .drawing import cell, grid, of_glb

OUT = Path(__file__).parents[2] / "docs" / "pictures"
POSE = "walk-2"
DENSITY = 1300  # vertices per square metre


def resolutions() -> list[OutfitMesh]:
    """The wrap skirt and tank top, coarse to fine."""
    outfit = dict(held_out(5))[4]
    changes = (lambda g: coarser(g, 0.25), lambda g: g, four_times)
    return [replace(outfit, garments=[change(g) for g in outfit.garments]) for change in changes]


def triangulations() -> list[OutfitMesh]:
    """A tunic and leggings, sewn in every style."""
    model = AnnyBody.load()
    fields = body_fields(model, model.shape())
    out = []
    for style in TRIANGULATIONS:
        worn = patterns(np.random.default_rng(VALIDATION_SEED), "tunic_leggings")
        out.append(OutfitMesh(style, 0, assemble(worn, fields, [(DENSITY, style)] * len(worn))))
    return out


def of_families(*families: str) -> list[OutfitMesh]:
    """Outfits that training has not seen."""
    return [generate(VALIDATION_SEED + 700 + i, family) for i, family in enumerate(families)]


def drawn(outfit: OutfitMesh, name: str, scratch: Path, edges: bool) -> Image.Image:
    """The service's drape of an outfit."""
    obj, glb = scratch / f"{name}.obj", scratch / f"{name}.glb"
    write_obj(outfit, obj)
    command = [TOILE, "drape", "--outfit", obj, "--pose", POSE, "--include", "outfit,body", "-o", glb]
    subprocess.run(command, check=True, capture_output=True)
    return cell(of_glb(glb, edges))


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--out", type=Path, default=OUT)
    p.add_argument("--scratch", type=Path, default=Path("data/figures"))
    a = p.parse_args()
    a.scratch.mkdir(parents=True, exist_ok=True)
    rows = {
        "resolutions": resolutions(),
        "triangulations": triangulations(),
        "layers": of_families("waistcoat_shirt_trousers", "jacket_shirt_trousers", "lapelled_jacket", "jacket_dress"),
        "ornaments": of_families("shirt_tie_trousers", "dress_bow", "belted_dress", "collared_shirt_trousers"),
    }
    pictures = [
        [drawn(o, f"{name}_{i}", a.scratch, name in ("resolutions", "triangulations")) for i, o in enumerate(outfits)]
        for name, outfits in rows.items()
    ]
    grid(pictures, names=tuple(rows)).save(a.out / "deepsd-generality.jpg", quality=85)


if __name__ == "__main__":
    main()
