"""Pixel cloth beside DeePSD and the simulated cloth, in poses of the test: `python -m figures.pixel_cloth`.

One row a pose (Jin et al. 2020, Figures 4, 8 and 15), before any resolve, into docs/pictures/pixel-cloth.jpg.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch
from torch import Tensor

from body.anny_body import AnnyBody
from garment.binding import reference_surface
from pixel_data import SIMULATED, Drapes, shirt
from pixel_filter import offsets_of
from pixel_scenes import Garment, Scenes, draped, scenes
from pixel_tables import deepsd, served
from train_pixel import answers

from .drawing import CLOTH, Drawn, cell, grid

OUT = Path(__file__).parents[2] / "docs" / "pictures" / "pixel-cloth.jpg"
TITLES = ("pixels on the body", "deepsd", "pixel cloth, network", "filtered", "simulated")


def bodies(drapes: Drapes) -> Tensor:
    """The reference body in every pose, (D, V, 3)."""
    surface = reference_surface()
    rest, skin = (torch.as_tensor(x, dtype=torch.float32) for x in (surface.vertices, surface.skin))
    moved = (skin @ drapes.transforms.flatten(2)).unflatten(2, (3, 4))
    return (moved[..., :3] @ rest[..., None])[..., 0] + moved[..., 3]


def spread(drapes: Drapes, count: int) -> Drapes:
    """Some of all drapes, evenly."""
    rows = torch.linspace(0, len(drapes.x) - 1, count + 2)[1:-1].long()
    return Drapes(drapes.x[rows], drapes.transforms[rows], drapes.number[rows])


def ways(data: Scenes, some: Drapes) -> list[Tensor]:
    """Cloth of every column, (D, N, 3) each."""
    sample = shirt()
    garment, net, smooth = served(sample)
    said = answers(net, garment, data)
    filtered = draped(smooth.apply(offsets_of(said, garment, data)), garment, data)
    return [draped(torch.zeros_like(data.offsets), garment, data), deepsd(sample, some), said, filtered, some.x]


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--rows", type=int, default=4)
    p.add_argument("--out", type=Path, default=OUT)
    a = p.parse_args()
    some = spread(SIMULATED.load()["test"], a.rows)
    garment = Garment.of(shirt())
    columns = ways(scenes(garment, some, "reference"), some)
    skin, faces = bodies(some).numpy(), AnnyBody.load().triangles
    cloth = garment.triangles.numpy()
    dressed = lambda k, x: cell([Drawn(skin[k], faces), Drawn(x[k].numpy(), cloth, CLOTH[0])])  # noqa: E731
    grid([[dressed(k, x) for x in columns] for k in range(a.rows)], TITLES).save(a.out, quality=88)


if __name__ == "__main__":
    main()
