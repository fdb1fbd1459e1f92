"""Poses of the upper body for pixel cloth (Jin et al. 2020, section 6.2), and what the network is told of one.

Every joint turns independently of the others within its natural range; poses in which the body meets itself are
thrown away. The legs stand still: ten joints move a T-shirt.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from body.clearance import sample_bodies
from body.pose_sampling import cleared, spread
from body.posture import SIDES, Posture, euler
from garment.binding import garment_joint_names

#: Joints whose rotations the network sees, each against the one named first; the pelvis against the world.
JOINTS: tuple[tuple[str | None, str], ...] = (
    (None, "root"), ("root", "spine04"), ("spine04", "spine02"), ("spine02", "spine01"),
    ("spine01", "shoulder01.L"), ("shoulder01.L", "upperarm02.L"), ("upperarm02.L", "lowerarm02.L"),
    ("spine01", "shoulder01.R"), ("shoulder01.R", "upperarm02.R"), ("upperarm02.R", "lowerarm02.R"),
)  # fmt: skip
#: The same with the legs, for garments that reach them.
WHOLE_BODY: tuple[tuple[str | None, str], ...] = (
    *JOINTS,
    ("root", "upperleg02.L"), ("upperleg02.L", "lowerleg02.L"),
    ("root", "upperleg02.R"), ("upperleg02.R", "lowerleg02.R"),
)  # fmt: skip
#: Humanoid joints that stand still.
LEGS = ("leftUpperLeg", "leftLowerLeg", "rightUpperLeg", "rightLowerLeg")
#: Numbers of a pose: rotation matrices.
POSE = 9 * len(JOINTS)


def upper_body(rng: np.random.Generator) -> dict[str, np.ndarray]:
    """One pose, {humanoid joint: quaternion xyzw}; not tested for collisions."""
    p, between = Posture(), rng.uniform
    p.turn("hips", euler(spread(rng, 5), 0, spread(rng, 4)))
    p.torso(
        euler(between(-10, 25), between(-18, 18), between(-14, 14)),
        euler(between(-8, 22), between(-18, 18), between(-12, 12)),
    )
    for side in SIDES:
        # The cosine of the raise is even, so that directions are even over the sphere.
        raised = np.degrees(np.arccos(between(np.cos(np.radians(150)), np.cos(np.radians(12)))))
        p.arm(side, raised, between(-35, 95), between(5, 120), between(-35, 35))
        p.forearm(side, between(-50, 40))
    return p.rotations


def upper_body_poses(count: int, seed: int) -> list[dict[str, np.ndarray]]:
    """`count` poses in which cloth has room; the same seed gives the same poses."""
    rng, poses = np.random.default_rng(seed), []
    while len(poses) < count:
        if (pose := cleared(upper_body(rng), sample_bodies())) is not None:
            poses.append(pose)
    return poses


def pose_matrices(transforms: Tensor, joints: tuple[tuple[str | None, str], ...] = JOINTS) -> Tensor:
    """What the network sees of P poses, (P, 9 J): rotation matrices of the joints, row by row.

    transforms (P, 36, 3, 4): world from A-pose. Which way the body faces is left out: cloth does not notice.
    """
    names = garment_joint_names()
    turn = {name: transforms[:, names.index(name), :, :3] for pair in joints for name in pair if name}
    own = [upright(turn[to]) if of is None else turn[of].transpose(1, 2) @ turn[to] for of, to in joints]
    return torch.stack(own, 1).flatten(1)


def upright(turn: Tensor) -> Tensor:
    """Rotations (P, 3, 3) of the pelvis, turned about the vertical so that it faces +z."""
    ahead = turn[:, (0, 2), 2]
    sin, cos = (ahead / ahead.norm(dim=1, keepdim=True).clamp(min=1e-6)).T
    nil, one = torch.zeros_like(sin), torch.ones_like(sin)
    back = torch.stack([cos, nil, -sin, nil, one, nil, sin, nil, cos], 1).unflatten(1, (3, 3))
    return back @ turn
