"""Write the trained GarNets, local variant, as ONNX, checked against PyTorch: `python -m export_garnet`.

One graph a garment under artifacts/garnet, and a manifest. Gathers are padded tables, so that the graphs take any
number of nodes and body points.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch
from torch import Tensor, nn

from export import ARTIFACTS, GraphSpec, Port, export_method
from garment.garnet_tables import RING
from nets.garnet import AVERAGED, POOLED, GarNet, Neighbours, Sizes
from outfits.garnet_garments import PATTERNS
from train_garnet import checkpoint


class ExportedGarNet(nn.Module):
    """GarNet of one drape with flat arguments, in the order of the manifest."""

    def __init__(self, net: GarNet) -> None:
        super().__init__()
        self.net = net

    def forward(self, garment: Tensor, turn: Tensor, body: Tensor, *tables: Tensor) -> Tensor:
        ring, ring_weight, thinned, pooled = tables
        near = Neighbours(ring, ring_weight, thinned, pooled[None])
        return self.net(garment[None], turn[None], body[None], near)[0]


def spec(kind: str, net: GarNet) -> GraphSpec:
    """The graph of one garment, local variant; positions are less the middle of the nodes, warped and at rest."""
    inputs = [
        Port("garment", ("nodes", 6), "m", "world, rest"),
        Port("turn", ("nodes", 3, 3), "1", "world from rest"),
        Port("body", ("points", 3), "m", "world"),
        Port("ring", ("nodes", RING), "index", dtype="int64"),
        Port("ring_weight", ("nodes", RING), "1"),
        Port("thinned", ("thinned", AVERAGED), "index", dtype="int64"),
        Port("pooled", ("nodes", POOLED), "index", dtype="int64"),
    ]
    return GraphSpec("garnet", kind, ExportedGarNet(net), inputs, [Port("translations", ("nodes", 3), "m", "world")])


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--curvature", choices=["", "rq", "mc"], default="")
    p.add_argument("--out", type=Path, default=ARTIFACTS)
    a = p.parse_args()
    nets = {}
    for kind in PATTERNS:
        path = checkpoint(kind, "local", a.curvature)
        if path.exists():
            nets[kind] = GarNet(Sizes())
            nets[kind].load_state_dict(torch.load(path))
    if not nets:
        raise SystemExit("no trained network to export: run `make train-garnet` first")
    export_method("garnet", [spec(kind, net) for kind, net in nets.items()], a.out)


if __name__ == "__main__":
    main()
