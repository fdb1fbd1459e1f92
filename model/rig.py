"""What the service's static pass says of one outfit, draped in PyTorch as the service does it before its resolve."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

import cloth_energy
import energies
from cloth_energy import Posed
from energies import RestMesh
from export import run_onnx
from garment.ornaments import carriers
from nets.deepsd import Sizes, gather_mean, pose_features, skin
from posed_bodies import Bodies
from training_data import BodyBank, Sample, ShapedPoses, as_sample, prepare


@dataclass(frozen=True)
class Rig:
    """What the service's static pass says of an outfit."""

    basis: Tensor  # (R, M, 3) metres
    joint: Tensor  # (N, 4)
    weight: Tensor  # (N, 4) summing to 1
    index: Tensor  # (N, 8) nodes of each vertex; pieces that ride have those of what carries them
    share: Tensor  # (N, 8)
    riding: Tensor  # (K,) vertices of pieces that ride
    own: Tensor  # (K, 8) their own nodes

    def spread(self, nodes: Tensor) -> Tensor:
        """A field over nodes (M, F) at the vertices, (N, F)."""
        return gather_mean(nodes, self.index, self.share)


@dataclass(frozen=True)
class Scene:
    """The outfit on one body in P poses, and its relaxed cloth there."""

    entry: ShapedPoses
    rest: Tensor  # (N, 3)
    mesh: RestMesh
    coefficients: Tensor  # (P, R)
    x: Tensor  # (Q, N, 3) world, relaxed in the first Q poses

    @property
    def relaxed(self) -> Tensor:
        """The poses in which cloth has been relaxed."""
        return torch.arange(len(self.x))


def read(tensors: dict[str, NDArray]) -> tuple[Sample, Rig]:
    """The outfit and its rig from a `static.safetensors` of the service."""
    garment = tensors["garment"].astype(np.int64)
    mesh = {
        "vertices": tensors["rest"].reshape(-1, 3),
        "triangles": tensors["triangles"].reshape(-1, 3).astype(np.int64),
        "garment": garment,
    }
    count = len(garment)
    carrier = carriers(mesh["vertices"].astype(np.float64), mesh["triangles"], garment)
    index = tensors["vertex_from_node"].reshape(count, -1).astype(np.int64)
    share = tensors["vertex_from_node_weight"].reshape(count, -1)
    riding = np.flatnonzero(carrier != np.arange(count))
    rig = Rig(
        torch.as_tensor(tensors["basis"]).reshape(Sizes.basis, -1, 3),
        torch.as_tensor(tensors["joints"].reshape(count, 4).astype(np.int64)),
        torch.as_tensor(tensors["weights"].reshape(count, 4)),
        torch.as_tensor(index[carrier]), torch.as_tensor(share[carrier]),
        torch.as_tensor(riding), torch.as_tensor(index[riding]),
    )  # fmt: skip
    return as_sample("outfit", prepare(mesh)), rig


def coefficients(entry: ShapedPoses, parents: Tensor, artifacts: Path) -> Tensor:
    """Of the shared network in every pose of a body, (P, R): its answer for a basis of units."""
    units = np.eye(Sizes.basis, dtype=np.float32)
    inputs = {"pose": pose_features(entry.transforms, parents), "shape": entry.shape[None]}
    ports = {name: x.numpy() for name, x in inputs.items()} | {"basis": units}
    return torch.as_tensor(run_onnx(artifacts / "deepsd" / "dynamic.onnx", ports)[0])


def drape(rig: Rig, s: Scene, poses: Tensor, basis: Tensor, weight: Tensor) -> Posed:
    """The service's drape before its resolve."""
    offset = torch.einsum("nrk,pr->pnk", at_vertices(rig, basis), s.coefficients[poses])
    posed, up = skin(s.rest + offset, weight, rig.joint, s.entry.transforms[poses])
    skinned, _ = skin(s.rest.expand_as(offset), weight, rig.joint, s.entry.transforms[poses])
    return Posed(posed, skinned, up)


def at_vertices(rig: Rig, basis: Tensor) -> Tensor:
    """Basis of the nodes (R, M, 3) at the vertices, (N, R, 3)."""
    return rig.spread(basis.transpose(0, 1).flatten(1)).reshape(-1, len(basis), 3)


def with_riders(rig: Rig, basis: Tensor) -> Tensor:
    """A basis (R, M, 3) whose nodes of pieces that ride say what the nodes that carry them do."""
    out = basis.clone()
    out[:, rig.own] = (
        at_vertices(rig, basis)[rig.riding].transpose(0, 1)[:, :, None].expand(-1, -1, rig.own.shape[1], -1)
    )
    return out


@dataclass(frozen=True)
class Measured:
    """Means over drapes before the resolve; the service reads these names."""

    miss_mm: float
    edge_mm: float
    inside_percent: float


@torch.no_grad()
def measure(rig: Rig, scenes: list[Scene], sample: Sample, bank: BodyBank, basis: Tensor, weight: Tensor) -> Measured:
    """Figures of a rig on scenes."""
    rows = []
    for s in scenes:
        d = drape(rig, s, s.relaxed, basis, weight)
        miss = (d.posed - s.x).norm(dim=-1).mean()
        edge = (energies.edge_lengths(d.posed, s.mesh.edges) - s.mesh.length).abs().mean()
        inside = (cloth_energy.contacts(d, sample, bank, Bodies.of(s.entry, s.relaxed)).body < 0).float().mean()
        rows.append([1e3 * miss.item(), 1e3 * edge.item(), 100 * inside.item()])
    return Measured(*(round(float(x), 3) for x in np.mean(rows, 0)))
