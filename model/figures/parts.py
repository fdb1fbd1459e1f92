"""What the networks say of unseen outfits: `xvfb-run -a python -m figures.parts`, as figures 3, 6 and 9 of the paper.

parts.jpg: the rest pose, the offsets added to it (PSD), skinning alone, and all together.
weights.jpg: blend weights of the body and of outfits, a colour a joint.
offsets.jpg: how far the offsets move the cloth in several poses, white 0 to red 15 cm.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from body.anny_body import AnnyBody
from body.humanoid import joint_rotations
from export import ARTIFACTS, run_onnx
from nets.deepsd import Graph, pose_features, skin, top_four
from outfits.held_out import held_out
from training_data import BodyBank, Sample, ShapedPoses, load_sample

from .drawing import Drawn, by_garment, cell, grid

Floats = NDArray[np.floating]

OUT = Path(__file__).parents[2] / "docs" / "pictures"
POSES = ("contrapposto", "walk-2", "squat")
FULL = 0.15  # m, offset drawn red


@dataclass(frozen=True)
class Parts:
    """An outfit on the reference body in some poses."""

    sample: Sample
    garment: NDArray
    weights: torch.Tensor  # (N, 36)
    offsets: torch.Tensor  # (P, N, 3) rest space
    posed: torch.Tensor  # (P, N, 3)
    skinned: torch.Tensor  # (P, N, 3) by the body's own weights, without offsets


@torch.no_grad()
def parts(sample: Sample, garment: NDArray, bank: BodyBank, entry: ShapedPoses) -> Parts:
    """Runs the shipped networks on the outfit's graph."""
    inputs = {"features": sample.features.numpy(), "prior": sample.prior.numpy()}
    inputs |= {name: getattr(sample.graph, name).numpy() for name in Graph.__dataclass_fields__}
    weights, basis, _ = map(torch.as_tensor, run_onnx(ARTIFACTS / "deepsd" / "static.onnx", inputs))
    count, nodes = len(entry.transforms), len(basis)
    pose = pose_features(entry.transforms, bank.parents).numpy()
    rows = basis.reshape(nodes * 3, -1).T.contiguous().numpy()
    moved = run_onnx(
        ARTIFACTS / "deepsd" / "dynamic.onnx", {"pose": pose, "shape": entry.shape[None].numpy(), "basis": rows}
    )[0]
    at_nodes = torch.as_tensor(moved).reshape(count, nodes, 3)
    offsets = torch.stack([sample.at_vertices(frame) for frame in at_nodes])
    own, rest = sample.at_vertices(weights), sample.vertices
    posed = skin(rest + offsets, *top_four(own), entry.transforms)[0]
    skinned = skin(rest.expand_as(offsets), *top_four(sample.at_vertices(sample.prior)), entry.transforms)[0]
    return Parts(sample, garment, own, offsets, posed, skinned)


def preset_poses(body: AnnyBody, names: tuple[str, ...]) -> list[dict]:
    """Rotations of preset poses."""
    presets = json.loads((ARTIFACTS / "poses.json").read_text())["poses"]
    found = {p["id"]: p["rotations"] for p in presets}
    return [{joint: np.array(q) for joint, q in found[name].items()} for name in names]


def joint_colours(weights: Floats) -> Floats:
    """A colour for each joint, blended: (N, 36) -> (N, 3)."""
    rng = np.random.default_rng(5)
    return weights @ rng.uniform(0.15, 0.95, (weights.shape[1], 3))


def heat(offsets: Floats) -> Floats:
    """White to red by length: (N, 3) -> (N, 3)."""
    share = np.clip(np.linalg.norm(offsets, axis=1) / FULL, 0, 1)[:, None]
    return (1 - share) * np.ones(3) + share * np.array([0.75, 0.05, 0.05])


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--out", type=Path, default=OUT)
    p.add_argument("--outfits", type=int, default=5)
    p.add_argument("--scratch", type=Path, default=Path("data/figures"))
    a = p.parse_args()
    a.scratch.mkdir(parents=True, exist_ok=True)
    bank, body = BodyBank(1, 1, 1), AnnyBody.load()
    shaped = body.shape()
    worlds = [body.world_from_apose(shaped, joint_rotations(body, pose)) for pose in preset_poses(body, POSES)]
    entry = bank.entry(body, ({}, {}), shaped, worlds)
    skin_triangles = body.triangles
    found = []
    for i, outfit in held_out(a.outfits):
        path = a.scratch / f"{i:02d}_{outfit.family}.npz"
        tables = outfit_tables(outfit)
        np.savez(path, **tables)
        found.append(parts(load_sample(path), tables["garment"], bank, entry))
    apose, posed = entry.apose.numpy(), entry.vertices.numpy()
    rows = [
        [
            cell([Drawn(apose, skin_triangles), *cloth(f, f.sample.vertices)]),
            cell([Drawn(apose, skin_triangles), *cloth(f, f.sample.vertices + f.offsets[k])]),
            cell([Drawn(posed[k], skin_triangles), *cloth(f, f.skinned[k])]),
            cell([Drawn(posed[k], skin_triangles), *cloth(f, f.posed[k])]),
        ]
        for f, k in zip(found, (1, 0, 1, 2, 2), strict=False)
    ]
    titles = ("rest pose", "with offsets (PSD)", "skinning alone", "all, before the resolve")
    grid(rows, titles).save(a.out / "deepsd-parts.jpg", quality=85)
    bare = cell([Drawn(apose, skin_triangles, vertex_colours=joint_colours(bank.skin.numpy()))])
    dressed = [
        cell([Drawn(apose, skin_triangles), shaded(f, f.sample.vertices, joint_colours(f.weights.numpy()))])
        for f in found
    ]
    grid([[bare, *dressed]], ("the body's own", "outfits")).save(a.out / "deepsd-weights.jpg", quality=85)
    rows = [
        [
            cell([Drawn(posed[k], skin_triangles), shaded(f, f.posed[k], heat(f.offsets[k].numpy()))])
            for k in range(len(POSES))
        ]
        for f in found
    ]
    grid(rows, POSES).save(a.out / "deepsd-offsets.jpg", quality=85)


def outfit_tables(outfit: object) -> dict[str, NDArray]:
    """One mesh of all garments, as training's files have it."""
    garments = outfit.garments  # type: ignore[attr-defined]
    first = np.cumsum([0, *(len(g.vertices) for g in garments)])
    return {
        "vertices": np.concatenate([g.vertices for g in garments]),
        "triangles": np.concatenate([g.triangles + n for g, n in zip(garments, first, strict=False)]),
        "garment": np.repeat(np.arange(len(garments)), np.diff(first)),
    }


def cloth(f: Parts, x: torch.Tensor) -> list[Drawn]:
    return by_garment(x.numpy(), f.sample.tables[2].numpy(), f.garment)


def shaded(f: Parts, x: torch.Tensor, colours: Floats) -> Drawn:
    return Drawn(x.numpy(), f.sample.tables[2].numpy(), vertex_colours=colours)


if __name__ == "__main__":
    main()
