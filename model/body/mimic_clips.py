"""Motion capture in the files of DeepMimic (Peng et al. 2018), as `pybullet` ships them, as clips.

A frame holds its seconds, the pelvis's place and quaternion, then for each joint below the quaternion against its
parent, w first, or of a hinge the angle about z. x is ahead, y up, z to the right; at rest arms and legs hang down.
"""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from body import quaternions as qt
from body.motion_capture import Clip

Array = NDArray[np.float64]
#: Joint: parent, offset (m) and first column of a frame; none for an end. `pybullet_data/humanoid/humanoid.urdf` / 4.
JOINTS: dict[str, tuple[str, tuple[float, float, float], int | None]] = {
    "hips": ("", (0.0, 0.0, 0.0), 4),
    "spine": ("hips", (0.0, 0.236151, 0.0), None),
    "chest": ("hips", (0.0, 0.236151, 0.0), 8),
    "head": ("chest", (0.0, 0.223894, 0.0), 12),
    "rightUpLeg": ("hips", (0.0, 0.0, 0.084887), 16),
    "rightLeg": ("rightUpLeg", (0.0, -0.421546, 0.0), 20),
    "rightFoot": ("rightLeg", (0.0, -0.409870, 0.0), 21),
    "rightArm": ("chest", (-0.02405, 0.2435, 0.18311), 25),
    "rightForeArm": ("rightArm", (0.0, -0.274788, 0.0), 29),
    "rightHand": ("rightForeArm", (0.0, -0.258947, 0.0), None),
    "leftUpLeg": ("hips", (0.0, 0.0, -0.084887), 30),
    "leftLeg": ("leftUpLeg", (0.0, -0.421546, 0.0), 34),
    "leftFoot": ("leftLeg", (0.0, -0.409870, 0.0), 35),
    "leftArm": ("chest", (-0.02405, 0.2435, -0.18311), 39),
    "leftForeArm": ("leftArm", (0.0, -0.274788, 0.0), 43),
    "leftHand": ("leftForeArm", (0.0, -0.258947, 0.0), None),
}
#: Joints that turn about z alone.
HINGES = ("rightLeg", "rightForeArm", "leftLeg", "leftForeArm")
#: Numbers of a frame.
WIDTH = 44


def read_mimic(text: str) -> Clip:
    """A file's text. Raises ValueError where its frames are not those of the humanoid."""
    values = np.array(json.loads(text)["Frames"], dtype=float)
    if values.ndim != 2 or values.shape[1] != WIDTH or not np.isfinite(values).all():
        raise ValueError(f"frames of {WIDTH} finite numbers expected, {values.shape} found")
    names = list(JOINTS)
    offsets = np.array([offset for _, offset, _ in JOINTS.values()])
    turns, positions = np.zeros((len(values), len(names), 3, 3)), np.zeros((len(values), len(names), 3))
    for j, (name, (parent, offset, column)) in enumerate(JOINTS.items()):
        own = _turn(values, name, column)
        if not parent:
            turns[:, j], positions[:, j] = own, values[:, 1:4]
            continue
        p = names.index(parent)
        turns[:, j] = turns[:, p] @ own
        positions[:, j] = positions[:, p] + turns[:, p] @ np.array(offset)
    parents = tuple(names.index(parent) if parent else -1 for parent, _, _ in JOINTS.values())
    return Clip(tuple(names), parents, offsets, turns, positions, float(np.median(values[:, 0])))


def _turn(values: Array, name: str, column: int | None) -> Array:
    """Of a joint against its parent in every frame, (T, 3, 3); the loins take half of what the chest turns."""
    if name == "spine":
        chest = JOINTS["chest"][2]
        return np.stack([qt.to_matrix(qt.half(np.roll(row[chest : chest + 4], -1))) for row in values])
    if column is None:
        return np.tile(np.eye(3), (len(values), 1, 1))
    if name in HINGES:
        return Rotation.from_rotvec(values[:, column, None] * qt.Z).as_matrix()
    return Rotation.from_quat(np.roll(values[:, column : column + 4], -1, axis=1)).as_matrix()
