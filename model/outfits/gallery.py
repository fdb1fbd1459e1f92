"""The shipped demo outfits: `python -m outfits.gallery` writes artifacts/gallery/*.glb and gallery.json."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

from body.anny_body import AnnyBody

from .body_fields import body_fields
from .demos import DEMOS, Demo
from .generate import assemble
from .glb import write_glb
from .pattern import Pattern

OUT = Path(__file__).parents[1] / "artifacts" / "gallery"
WRINKLE = 0.0028


def write_demo(demo: Demo, out: Path) -> dict:
    """Sew one demo outfit, write its GLB, and return its entry of gallery.json."""
    model = AnnyBody.load()
    pieces = [replace(p, wrinkle=WRINKLE) if isinstance(p, Pattern) else p for p, _ in demo.pieces]
    cloths = [(demo.density, "isotropic")] * len(pieces)
    garments = assemble(pieces, body_fields(model, model.shape()), cloths)
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
    return entry | ({"benchmark": True} if demo.benchmark else {})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument(
        "--only", default="", help="write only demos whose name contains this; leaves gallery.json alone"
    )
    args = parser.parse_args()
    out = args.out
    out.mkdir(parents=True, exist_ok=True)
    entries = []
    for make in DEMOS:
        if args.only not in make().name:
            continue
        entries.append(write_demo(make(), out))
        print(
            entries[-1]["file"],
            entries[-1]["vertices"],
            (out / entries[-1]["file"]).stat().st_size // 1024,
            "KB",
            flush=True,
        )
    if args.only:
        return
    (out / "gallery.json").write_text(json.dumps(entries, indent=2) + "\n")


if __name__ == "__main__":
    main()
