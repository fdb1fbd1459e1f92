"""GarNet's drapes between the garment as warped and as relaxed: `python -m figures.garnet`.

One row a garment, on test bodies (Gundogdu et al. 2020, Figures 10 to 14), into docs/pictures/garnet.jpg.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch
from PIL import Image

from evaluate_garnet import ROWS, network
from garnet_data import RELAXED, SPLITS
from garnet_scenes import Garment, Scenes, load
from outfits.garnet_garments import PATTERNS
from training_data import BodyBank

from .drawing import CLOTH, Drawn, cell, grid

OUT = Path(__file__).parents[2] / "docs" / "pictures" / "garnet.jpg"


@torch.no_grad()
def row(kind: str, garment: Garment, one: Scenes, bank: BodyBank) -> list[Image.Image]:
    """A drape of one by every trained network, after it as warped and before it as relaxed."""
    body, pose = one.which[0].tolist()
    skin = bank.entries[body].vertices[pose]
    skin = skin + (one.body[0] - skin[garment.points]).mean(0)
    ways = [network(kind, variant, curved) for _, variant, curved in ROWS]
    cloths = [way(garment, one)[0] for way in ways if way is not None]
    dressed = lambda x: [  # noqa: E731
        Drawn(skin.numpy(), bank.triangles.numpy()),
        Drawn(x.numpy(), garment.triangles.numpy(), CLOTH[0]),
    ]
    return [cell(dressed(x)) for x in [*cloths, one.truth[0]]]


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--drapes", type=Path, default=RELAXED.folder)
    p.add_argument("--each", type=int, default=1, help="drapes of each garment")
    p.add_argument("--out", type=Path, default=OUT)
    a = p.parse_args()
    split, rows = SPLITS[2], []
    bank = split.bank()
    for kind in PATTERNS:
        garment, scenes = load(kind, split, bank, a.drapes)
        for k in torch.linspace(0, len(scenes) - 1, a.each + 2)[1:-1].long():
            rows.append(row(kind, garment, scenes.pick(k[None]), bank))
    titles = tuple(name for name, variant, curved in ROWS if network("tee", variant, curved) is not None)
    grid(rows, (*titles, "relaxed")).save(a.out, quality=88)


if __name__ == "__main__":
    main()
