"""Does a pose leave room for cloth: arms clear of torso and thighs, legs clear of each other.

Distances are signed: from vertices of one part to the nearest vertex of the other, along that vertex's
normal, so that a hand deep in the belly counts as inside; a vertex counts as inside where it lies
mostly behind that normal and near it, because the normal says nothing about points beside or far off.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody, ShapedBody, vertex_normals
from body.humanoid import Rotations, joint_rotations

Array = NDArray[np.float64]
TORSO = ("root", "pelvis.L", "pelvis.R", "spine05", "spine04", "spine03", "spine02")
HEAD = ("head", "neck03", "neck02")
STRIDE = 3  # every third vertex is enough: skin edges are about 1 cm
DEEPEST = 0.15  # metres: nothing lies deeper than this inside a trunk
#: Least distance in metres of a part's skin from the torso's and the thighs'.
HAND_ROOM, UPPER_ARM_ROOM, LEG_ROOM = 0.03, 0.012, 0.01


@dataclass(frozen=True)
class Room:
    """Signed distances in metres, (left, right) arms and the legs: smallest of each part, in one pose."""

    forearms: tuple[float, float]
    upper_arms: tuple[float, float]
    hands_apart: float
    thighs: float
    shins: float


class Clearance:
    """One body shape, reduced to the vertices that are compared."""

    def __init__(self, body: AnnyBody, shaped: ShapedBody) -> None:
        owner = body.dense_skin.argmax(1)
        self.body, self.shaped = body, shaped
        kept = np.arange(0, len(owner), STRIDE)
        self.owner = np.array(body.joint_names)[owner[kept]]
        weights = body.dense_skin[kept]
        self.used = np.flatnonzero(weights.any(0))
        self.weights, self.rest = weights[:, self.used], shaped.rest_vertices[kept]
        self.normals = vertex_normals(shaped.rest_vertices, body.triangles)[kept]
        self.torso = np.flatnonzero(np.isin(self.owner, TORSO))
        self.head = np.flatnonzero(np.isin(self.owner, HEAD))
        part = lambda side, *starts: self._part(side, starts)  # noqa: E731
        self.forearm = [part(s, "lowerarm", "wrist", "metacarpal", "finger") for s in "LR"]
        self.upper_arm = [part(s, "upperarm02") for s in "LR"]
        self.thigh = [part(s, "upperleg") for s in "LR"]
        self.shin = [part(s, "lowerleg", "foot", "toe") for s in "LR"]
        rest = self.room({})
        self.thigh_room = min(rest.thighs, LEG_ROOM) - 0.012
        self.upper_arm_room = min(UPPER_ARM_ROOM, min(rest.upper_arms) - 0.004)

    def _part(self, side: str, starts: tuple[str, ...]) -> NDArray[np.int64]:
        return np.array([k for k, n in enumerate(self.owner) if n.endswith("." + side) and n.startswith(starts)])

    def posed(self, rotations: Rotations) -> tuple[Array, Array]:
        """Compared vertices and their normals in the pose, not grounded, (M, 3) each."""
        world = self.body.world_from_apose(self.shaped, joint_rotations(self.body, rotations))
        linear = world[:, :, :3] @ self.shaped.apose_from_rest
        shift = world[:, :, 3] - np.einsum("jab,jb->ja", linear, self.shaped.rest_heads)
        rows = np.concatenate([linear, shift[:, :, None]], 2)[self.used].reshape(-1, 12)
        m = (self.weights @ rows).reshape(-1, 3, 4)
        vertices = np.einsum("vab,vb->va", m[:, :, :3], self.rest) + m[:, :, 3]
        return vertices, np.einsum("vab,vb->va", m[:, :, :3], self.normals)

    def room(self, rotations: Rotations) -> Room:
        v, n = self.posed(rotations)

        def least(part: NDArray, other: NDArray) -> float:
            distance, near = cKDTree(v[other]).query(v[part])
            facing = np.einsum("va,va->v", v[part] - v[other[near]], n[other[near]])
            inside = (facing < -0.5 * distance) & (distance < DEEPEST)
            return float(np.where(inside, -distance, distance).min())

        trunk = np.concatenate([self.torso, self.head, *self.thigh])
        return Room(
            (least(self.forearm[0], trunk), least(self.forearm[1], trunk)),
            (least(self.upper_arm[0], self.torso), least(self.upper_arm[1], self.torso)),
            least(self.forearm[0], self.forearm[1]),
            least(self.thigh[0], self.thigh[1]),
            least(np.concatenate([self.shin[0]]), np.concatenate([self.shin[1], self.thigh[1]])),
        )

    def tight_arms(self, room: Room) -> tuple[bool, bool]:
        """Whether the left and the right arm come too near the trunk."""
        left, right = (
            f < HAND_ROOM or u < self.upper_arm_room for f, u in zip(room.forearms, room.upper_arms, strict=True)
        )
        return left, right

    def legs_clear(self, room: Room) -> bool:
        return room.thighs >= self.thigh_room and room.shins >= LEG_ROOM and room.hands_apart >= LEG_ROOM


@lru_cache(1)
def sample_bodies() -> tuple[Clearance, Clearance]:
    """The bodies that every sampled pose must suit: the reference body and a heavy one."""
    body = AnnyBody.load()
    return Clearance(body, body.shape()), Clearance(body, body.shape({"weight": 0.9, "gender": 0.8}))
