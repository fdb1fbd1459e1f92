"""Golden vectors of pixel cloth that the Rust tests replay: `python -m goldens_pixel`.

The T-shirt on the reference body in two preset poses, its legs standing: what the network sees of them and posed
vertices (before the resolve) by the exported network, all computed here, into artifacts/golden/pixel_cloth.safetensors.
"""

from __future__ import annotations

import json

import numpy as np
import torch
from safetensors.numpy import load_file, save_file

from body.anny_body import AnnyBody
from export import ARTIFACTS, run_onnx
from export_pixel import METHOD, NAME
from goldens_deepsd import POSES, in_golden_poses, small_bank
from nets.pixel_cloth import at_sites, vertices
from pixel_data import shirt
from pixel_filter import Filter
from pixel_poses import LEGS, pose_matrices
from pixel_scenes import Garment
from training_data import Sample, ShapedPoses

OUT = ARTIFACTS / "golden" / f"{METHOD}.safetensors"


def tensors(sample: Sample, entry: ShapedPoses) -> dict[str, np.ndarray]:
    garment = Garment.of(sample)
    pose = pose_matrices(entry.transforms)
    kept = load_file(ARTIFACTS / METHOD / f"{NAME}.safetensors")
    weights = {k: v for k, v in kept.items() if k.startswith(("weight", "bias"))}
    decoder = ARTIFACTS / METHOD / "decoder.onnx"
    images = [run_onnx(decoder, {"pose": p[None].numpy()} | weights)[0] for p in pose]
    offsets = at_sites(torch.as_tensor(np.concatenate(images)), garment.pixel_of_site, garment.pixel_weight)
    offsets = Filter(torch.as_tensor(kept["filter_mean"]), torch.as_tensor(kept["filter"])).apply(offsets)
    places, axes = garment.frames.places(entry.vertices), garment.frames.axes(entry.vertices, entry.normals)
    cloth = lambda offsets: vertices(offsets, places, axes, garment.vertex, garment.share).numpy()  # noqa: E731
    return {
        "vertices": sample.vertices.numpy(), "triangles": sample.tables[2].numpy().astype(np.uint32),
        "pose": pose.numpy(), "tight": cloth(torch.zeros_like(offsets)), "posed": cloth(offsets),
    }  # fmt: skip


def main() -> None:
    body = AnnyBody.load()
    data = tensors(shirt(), in_golden_poses(body, small_bank(body), {}, LEGS))
    save_file(
        {k: np.ascontiguousarray(v) for k, v in data.items()},
        OUT,
        {"poses": json.dumps(POSES)},
    )
    print({k: v.shape for k, v in data.items()})


if __name__ == "__main__":
    main()
