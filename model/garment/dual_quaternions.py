"""Skinning by blended dual quaternions (Kavan et al. 2007): limbs keep their girth where they twist.

Quaternions xyzw. Transforms are rigid, world from A-pose, metres.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]


def warp(rest: Floats, weight: Floats, joint: Ints, transforms: Floats) -> Floats:
    """Cloth (N, 3) of the A-pose in several poses, (P, N, 3).

    weight, joint (N, K): influences, rows of weights sum to 1, the largest first. transforms (P, J, 3, 4).
    """
    return np.stack([_warp_one(rest, weight, joint, pose) for pose in transforms])


def _warp_one(rest: Floats, weight: Floats, joint: Ints, transforms: Floats) -> Floats:
    turn = Rotation.from_matrix(transforms[:, :, :3]).as_quat()
    dual = 0.5 * _multiply(np.pad(transforms[:, :, 3], ((0, 0), (0, 1))), turn)
    # A quaternion and its negative turn alike; blended they must lie on the side of the strongest influence.
    side = np.sign((turn[joint] * turn[joint[:, :1]]).sum(-1, keepdims=True))
    share = weight[..., None] * np.where(side == 0, 1, side)
    real, moved = (share * turn[joint]).sum(1), (share * dual[joint]).sum(1)
    length = np.linalg.norm(real, axis=1, keepdims=True)
    real, moved = real / length, moved / length
    conjugate = real * [-1, -1, -1, 1]
    return Rotation.from_quat(real).apply(rest) + 2 * _multiply(moved, conjugate)[:, :3]


def _multiply(a: Floats, b: Floats) -> Floats:
    """Products of quaternions, (..., 4)."""
    xyz = a[..., 3:] * b[..., :3] + b[..., 3:] * a[..., :3] + np.cross(a[..., :3], b[..., :3])
    return np.concatenate([xyz, a[..., 3:] * b[..., 3:] - (a[..., :3] * b[..., :3]).sum(-1, keepdims=True)], -1)
