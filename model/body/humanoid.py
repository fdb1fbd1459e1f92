"""Humanoid (VRM) rotations -> local rotations of Anny's joints, and standing on the floor.

A humanoid joint drives one or two of Anny's. A single joint takes the rotation whole. A pair along the
spine (spine, chest, neck) takes half of it each (slerp at 1/2). A limb pair splits q = swing * twist
about the bone's axis (`bone_axes` of the baked body): the first joint takes swing * twist^(1/2), the
second twist^(1/2), so that a turned sleeve twists evenly. `server/toile-geometry` does the same.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from body import quaternions as qt
from body.anny_body import AnnyBody, ShapedBody

Array = NDArray[np.float64]
Rotations = Mapping[str, ArrayLike]


def joint_rotations(body: AnnyBody, rotations: Rotations) -> Array:
    """Local rotation matrices of all joints, (104, 3, 3), for {humanoid name: quaternion xyzw}.

    Rotations are local to the joint's parent in the A-pose, about axes parallel to the world's.
    Raises KeyError on a joint that is not a humanoid one.
    """
    out = np.tile(np.eye(3), (len(body.joint_names), 1, 1))
    for name, q in rotations.items():
        joints = [body.joint_names.index(joint) for joint in body.meta["humanoid"][name]]
        for joint, part in zip(joints, split(body, name, q), strict=True):
            out[joint] = qt.to_matrix(part)
    return out


def split(body: AnnyBody, name: str, q: ArrayLike) -> list[Array]:
    """The rotations that q of a humanoid joint gives to its one or two joints of Anny's."""
    if len(body.meta["humanoid"][name]) == 1:
        return [np.asarray(q, dtype=float)]
    if name not in body.meta["bone_axes"]:
        return [qt.half(q)] * 2
    swing, twist = qt.swing_twist(q, np.array(body.meta["bone_axes"][name]))
    return [qt.multiply(swing, qt.half(twist)), qt.half(twist)]


def posed_world(body: AnnyBody, shaped: ShapedBody, rotations: Rotations, translation: ArrayLike = (0, 0, 0)) -> Array:
    """World rotations and positions of all joints, (104, 3, 4), with the body's lowest vertex at y = 0.

    translation: of the hips, metres; only x and z matter, because the floor decides y.
    """
    world = body.world_from_apose(shaped, joint_rotations(body, rotations), np.asarray(translation, dtype=float))
    world[:, 1, 3] -= body.pose(shaped, world)[:, 1].min()
    return world


def grounded_translation(body: AnnyBody, shaped: ShapedBody, rotations: Rotations) -> float:
    """What the hips move by in y, metres, so that the posed body's lowest vertex is at y = 0."""
    return float(posed_world(body, shaped, rotations)[0, 1, 3] - shaped.joints[0, 1])
