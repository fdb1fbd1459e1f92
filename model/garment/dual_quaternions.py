"""Skinning by blended dual quaternions (Kavan et al. 2007): limbs keep their girth where they twist.

Quaternions xyzw. Transforms are rigid, world from A-pose, metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]


@dataclass(frozen=True)
class Motions:
    """Rigid motions of N points in P poses, world from A-pose: unit quaternions and their dual parts, (P, N, 4)."""

    real: Floats
    dual: Floats

    def move(self, rest: Floats) -> Floats:
        """Points (N, 3) of the A-pose in every pose, (P, N, 3)."""
        return np.stack([
            Rotation.from_quat(real).apply(rest) + 2 * _multiply(dual, real * [-1, -1, -1, 1])[:, :3]
            for real, dual in zip(self.real, self.dual, strict=True)
        ])  # fmt: skip

    def turns(self) -> Floats:
        """Rotation matrices (P, N, 3, 3)."""
        return np.stack([Rotation.from_quat(real).as_matrix() for real in self.real])


def blended(weight: Floats, joint: Ints, transforms: Floats) -> Motions:
    """Motions of points that follow several joints.

    weight, joint (N, K): influences, rows of weights sum to 1, the largest first. transforms (P, J, 3, 4).
    """
    real, dual = zip(*(_blended_in(weight, joint, pose) for pose in transforms), strict=True)
    return Motions(np.stack(real), np.stack(dual))


def warp(rest: Floats, weight: Floats, joint: Ints, transforms: Floats) -> Floats:
    """Cloth (N, 3) of the A-pose in several poses, (P, N, 3); arguments as of `blended`."""
    return blended(weight, joint, transforms).move(rest)


def _blended_in(weight: Floats, joint: Ints, transforms: Floats) -> tuple[Floats, Floats]:
    turn = Rotation.from_matrix(transforms[:, :, :3]).as_quat()
    dual = 0.5 * _multiply(np.pad(transforms[:, :, 3], ((0, 0), (0, 1))), turn)
    # A quaternion and its negative turn alike; blended they must lie on the side of the strongest influence.
    side = np.sign((turn[joint] * turn[joint[:, :1]]).sum(-1, keepdims=True))
    share = weight[..., None] * np.where(side == 0, 1, side)
    real, moved = (share * turn[joint]).sum(1), (share * dual[joint]).sum(1)
    length = np.linalg.norm(real, axis=1, keepdims=True)
    return real / length, moved / length


def _multiply(a: Floats, b: Floats) -> Floats:
    """Products of quaternions, (..., 4)."""
    xyz = a[..., 3:] * b[..., :3] + b[..., 3:] * a[..., :3] + np.cross(a[..., :3], b[..., :3])
    return np.concatenate([xyz, a[..., 3:] * b[..., 3:] - (a[..., :3] * b[..., :3]).sum(-1, keepdims=True)], -1)
