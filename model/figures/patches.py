"""Pixel cloth in patches (Jin et al. 2020, Figures 11 and 15): `python -m figures.patches`.

One row a pose of the test, before any resolve: the patches, each in a colour, as their networks have them (`train_pixel
--patches`), the same in one colour, filtered as one mesh, the whole's network after as many steps, and simulated. Into
docs/pictures/patches.jpg.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from body.anny_body import AnnyBody
from outfits.body_fields import body_fields
from outfits.mesh import GarmentMesh
from outfits.panels import front_and_back, patches
from pixel_data import SIMULATED, shirt
from pixel_filter import offsets_of
from pixel_scenes import Garment, draped, scenes
from pixel_tables import PATCHES, SECTION_8, TEE, components_of, trained
from train_pixel import answers

from .drawing import CLOTH, Drawn, Floats, Ints, cell, grid
from .pixel_cloth import bodies, spread

OUT = Path(__file__).parents[2] / "docs" / "pictures" / "patches.jpg"
#: Of the filter, as many as validation chooses for patches (`evaluate_pixel`).
COMPONENTS = 256
TITLES = ("patches", "their networks", "filtered", "one network", "simulated")


def patched(v: Floats, t: Ints) -> list[Ints]:
    """Triangles, (T, 3), of every patch of the T-shirt."""
    body = AnnyBody.load()
    mesh, shape = GarmentMesh("tee", "tee", 0, v, t), body_fields(body, body.shape())
    return [p.vertices[p.triangles] for p in patches(list(front_and_back(mesh, shape)), mesh, shape)]


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--rows", type=int, default=3)
    p.add_argument("--out", type=Path, default=OUT)
    a = p.parse_args()
    sample, sets = shirt(), SIMULATED.load()
    whole, (garment, net) = Garment.of(sample), trained(sample, PATCHES, SECTION_8)
    some = spread(sets["test"], a.rows)
    said = answers(net, garment, scenes(garment, some, "reference"))
    data = scenes(whole, some, "reference")
    filtered = draped(components_of(sample, whole, sets).apply(offsets_of(said, whole, data), COMPONENTS), whole, data)
    one = answers(trained(sample, TEE, SECTION_8)[1], whole, data)
    skin, faces, t = bodies(some).numpy(), AnnyBody.load().triangles, whole.triangles.numpy()
    parts = patched(sample.vertices.double().numpy(), t)
    body = [Drawn(s, faces) for s in skin]
    coloured = lambda x: [Drawn(x, part, CLOTH[i % len(CLOTH)]) for i, part in enumerate(parts)]  # noqa: E731
    cells = [
        [cell([b, *coloured(x[0].numpy())]), *(cell([b, Drawn(y.numpy(), t, CLOTH[0])]) for y in x)]
        for b, x in zip(body, zip(said, filtered, one, some.x, strict=True), strict=True)
    ]
    grid(cells, TITLES).save(a.out, quality=88)


if __name__ == "__main__":
    main()
