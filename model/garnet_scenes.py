"""What GarNet sees of the drapes of `garnet_data`: warped garment, body points, tables. World space, metres."""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

import garnet_losses as losses
from garment import garnet_tables as tables
from garment.dual_quaternions import blended, warp
from garment.graph import build
from garment.refine import refined
from garnet_data import RELAXED, Split, samples
from nets.deepsd import top_four
from nets.garnet import AVERAGED, POOLED, THINNED, Neighbours
from relax import influences
from teacher.checks import good
from training_data import BodyBank, Sample, carry

#: Points of a body that the network sees, about.
POINTS = 4096
#: Turn about the upright up to which networks see bodies, radians; poses to train on turn less.
FACING = 0.3
#: Sizes of the neighbourhoods whose curvature counts (section 3.5).
SCALES = (8, 16, 32)


@dataclass(frozen=True)
class Garment:
    """Tables of one garment; the same in every drape."""

    triangles: Tensor  # (F, 3)
    two_apart: Tensor  # (E2, 2)
    around: dict[int, Tensor]  # by size, (N, size)
    edge: float  # mean length, m
    nodes: Tensor  # (M, 3) of the canonical graph, on the reference body
    support: Tensor  # (N, SUPPORTS) nodes that each vertex is interpolated from
    support_weight: Tensor
    ring: Tensor  # (M, RING)
    ring_weight: Tensor
    points: Tensor  # (B,) vertices of the body that are seen
    thinned: Tensor  # (B', AVERAGED)

    @classmethod
    def of(cls, sample: Sample, bank: BodyBank) -> Garment:
        v, t = sample.vertices.double().numpy(), sample.tables[2].numpy()
        skin = bank.reference.double().numpy()
        points = tables.spread_out(skin, POINTS)
        edges = sample.tables[0]
        as_tensor = torch.as_tensor
        fine = refined(v, t)
        graph = build(fine.vertices, fine.triangles, np.zeros(len(fine.vertices), np.int64))
        ring, weight = tables.ring(sample.graph.near.numpy(), sample.graph.near_weight.numpy())
        return cls(
            sample.tables[2], as_tensor(losses.two_edges_apart(t)),
            {k: as_tensor(losses.neighbourhoods(v, k)) for k in SCALES},
            float((sample.vertices[edges[:, 0]] - sample.vertices[edges[:, 1]]).norm(dim=1).mean()),
            as_tensor(graph.nodes.positions).float(), sample.vertex_from_node, sample.vertex_from_node_weight,
            as_tensor(ring), as_tensor(weight).float(),
            as_tensor(points), as_tensor(tables.thinned(skin[points], THINNED, AVERAGED)),
        )  # fmt: skip


@dataclass(frozen=True)
class Scenes:
    """D drapes of one garment, each about the middle of its warped nodes."""

    nodes: Tensor  # (D, M, 6) warped, and at rest on the reference body less their middle
    turn: Tensor  # (D, M, 3, 3) of the nodes by skinning, world from rest
    warped: Tensor  # (D, N, 3)
    truth: Tensor  # (D, N, 3)
    body: Tensor  # (D, B, 3)
    body_normals: Tensor  # (D, B, 3)
    pooled: Tensor  # (D, M, POOLED)
    which: Tensor  # (D, 2) body and pose of the split

    def __len__(self) -> int:
        return len(self.warped)

    def pick(self, rows: Tensor) -> Scenes:
        return Scenes(*(getattr(self, f.name)[rows] for f in fields(self)))

    def mirrored(self) -> Scenes:
        """Left and right exchanged, which neither cloth nor gravity notices."""
        flip = self.warped.new_tensor([-1.0, 1, 1])
        turn = flip[:, None] * self.turn * flip
        others = (flip * x for x in (self.warped, self.truth, self.body, self.body_normals))
        return Scenes(flip.repeat(2) * self.nodes, turn, *others, self.pooled, self.which)

    def near(self, garment: Garment) -> Neighbours:
        return Neighbours(garment.ring, garment.ring_weight, garment.thinned, self.pooled.long())


