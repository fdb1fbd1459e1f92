"""The shipped demo outfits: `python -m outfits.gallery` writes artifacts/gallery/*.glb and gallery.json."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

from body.anny_body import AnnyBody

from .body_fields import body_fields
from .demos import DEMOS, Demo
from .fabrics import Fabric, hex_colour
from .generate import assemble
from .glb import write_glb
from .hero import hero_tee
from .pattern import Pattern

OUT = Path(__file__).parents[1] / "artifacts" / "gallery"
WRINKLE = 0.0028
HERO, HERO_FILE = "Hero T-shirt", "hero-t-shirt.glb"


def write_demo(demo: Demo, out: Path) -> dict:
    """Sew one demo outfit, write its GLB, and return its entry of gallery.json."""
    model = AnnyBody.load()
    pieces = [replace(p, wrinkle=WRINKLE) if isinstance(p, Pattern) else p for p, _ in demo.pieces]
    cloths = [(demo.density, "isotropic")] * len(pieces)
    garments = assemble(pieces, body_fields(model, model.shape()), cloths, seamed=True)
    for garment, (_, fabric) in zip(garments, demo.pieces, strict=True):
        garment.material["fabric"] = fabric
    file = demo.name.lower().replace(",", "").replace(" ", "-") + ".glb"
    write_glb(garments, out / file, demo.name)
    entry = {
        "file": file,
        "name": demo.name,
        "description": demo.description,
        "layers": [g.name for g in garments],
        "vertices": sum(len(g.vertices) for g in garments),
        "triangles": sum(len(g.triangles) for g in garments),
    }
    entry |= {"kinds": dict(demo.kinds)} if demo.kinds else {}
    return entry | ({"benchmark": True} if demo.benchmark else {})


def write_hero(out: Path) -> dict:
    """The garment that pixel cloth drapes, its panels as UVs, and its entry of gallery.json."""
    garment = hero_tee()
    garment.material["fabric"] = Fabric("stripes", (hex_colour("#f0ede4"), hex_colour("#2c3c63")), 0.17, 0.88, 0.2, 14)
    write_glb([garment], out / HERO_FILE, HERO)
    return {
        "file": HERO_FILE,
        "name": HERO,
        "description": "A T-shirt with a network of its own, which draws its folds as images.",
        "layers": [garment.name],
        "vertices": len(garment.vertices),
        "triangles": len(garment.triangles),
        "kinds": {garment.name: "tee"},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--only", default="", help="write only the demos whose names contain this")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    index = args.out / "gallery.json"
    known = {e["name"]: e for e in json.loads(index.read_text())} if args.only and index.exists() else {}
    for demo in (make() for make in DEMOS):
        if args.only in demo.name:
            known[demo.name] = write_demo(demo, args.out)
            print(known[demo.name]["file"], known[demo.name]["vertices"], "vertices", flush=True)
    if args.only in HERO:
        known[HERO] = write_hero(args.out)
    order = [*(make().name for make in DEMOS), HERO]
    entries = sorted(known.values(), key=lambda e: order.index(e["name"]))
    index.write_text(json.dumps(entries, indent=2) + "\n")


if __name__ == "__main__":
    main()
