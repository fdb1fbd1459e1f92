"""Write pixel cloth's decoder as ONNX, checked against PyTorch, and the T-shirt's network: `python -m export_pixel`.

Under artifacts/pixel_cloth: a manifest and the decoder's graph, the same for every garment, and `tee.safetensors`: what
the garment's decoder learned and what the service needs to skin its pixels (`server/toile-drape/src/hero`).
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import torch
from safetensors.numpy import save_file
from torch import Tensor, nn
from torch.nn import functional

from export import ARTIFACTS, GraphSpec, Port, export_method
from garment.binding import garment_joint_names
from nets.pixel_cloth import OFFSET_UNIT, PixelCloth
from pixel_data import SIMULATED, shirt
from pixel_filter import Filter
from pixel_poses import JOINTS
from pixel_scenes import Garment, mask
from pixel_tables import filter_of, trained
from train_pixel import checkpoint
from training_data import Sample

METHOD, NAME = "pixel_cloth", "tee"
LAYERS = 7


class Decoder(nn.Module):
    """A network in eval mode whose weights are inputs, batch normalisation folded in."""

    def forward(self, pose: Tensor, *weights: Tensor) -> Tensor:
        x = pose[..., None, None]
        for k in range(LAYERS):
            stride, padding = (1, 0) if k == 0 else (2, 1)
            x = functional.conv_transpose2d(x, weights[2 * k], weights[2 * k + 1], stride, padding)
            x = x if k == LAYERS - 1 else torch.relu(x)
        return x


@torch.no_grad()
def folded(net: PixelCloth) -> dict[str, Tensor]:
    """What `Decoder` takes beside the pose, for images in metres: weights (in, out, 4, 4) and bias (out,) of layers."""
    layers, out = list(net.layers), {}
    for k in range(LAYERS):
        convolution, after = layers[3 * k], layers[3 * k + 1 : 3 * k + 2]
        weight, bias = convolution.weight, convolution.bias
        for norm in after:
            scale = norm.weight / (norm.running_var + norm.eps).sqrt()
            weight, bias = weight * scale[:, None, None], norm.bias - norm.running_mean * scale
        unit = OFFSET_UNIT if k == LAYERS - 1 else 1.0
        out |= {f"weight{k}": unit * weight, f"bias{k}": unit * bias}
    return out


def spec() -> GraphSpec:
    side = 4 << (LAYERS - 1)
    ports = [Port("pose", (1, "channels0"), "1", "joint")]
    for k in range(LAYERS):
        ports.append(Port(f"weight{k}", (f"channels{k}", f"channels{k + 1}", 4, 4), "1"))
        ports.append(Port(f"bias{k}", (f"channels{k + 1}",), "1"))
    images = Port("images", (1, f"channels{LAYERS}", side, side), "m", "site")
    return GraphSpec(METHOD, "decoder", Decoder(), ports, [images])


def tables(sample: Sample, garment: Garment, net: PixelCloth, smooth: Filter) -> dict[str, np.ndarray]:
    """N vertices, Q sites, as of `Garment`; joints (J, 2) of the pose, -1 for the world; mask (K, side, side).

    The filter: mean offsets (Q, 3) and components (C, 3 Q). legs (1,): whether training moved them.
    """
    names = garment_joint_names()
    number = lambda name: -1 if name is None else names.index(name)  # noqa: E731
    floats = folded(net) | {
        "rest": sample.vertices, "share": garment.share, "corner_weight": garment.frames.weight,
        "along": garment.frames.along, "pixel_weight": garment.pixel_weight,
        "filter_mean": smooth.mean, "filter": smooth.components,
    }  # fmt: skip
    indices = {
        "vertex": garment.vertex, "corner": garment.frames.corners, "around": garment.frames.around,
        "pixel": garment.pixel_of_site, "joints": torch.tensor([[number(of), number(to)] for of, to in garment.joints]),
    }  # fmt: skip
    small = {"mask": mask(garment, net.sizes.side), "legs": torch.tensor([garment.joints != JOINTS])}
    out = {name: x.numpy().astype(np.float32) for name, x in floats.items()}
    out |= {name: x.numpy().astype(np.int32) for name, x in indices.items()}
    out |= {name: x.numpy().astype(np.uint8) for name, x in small.items()}
    # Written as it lies in memory, whatever the strides.
    return {name: np.ascontiguousarray(x) for name, x in out.items()}


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--out", type=Path, default=ARTIFACTS)
    a = p.parse_args()
    if not checkpoint().exists():
        raise SystemExit("no trained network to export: run `make train-pixel` first")
    sample = shirt()
    garment, net = trained(sample)
    smooth = filter_of(sample, net, garment, SIMULATED.load())
    export_method(METHOD, [spec()], a.out)
    save_file(tables(sample, garment, net, smooth), a.out / METHOD / f"{NAME}.safetensors")


if __name__ == "__main__":
    main()