def load(kind: str, split: Split, bank: BodyBank, folder: Path = RELAXED.folder) -> tuple[Garment, Scenes]:
    """Every good drape of one garment in a split. Raises FileNotFoundError when there is none."""
    sample = samples(folder)[kind]
    garment, rows = Garment.of(sample, bank), []
    for k, entry in enumerate(bank.entries):
        kept = {
            p: x
            for p in range(split.poses)
            if (x := good(folder / kind / split.name / f"{k:03d}_{p:02d}.npz")) is not None
        }
        if not kept:
            continue
        rest = carry(sample, bank, entry)[0].double().numpy()
        transforms = entry.transforms[list(kept)].double().numpy()
        warped = warped_on(sample, garment, rest, transforms)
        hips = transforms[:, int((bank.parents < 0).nonzero()[0, 0])]
        rows += [
            (*_scene(garment, Warped(*one), x, shown(root), entry.vertices[p], entry.normals[p]), torch.tensor([k, p]))
            for *one, root, (p, x) in zip(*astuple(warped), hips, kept.items(), strict=True)
        ]
    if not rows:
        raise FileNotFoundError(f"no drapes of {kind} under {folder}: run `python -m garnet_data` first")
    return garment, Scenes(*(torch.stack(column) for column in zip(*rows, strict=True)))


@dataclass(frozen=True)
class Warped:
    """Where dual-quaternion skinning by the body's weights puts a garment, in P poses or in one."""

    nodes: np.ndarray  # (P, M, 3)
    turns: np.ndarray  # (P, M, 3, 3) of the nodes, world from rest
    vertices: np.ndarray  # (P, N, 3)


def warped_on(sample: Sample, garment: Garment, rest: np.ndarray, transforms: np.ndarray) -> Warped:
    """The garment in poses of a body.

    rest (N, 3): vertices on that body. transforms (P, J, 3, 4).
    """
    support = garment.support.numpy(), garment.support_weight.double().numpy()
    reference, drawn = garment.nodes.double().numpy(), sample.vertices.double().numpy()
    nodes = tables.nodes_on_body(reference, drawn, rest, *support)
    weight, joint = top_four(sample.prior)
    motions = blended(weight.double().numpy(), joint.numpy(), transforms)
    weight, joint = influences(sample)
    return Warped(motions.move(nodes), motions.turns(), warp(rest, weight.double().numpy(), joint.numpy(), transforms))


def shown(hips: np.ndarray) -> np.ndarray:
    """Turns the world until a body faces at most `FACING` from +Z, (3, 3): neither cloth nor gravity notices.

    hips: their transform from the A-pose, (3, 4) or (4, 4). The service does the same
    (`toile-drape/src/methods/garnet.rs`).
    """
    facing = np.arctan2(hips[0, 2], hips[2, 2])
    back = np.clip(facing, -FACING, FACING) - facing
    sin, cos = np.sin(back), np.cos(back)
    return np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])


def _scene(
    garment: Garment, one: Warped, truth: np.ndarray, facing: np.ndarray, skin: Tensor, normals: Tensor
) -> tuple[Tensor, ...]:
    """One row of `Scenes`, less which it is, turned by `facing`, (3, 3)."""
    middle = one.nodes.mean(0)
    body = skin[garment.points].double().numpy()
    pooled = tables.nearest_thinned(one.nodes, body, garment.thinned.numpy(), POOLED)
    rest = garment.nodes - garment.nodes.mean(0)
    places = (one.nodes, one.vertices, truth, body)
    nodes, *others = [torch.as_tensor((x - middle) @ facing.T, dtype=torch.float32) for x in places]
    turn, pooled = torch.as_tensor(facing @ one.turns).float(), torch.as_tensor(pooled, dtype=torch.int32)
    seen = normals[garment.points] @ torch.as_tensor(facing.T, dtype=torch.float32)
    return (torch.cat([nodes, rest], 1), turn, *others, seen, pooled)
