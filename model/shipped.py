"""The shipped networks as a checkpoint to train on from: `python -m shipped --out runs/shipped.pt`.

What is committed are ONNX graphs (`export.py`). Biased layers keep their names there; a layer without a bias becomes a
product with its transposed matrix, whose node still tells the layer.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import onnx
import torch
from onnx import numpy_helper
from torch import Tensor

from export import ARTIFACTS
from nets.deepsd import Sizes
from train_deepsd import RUNS, DeePSD


def weights(graph: Path) -> dict[str, Tensor]:
    """Parameters of an exported graph by their names in the network, without the wrapper's `net.`."""
    model = onnx.load(graph).graph
    constants = {i.name: torch.from_numpy(numpy_helper.to_array(i).copy()) for i in model.initializer}
    found = {name.removeprefix("net."): value for name, value in constants.items() if name.startswith("net.")}
    for node in model.node:
        if node.op_type == "MatMul" and (matrix := constants.get(node.input[1])) is not None:
            layer = ".".join(node.name.strip("/").split("/")[1:-1])
            found[f"{layer}.weight"] = matrix.T.contiguous()
    return found


def shipped(artifacts: Path = ARTIFACTS) -> DeePSD:
    """The shipped DeePSD. Raises RuntimeError where the graphs and the network's sizes differ."""
    net, folder = DeePSD(Sizes()), artifacts / "deepsd"
    net.static.load_state_dict(weights(folder / "static.onnx"))
    net.coefficients.load_state_dict(weights(folder / "dynamic.onnx"))
    return net


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--out", type=Path, default=RUNS / "shipped.pt")
    a = p.parse_args()
    a.out.parent.mkdir(parents=True, exist_ok=True)
    torch.save({"net": shipped().state_dict()}, a.out)
    print(a.out)


if __name__ == "__main__":
    main()
