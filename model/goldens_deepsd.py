"""Golden vectors of DeePSD that the Rust tests replay: `python -m goldens_deepsd --checkpoint runs/deepsd.pt`.

One small outfit on one body in two preset poses: graph, features, static pass, carried rest pose, offsets
and posed vertices (before the resolve), all computed here, into artifacts/golden/deepsd.safetensors.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import torch
from safetensors.numpy import save_file

from body.anny_body import AnnyBody
from body.humanoid import posed_world
from garment.binding import reference_surface
from garment.graph import build, mesh_edges
from garment.refine import refined
from nets.deepsd import Sizes
from outfits.dataset import save
from outfits.generate import generate
from train_deepsd import DeePSD, drape
from training_data import BodyBank, Sample, ShapedPoses, carry, load_sample

OUT = Path(__file__).parent / "artifacts" / "golden" / "deepsd.safetensors"
FAMILY, SEED = "tank", 3
POSES = ("walk-2", "sitting")
SHAPE = {"gender": 1.0, "weight": 0.7, "height": 0.4}


def reference_entry(body: AnnyBody, bank: BodyBank) -> ShapedPoses:
    """The golden body in the golden poses."""
    return in_golden_poses(body, bank, SHAPE)


def in_golden_poses(
    body: AnnyBody, bank: BodyBank, shape: dict[str, float], still: tuple[str, ...] = ()
) -> ShapedPoses:
    """A body in the golden poses, some joints left out of them."""
    library = {p["id"]: p for p in json.loads((OUT.parents[1] / "poses.json").read_text())["poses"]}
    shaped = body.shape(shape)
    poses = [{k: q for k, q in library[name]["rotations"].items() if k not in still} for name in POSES]
    worlds = [posed_world(body, shaped, pose) for pose in poses]
    return bank.entry(body, (shape, {}), shaped, worlds)


def small_bank(body: AnnyBody) -> BodyBank:
    """A bank without random entries: only what `carry` and `drape` read."""
    bank = BodyBank(0, 0, 0)
    assert bank.ring.shape[0] == len(body.skin_joints)
    return bank


def tensors(net: DeePSD, sample: Sample, raw: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    body = AnnyBody.load()
    bank = small_bank(body)
    entry = reference_entry(body, bank)
    fine = refined(raw["vertices"].astype(np.float64), raw["triangles"].astype(np.int64))
    graph = build(fine.vertices, fine.triangles, raw["garment"].astype(np.int64)[fine.origin])
    with torch.no_grad():
        rest, _ = carry(sample, bank, entry)
        draped = drape(net, sample, rest, entry, torch.arange(len(POSES)), bank.parents)
        weights, basis, _ = net.static(sample.features, sample.prior, sample.graph)
    assert len(mesh_edges(raw["triangles"].astype(np.int64))) == len(sample.tables[0])
    return {
        "vertices": raw["vertices"], "triangles": raw["triangles"].astype(np.uint32),
        "node_positions": graph.nodes.positions.astype(np.float32),
        "features": sample.features.numpy(), "prior": sample.prior.numpy(),
        "node_weights": weights.numpy(), "node_basis": basis.numpy(),
        "rest": rest.numpy(), "offsets": draped.offset.numpy(), "posed": draped.posed.numpy(),
        "distance": sample.distance.numpy(), "reference_surface": reference_surface().vertices[::97].astype(np.float32),
    }  # fmt: skip


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--checkpoint", type=Path, default=Path("runs/deepsd.pt"))
    a = p.parse_args()
    net = DeePSD(Sizes())
    net.load_state_dict(torch.load(a.checkpoint)["net"])
    net.eval()
    with TemporaryDirectory() as folder:
        path = Path(folder) / "golden.npz"
        save(generate(SEED, FAMILY), path)
        data = tensors(net, load_sample(path), dict(np.load(path)))
    meta = {"poses": json.dumps(POSES), "shape": json.dumps(SHAPE)}
    save_file({k: np.ascontiguousarray(v) for k, v in data.items()}, OUT, meta)
    print({k: v.shape for k, v in data.items()})


if __name__ == "__main__":
    main()
