"""The shipped networks as checkpoints to train on from: `python -m shipped`.

What is committed of DeePSD and GarNet are ONNX graphs (`export.py`). Biased layers keep their names there; a layer
without a bias becomes a product with its transposed matrix, whose node still tells the layer. Of pixel cloth's T-shirt
it is the weights, batch normalisation folded in (`export_pixel.py`).
"""

from __future__ import annotations

import argparse
from pathlib import Path

import onnx
import torch
from onnx import numpy_helper
from safetensors.numpy import load_file
from torch import Tensor, nn

import nets.deepsd
import nets.garnet
from export import ARTIFACTS
from nets.garnet import GarNet
from nets.pixel_cloth import OFFSET_UNIT, PixelCloth, Sizes
from outfits.garnet_garments import PATTERNS
from pixel_data import SEED, in_poses
from pixel_filter import Filter
from pixel_poses import pose_matrices, upper_body_poses
from train_deepsd import RUNS, DeePSD
from training_data import BodyBank

#: In which pixel cloth's layers are measured.
POSES = 128


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
    net, folder = DeePSD(nets.deepsd.Sizes()), artifacts / "deepsd"
    net.static.load_state_dict(weights(folder / "static.onnx"))
    net.coefficients.load_state_dict(weights(folder / "dynamic.onnx"))
    return net


def shipped_garnet(kind: str, artifacts: Path = ARTIFACTS) -> GarNet:
    """GarNet of one kind of garment."""
    net = GarNet(nets.garnet.Sizes())
    net.load_state_dict(weights(artifacts / "garnet" / f"{kind}.onnx"))
    return net


@torch.no_grad()
def shipped_tee(poses: Tensor, artifacts: Path = ARTIFACTS) -> tuple[PixelCloth, Filter]:
    """The T-shirt's decoder, its layers normalised by what they have in some poses (P, POSE), and its filter."""
    kept = {k: torch.as_tensor(v) for k, v in load_file(artifacts / "pixel_cloth" / "tee.safetensors").items()}
    net, x = PixelCloth(Sizes()), poses[..., None, None]
    *convolutions, last = (layer for layer in net.layers if isinstance(layer, nn.ConvTranspose2d))
    norms = [layer for layer in net.layers if isinstance(layer, nn.BatchNorm2d)]
    for k, (convolution, norm) in enumerate(zip(convolutions, norms, strict=True)):
        convolution.weight.copy_(kept[f"weight{k}"])
        x = convolution(x)
        variance, mean = torch.var_mean(x, (0, 2, 3), correction=0)
        norm.running_var.copy_(variance)
        norm.running_mean.copy_(mean)
        norm.weight.copy_((variance + norm.eps).sqrt())
        norm.bias.copy_(kept[f"bias{k}"] + mean)
        x = torch.relu(norm.eval()(x))
    last.weight.copy_(kept[f"weight{len(norms)}"] / OFFSET_UNIT)
    last.bias.copy_(kept[f"bias{len(norms)}"] / OFFSET_UNIT)
    return net.eval(), Filter(kept["filter_mean"], kept["filter"])


def some_poses() -> Tensor:
    """What pixel cloth sees of poses that it learned in, (POSES, POSE)."""
    return pose_matrices(in_poses(BodyBank(0, 0, 0), upper_body_poses(POSES, SEED)).transforms)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--out", type=Path, default=RUNS / "shipped.pt", help="of DeePSD; the others go beside their own")
    found: dict[Path, dict] = {p.parse_args().out: {"net": shipped().state_dict()}}
    found[RUNS / "pixel" / "shipped_tee.pt"] = shipped_tee(some_poses())[0].state_dict()
    found |= {RUNS / "garnet" / f"shipped_{kind}.pt": shipped_garnet(kind).state_dict() for kind in PATTERNS}
    for path, state in found.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        torch.save(state, path)
        print(path)


if __name__ == "__main__":
    main()
