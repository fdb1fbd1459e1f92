"""How far pixel cloth holds on bodies that it was not trained on: `python -m evaluate_pixel_bodies`.

The T-shirt carried to each body of the evaluation set, simulated there in poses of the upper body that training did not
have, and what skinning, DeePSD and pixel cloth say of it, before any resolve. Pixel cloth in two ways: pixels that go
with the skin of the other body, offsets as on the reference body (section 8.2); and as the service has it, DeePSD's
drape with what the network says beyond DeePSD's on the reference body.
"""

from __future__ import annotations

import argparse
import json

import torch

import train_deepsd
from export import ARTIFACTS
from pixel_data import shirt, worn
from pixel_filter import offsets_of
from pixel_poses import upper_body_poses
from pixel_scenes import draped, on_body
from pixel_tables import off, served
from relax import skinned
from shipped import shipped
from teacher.checks import Limits
from teacher.garment import simulated
from train_pixel import answers
from training_data import DATA, BodyBank, carry

SEED = 77_001


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--poses", type=int, default=6)
    a = p.parse_args()
    poses, sample, bank = upper_body_poses(a.poses, SEED), shirt(), BodyBank(0, 0, 0)
    garment, net, smooth = served(sample)
    shared = shipped().eval()
    ways = ("skinning", "deepsd", "pixels on it", "served")
    print(f"| body | drapes | {' | '.join(f'{way} cm | degrees' for way in ways)} |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|")
    beyond = torch.zeros(0)
    for shape in json.loads((ARTIFACTS / "evaluation.json").read_text())["bodies"]:
        entry, x, found = simulated(worn(sample), poses, DATA / "pixel_bodies", (shape["values"], {}))
        good = torch.tensor([j.fault(Limits()) is None for j in found])
        truth, every = torch.as_tensor(x), torch.arange(a.poses)
        rest, _ = carry(sample, bank, entry)
        data = on_body(garment, entry.transforms, entry.vertices, entry.normals, truth)
        with torch.no_grad():
            bare = skinned(sample, rest.expand_as(truth), entry.transforms).posed
            by_deepsd = train_deepsd.drape(shared, sample, rest, entry, every, bank.parents).posed
            offsets = smooth.apply(offsets_of(answers(net, garment, data), garment, data))
            by_pixels = draped(offsets, garment, data)
        beyond = by_pixels - by_deepsd if not shape["values"] else beyond  # the reference body comes first
        found_by = [bare, by_deepsd, by_pixels, by_deepsd + beyond]
        name = ", ".join(f"{k} {v}" for k, v in shape["values"].items()) or "reference"
        cells = " | ".join(off(way[good], truth[good], garment.triangles) for way in found_by)
        print(f"| {name} | {int(good.sum())} | {cells} |", flush=True)


if __name__ == "__main__":
    torch.set_num_threads(1)
    main()
