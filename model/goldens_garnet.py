"""Golden vectors of GarNet that the Rust tests replay: `python -m goldens_garnet`.

The T-shirt on one body in two preset poses: nodes as warped, what is seen of the body, translations by the exported
network and posed vertices (before the resolve), all computed here, into artifacts/golden/garnet.safetensors.
"""

from __future__ import annotations

import json
from dataclasses import astuple
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import torch
from safetensors.numpy import save_file

from body.anny_body import AnnyBody
from export import ARTIFACTS, run_onnx
from garment import garnet_tables as tables
from garnet_scenes import Garment, Warped, warped_on
from goldens_deepsd import POSES, SHAPE, reference_entry, small_bank
from nets.garnet import POOLED
from outfits.dataset import save
from outfits.garnet_garments import garnet_garment
from training_data import Sample, carry, load_sample

OUT = ARTIFACTS / "golden" / "garnet.safetensors"
KIND = "tee"


def tensors(sample: Sample, raw: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    body = AnnyBody.load()
    bank = small_bank(body)
    entry = reference_entry(body, bank)
    garment = Garment.of(sample, bank)
    rest = carry(sample, bank, entry)[0].double().numpy()
    warped = warped_on(sample, garment, rest, entry.transforms.double().numpy())
    frames = zip(*astuple(warped), entry.vertices.double().numpy(), strict=True)
    posed = [_posed(garment, Warped(*frame), skin) for *frame, skin in frames]
    return {
        "vertices": raw["vertices"], "triangles": raw["triangles"].astype(np.uint32),
        "points": garment.points.numpy().astype(np.uint32), "thinned": garment.thinned.numpy().astype(np.uint32),
        "warped": warped.vertices.astype(np.float32), "posed": np.stack(posed).astype(np.float32),
    }  # fmt: skip


def _posed(garment: Garment, one: Warped, skin: np.ndarray) -> np.ndarray:
    """One drape by the exported network, (N, 3)."""
    rest = garment.nodes.numpy()
    middle, body = one.nodes.mean(0), skin[garment.points.numpy()]
    inputs = {
        "garment": np.concatenate([one.nodes - middle, rest - rest.mean(0)], 1).astype(np.float32),
        "turn": one.turns.astype(np.float32),
        "body": (body - middle).astype(np.float32),
        "ring": garment.ring.numpy(),
        "ring_weight": garment.ring_weight.numpy(),
        "thinned": garment.thinned.numpy(),
        "pooled": tables.nearest_thinned(one.nodes, body, garment.thinned.numpy(), POOLED),
    }
    (translations,) = run_onnx(ARTIFACTS / "garnet" / f"{KIND}.onnx", inputs)
    read = garment.support_weight.numpy()[..., None] * translations[garment.support.numpy()]
    return one.vertices + read.sum(1)


def main() -> None:
    torch.set_num_threads(1)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "golden.npz"
        save(garnet_garment(KIND), path)
        data = tensors(load_sample(path), dict(np.load(path)))
    meta = {"poses": json.dumps(POSES), "shape": json.dumps(SHAPE), "kind": KIND}
    save_file({k: np.ascontiguousarray(v) for k, v in data.items()}, OUT, meta)
    print({k: v.shape for k, v in data.items()})


if __name__ == "__main__":
    main()
