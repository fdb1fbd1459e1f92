"""Bodies on their way from the A-pose to a pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from torch import Tensor

from garment import folds, nearest
from training_data import BodyBank, ShapedPoses

Floats = NDArray[np.float64]


def bent(entry: ShapedPoses, bank: BodyBank, pose: int, share: float) -> ShapedPoses:
    """The same body in one pose, every joint turned by a share (0 to 1) of what it turns in the given pose."""
    transforms = shared(entry.transforms[pose].double().numpy(), entry.joints.double().numpy(), bank.parents, share)
    moved = torch.as_tensor(transforms, dtype=torch.float32)
    rows = (bank.skin @ moved.flatten(1)).reshape(-1, 3, 4)
    vertices = ((rows[..., :3] @ entry.apose[..., None])[..., 0] + rows[..., 3])[None]
    normals = nearest.vertex_normals(vertices, bank.triangles)
    pinched = torch.as_tensor(folds.pinched(vertices[0].numpy(), normals[0].numpy()))[None]
    return replace(entry, transforms=moved[None], vertices=vertices, normals=normals, pinched=pinched)


def shared(transforms: Floats, joints: Floats, parents: Tensor, share: float) -> Floats:
    """World-from-A-pose transforms (J, 3, 4), each joint turned against its parent by a share of its turn.

    joints (J, 3): where the joints are in the A-pose. Parents come before their children; -1 is none.
    """
    out = np.zeros_like(transforms)
    for j, parent in enumerate(parents.tolist()):
        turn = transforms[j, :, :3] if parent < 0 else transforms[parent, :, :3].T @ transforms[j, :, :3]
        turn = Rotation.from_rotvec(share * Rotation.from_matrix(turn).as_rotvec()).as_matrix()
        if parent < 0:
            place = share * _at(transforms[j], joints[j]) + (1 - share) * joints[j]
        else:
            turn, place = out[parent, :, :3] @ turn, _at(out[parent], joints[j])
        out[j] = np.column_stack([turn, place - turn @ joints[j]])
    return out


def _at(transform: Floats, point: Floats) -> Floats:
    return transform[:, :3] @ point + transform[:, 3]
