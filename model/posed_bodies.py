"""Bodies in poses, and on their way there from the A-pose. World space, metres."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from torch import Tensor

from garment import nearest
from training_data import BodyBank, ShapedPoses

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Bodies:
    """B bodies, each in one pose: V vertices, J joints."""

    apose: Tensor  # (B, V, 3)
    joints: Tensor  # (B, J, 3) in the A-pose
    transforms: Tensor  # (B, J, 3, 4) world from A-pose
    vertices: Tensor  # (B, V, 3)
    normals: Tensor  # (B, V, 3)
    pinched: Tensor  # (B, V) where the body meets itself and leaves cloth no room

    @classmethod
    def of(cls, entry: ShapedPoses, poses: Tensor) -> Bodies:
        """One body in some of its poses (B,)."""
        apose, joints = (x.expand(len(poses), -1, -1) for x in (entry.apose, entry.joints))
        return cls(
            apose, joints, entry.transforms[poses], entry.vertices[poses], entry.normals[poses], entry.pinched[poses]
        )


def stacked(bodies: list[Bodies]) -> Bodies:
    """All of them, one after the other."""
    return Bodies(*(torch.cat([getattr(b, f.name) for b in bodies]) for f in fields(Bodies)))


def bent(bodies: Bodies, bank: BodyBank, share: float) -> Bodies:
    """The same bodies, every joint turned by a share (0 to 1) of what it turns in their pose; folds are the pose's."""
    places = (bodies.transforms.double().cpu().numpy(), bodies.joints.double().cpu().numpy())
    moved = torch.as_tensor(shared(*places, bank.parents, share)).to(bodies.vertices)
    rows = (bank.skin @ moved.flatten(2)).unflatten(2, (3, 4))
    vertices = (rows[..., :3] @ bodies.apose[..., None])[..., 0] + rows[..., 3]
    normals = nearest.vertex_normals(vertices, bank.triangles)
    return replace(bodies, transforms=moved, vertices=vertices, normals=normals)


def shared(transforms: Floats, joints: Floats, parents: Tensor, share: float) -> Floats:
    """World-from-A-pose transforms (B, J, 3, 4), each joint turned against its parent by a share of its turn.

    joints (B, J, 3): where the joints are in the A-pose. Parents come before their children; -1 is none.
    """
    out = np.zeros_like(transforms)
    for j, parent in enumerate(parents.tolist()):
        own = transforms[:, j, :, :3]
        turn = own if parent < 0 else transforms[:, parent, :, :3].transpose(0, 2, 1) @ own
        turn = Rotation.from_rotvec(share * Rotation.from_matrix(turn).as_rotvec()).as_matrix()
        if parent < 0:
            place = share * _at(transforms[:, j], joints[:, j]) + (1 - share) * joints[:, j]
        else:
            turn, place = out[:, parent, :, :3] @ turn, _at(out[:, parent], joints[:, j])
        out[:, j, :, :3], out[:, j, :, 3] = turn, place - _turned(turn, joints[:, j])
    return out


def _turned(turn: Floats, point: Floats) -> Floats:
    return (turn @ point[..., None])[..., 0]


def _at(transform: Floats, point: Floats) -> Floats:
    return _turned(transform[..., :3], point) + transform[..., 3]
