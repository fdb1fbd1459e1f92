"""What laying cloth flat, turning it into images and wrapping it cost pixel cloth: `python -m evaluate_pixel`.

The T-shirt of the method (Jin et al. 2020, section 6.1): stretch of its panels, how far its vertices are from
where its images say they are, which no network can undo, and how even it lies on the skin. Values: places on the
reference body, and folds. Where drapes have been made (`pixel_data`) and networks trained (`train_pixel`), their tables
too.
"""

from __future__ import annotations

import argparse

import numpy as np

from body.anny_body import AnnyBody
from garment.binding import reference_surface
from garment.cloth_image import cloth_images
from garment.embedding import worn_tight
from garment.flat import stretch
from garment.graph import mesh_edges
from garment.mirror import asymmetry, opposite
from outfits.body_fields import body_fields
from outfits.garnet_garments import garnet_garment
from outfits.mesh import GarmentMesh
from outfits.panels import front_and_back
from pixel_tables import tables

#: Vertices per square metre: 2.7 thousand vertices.
DENSITY = 3000
#: m, length and depth of the folds that are carried.
FOLD_LENGTH, FOLD_DEPTH = 0.08, 0.005


def wrapping(garment: GarmentMesh) -> str:
    """A line on the cloth wrapped tight on the reference body."""
    v, t = garment.vertices, garment.triangles
    places = worn_tight(v, t).places(reference_surface().vertices)
    edges = mesh_edges(t)
    tight, rest = (np.linalg.norm(x[edges[:, 0]] - x[edges[:, 1]], axis=1) for x in (places, v))
    low, high = np.percentile(tight / rest, [1, 99])
    off = 100 * np.linalg.norm(places - v, axis=1).mean()
    return f"wrapped: {off:.1f} cm away on average, edges {low:.2f} to {high:.2f} times as long (1 to 99 %)"


def symmetry(garment: GarmentMesh) -> str:
    """A line on how far the garment is from its mirror image, which training uses."""
    v, t = garment.vertices, garment.triangles
    return f"mirrored: {1e3 * asymmetry(v, opposite(v, t)).mean():.2f} mm from itself on average"


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
    images = cloth_images(list(panels), len(v))
    print("\n| to images and back, mm | mean | 99 % of the vertices | most |\n|---|---:|---:|---:|")
    folds = FOLD_DEPTH * np.sin(2 * np.pi * v / FOLD_LENGTH)
    for name, values in (("places", v), (f"folds of {100 * FOLD_LENGTH:.0f} cm", folds)):
        back = images.joined(images.values(images.images(values[images.vertex])))
        off = 1e3 * np.linalg.norm(back - values, axis=1)
        print(f"| {name} | {off.mean():.2f} | {np.percentile(off, 99):.2f} | {off.max():.2f} |")
    print(f"\n{wrapping(garment)}\n{symmetry(garment)}")
    tables()


if __name__ == "__main__":
    main()
