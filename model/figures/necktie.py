"""The necktie of pixel cloth in poses of the test (Jin et al. 2020, Figure 17): `python -m figures.necktie`.

One row a pose, the ones in which it hangs farthest from the body; columns: where the body carries its pixels, the
network before any resolve, and simulated. Into docs/pictures/necktie.jpg.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch

from body.anny_body import AnnyBody
from pixel_data import SIMULATED, Drapes, necktie
from pixel_scenes import draped, scenes
from pixel_tables import NECKTIE, trained
from train_pixel import answers

from .drawing import CLOTH, Drawn, cell, grid
from .pixel_cloth import bodies

OUT = Path(__file__).parents[2] / "docs" / "pictures" / "necktie.jpg"


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--poses", type=int, default=4)
    p.add_argument("--out", type=Path, default=OUT)
    a = p.parse_args()
    garment, net = trained(necktie(), NECKTIE)
    test = SIMULATED.load("tie")["test"]
    away = scenes(garment, test, "reference").offsets.norm(dim=-1).amax(1)
    rows = away.argsort(descending=True)[: 2 * a.poses : 2]
    some = Drapes(test.x[rows], test.transforms[rows], test.number[rows])
    data = scenes(garment, some, "reference")
    ways = [draped(torch.zeros_like(data.offsets), garment, data), answers(net, garment, data), some.x]
    skin, faces, cloth = bodies(some).numpy(), AnnyBody.load().triangles, garment.triangles.numpy()
    dressed = lambda k, x: cell([Drawn(skin[k], faces), Drawn(x[k].numpy(), cloth, CLOTH[0])])  # noqa: E731
    columns = ("pixels on the body", "network", "simulated")
    grid([[dressed(k, x) for x in ways] for k in range(len(rows))], columns).save(a.out, quality=88)


if __name__ == "__main__":
    main()
