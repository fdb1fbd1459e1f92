"""The mean of pixel cloth's networks that share their start, for the T-shirt: `python -m average_pixel a.pt b.pt`.

As of DeePSD's (`average`); what batch normalisation divides by is measured anew in the drapes that they learned.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch
from torch import Tensor, nn

from average import mean
from nets.pixel_cloth import PixelCloth, Sizes
from pixel_data import SIMULATED, shirt
from pixel_poses import pose_matrices
from train_pixel import checkpoint

#: Poses normalised by together.
BATCH = 32


@torch.no_grad()
def averaged(networks: list[dict[str, Tensor]], poses: Tensor) -> PixelCloth:
    """Of weights by name, for poses (P, POSE)."""
    net = PixelCloth(Sizes())
    net.load_state_dict(mean([{k: v.float() for k, v in kept.items()} for kept in networks]))
    for layer in net.modules():
        if isinstance(layer, nn.BatchNorm2d):
            layer.reset_running_stats()
            layer.momentum = None  # the mean of what it sees
    for some in poses.split(BATCH):
        net.train()(some)
    return net.eval()


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkpoints", type=Path, nargs="+")
    p.add_argument("--out", type=Path, default=checkpoint())
    a = p.parse_args()
    drapes = SIMULATED.load()["train"].with_mirrored(shirt())
    net = averaged([torch.load(path) for path in a.checkpoints], pose_matrices(drapes.transforms))
    torch.save(net.state_dict(), a.out)
    print(a.out)


if __name__ == "__main__":
    main()
