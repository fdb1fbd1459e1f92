"""What laying cloth flat and turning it into images costs pixel cloth: `python -m evaluate_pixel`.

The T-shirt of the method (Jin et al. 2020, section 6.1): stretch of its panels, and how far its vertices are from
where its images say they are, which no network can undo. Values: places on the reference body, and folds.
"""

from __future__ import annotations

import argparse

import numpy as np

from body.anny_body import AnnyBody
from garment.cloth_image import Flat, cloth_images
from garment.flat import stretch
from outfits.body_fields import body_fields
from outfits.garnet_garments import garnet_garment
from outfits.panels import front_and_back

#: Vertices per square metre: 2.7 thousand vertices.
DENSITY = 3000
#: m, length and depth of the folds that are carried.
FOLD_LENGTH, FOLD_DEPTH = 0.08, 0.005


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--density", type=int, default=DENSITY, help="vertices a square metre")
    density = p.parse_args().density
    model = AnnyBody.load()
    garment = garnet_garment("tee", density).garments[0]
    panels = front_and_back(garment, body_fields(model, model.shape()))
    v = garment.vertices
    print("| panel | vertices | triangles | stretch % mean | 99 % of the triangles | most |")
    print("|---|---:|---:|---:|---:|---:|")
    for name, panel in zip(("front", "back"), panels, strict=True):
        off = 100 * np.abs(stretch(v[panel.vertices], panel.triangles, panel.places) - 1)
        counts = f"{len(panel.vertices)} | {len(panel.triangles)}"
        print(f"| {name} | {counts} | {off.mean():.1f} | {np.percentile(off, 99):.1f} | {off.max():.1f} |")
    images = cloth_images([Flat(p.vertices, p.triangles, p.places) for p in panels], len(v))
    print("\n| to images and back, mm | mean | 99 % of the vertices | most |\n|---|---:|---:|---:|")
    folds = FOLD_DEPTH * np.sin(2 * np.pi * v / FOLD_LENGTH)
    for name, values in (("places", v), (f"folds of {100 * FOLD_LENGTH:.0f} cm", folds)):
        off = 1e3 * np.linalg.norm(images.values(images.images(values)) - values, axis=1)
        print(f"| {name} | {off.mean():.2f} | {np.percentile(off, 99):.2f} | {off.max():.2f} |")


if __name__ == "__main__":
    main()
