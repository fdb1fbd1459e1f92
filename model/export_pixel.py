"""Write the trained pixel cloth as ONNX, checked against PyTorch, with its garment's tables: `python -m export_pixel`.

Under artifacts/pixel_cloth: a manifest, and for each garment `NAME.onnx` and `NAME.safetensors`, what the service needs
to skin its pixels (`server/toile-drape/src/hero`).
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import torch
from safetensors.numpy import save_file
from torch import Tensor, nn

from export import ARTIFACTS, GraphSpec, Port, export_method
from garment.binding import garment_joint_names
from nets.pixel_cloth import PixelCloth
from pixel_data import load, shirt
from pixel_filter import Filter
from pixel_poses import JOINTS, POSE
from pixel_scenes import Garment, mask
from pixel_tables import filter_of
from train_pixel import checkpoint, network
from training_data import Sample

METHOD, NAME = "pixel_cloth", "tee"


class ExportedPixelCloth(nn.Module):
    """The decoder of one pose."""

    def __init__(self, net: PixelCloth) -> None:
        super().__init__()
        self.net = net

    def forward(self, pose: Tensor) -> Tensor:
        return self.net(pose)


def spec(net: PixelCloth) -> GraphSpec:
    side = net.sizes.side
    images = Port("images", (1, 3 * net.sizes.images, side, side), "m", "site")
    return GraphSpec(METHOD, NAME, ExportedPixelCloth(net), [Port("pose", (1, POSE), "1", "joint")], [images])


def tables(sample: Sample, garment: Garment, smooth: Filter) -> dict[str, np.ndarray]:
    """N vertices, Q sites, as of `Garment`; joints (10, 2) of the pose, -1 for the world; mask (K, side, side).

    The filter: mean offsets (Q, 3) and components (C, 3 Q).
    """
    names = garment_joint_names()
    number = lambda name: -1 if name is None else names.index(name)  # noqa: E731
    floats = {
        "rest": sample.vertices, "share": garment.share, "corner_weight": garment.frames.weight,
        "along": garment.frames.along, "pixel_weight": garment.pixel_weight,
        "filter_mean": smooth.mean, "filter": smooth.components,
    }  # fmt: skip
    indices = {
        "vertex": garment.vertex, "corner": garment.frames.corners, "around": garment.frames.around,
        "pixel": garment.pixel_of_site, "joints": torch.tensor([[number(of), number(to)] for of, to in JOINTS]),
    }  # fmt: skip
    out = {name: x.numpy().astype(np.float32) for name, x in floats.items()}
    out |= {name: x.numpy().astype(np.int32) for name, x in indices.items()}
    return out | {"mask": mask(garment, network(garment).sizes.side).numpy().astype(np.uint8)}


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--out", type=Path, default=ARTIFACTS)
    a = p.parse_args()
    path = checkpoint("l1", 0.01, "reference", patched=False)
    if not path.exists():
        raise SystemExit("no trained network to export: run `make train-pixel` first")
    sample = shirt()
    garment = Garment.of(sample)
    net = network(garment)
    net.load_state_dict(torch.load(path))
    smooth = filter_of(net.eval(), garment, {split: load(split) for split in ("train", "validation")})
    export_method(METHOD, [spec(net)], a.out)
    # Written as it lies in memory, whatever the strides.
    data = {name: np.ascontiguousarray(x) for name, x in tables(sample, garment, smooth).items()}
    save_file(data, a.out / METHOD / f"{NAME}.safetensors")


if __name__ == "__main__":
    main()
