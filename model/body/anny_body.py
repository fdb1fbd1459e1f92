"""Evaluate the baked body in numpy: shape -> rest body -> A-pose -> posed body.

Spaces: `rest` is Anny's rest state of a shape; `apose` is Anny's identity pose (what outfits are fitted
on), shifted so that its lowest vertex is at y = 0; `world` is posed. Rotations of a pose are local to
the joint's parent in the A-pose, about axes parallel to the world's. Metres, glTF axes.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import safe_open

Array = NDArray[np.float64]
ARTIFACT = Path(__file__).parents[1] / "artifacts" / "body.safetensors"
ANCHORS = {
    "gender": ("male", "female"),
    "age": ("newborn", "baby", "child", "young", "old"),
    "muscle": ("minmuscle", "averagemuscle", "maxmuscle"),
    "weight": ("minweight", "averageweight", "maxweight"),
    "height": ("minheight", "maxheight"),
    "proportions": ("idealproportions", "uncommonproportions"),
}
FIRST_ANCHOR = {"age": -1 / 3}
TAPE_TENSORS = ("measure_points", "measure_t", "measure_ranges", "volume_vertices", "volume_triangles")


@dataclass(frozen=True)
class ShapedBody:
    """One body shape: everything that does not depend on the pose."""

    coefficients: Array  # (K,)
    rest_vertices: Array  # (V, 3) rest
    rest_heads: Array  # (J, 3) rest
    apose_from_rest: Array  # (J, 3, 3) rotation of each joint from rest to A-pose
    apose_heads: Array  # (J, 3) A-pose, before `lift`
    apose_vertices: Array  # (V, 3) A-pose, lowest vertex at y = 0
    lift: float  # added to y so that the A-pose stands on the floor

    @property
    def joints(self) -> Array:
        """Joint positions in the A-pose, (J, 3)."""
        return self.apose_heads + np.array([0.0, self.lift, 0.0])


class AnnyBody:
    """The baked body. Load it once with `AnnyBody.load()`."""

    def __init__(self, tensors: dict[str, NDArray], meta: dict) -> None:
        self.meta = meta
        self.joint_names: list[str] = meta["joints"]
        self.phenotypes: list[str] = meta["phenotypes"]
        self.local_changes: list[str] = meta["local_changes"]
        self.triangles = tensors["triangles"].astype(np.int64)
        self.parents = tensors["joint_parents"]
        self.garment_joint = tensors["garment_joint"]
        self._t = {k: v.astype(np.float64) for k, v in tensors.items() if v.dtype == np.float32}
        self._mask = tensors["phenotype_mask"].astype(bool)
        self.shape_basis = tensors["shape_basis"].astype(np.float32) * tensors["shape_step"][:, None, None]
        self.skin_joints = tensors["skin_joints"].astype(np.int64)
        self.template_vertices = self._t["template_vertices"]
        self.tape = {name: tensors[name] for name in TAPE_TENSORS if name in tensors}  # see bake_measurements

    @staticmethod
    @lru_cache(1)
    def load(path: Path = ARTIFACT) -> AnnyBody:
        with safe_open(path, "numpy") as f:
            meta = json.loads(f.metadata()["toile"])
            return AnnyBody({k: f.get_tensor(k) for k in f.keys()}, meta)  # noqa: SIM118

    @cached_property
    def dense_skin(self) -> Array:
        """Skin weights as a dense matrix, (V, J)."""
        dense = np.zeros((len(self.skin_joints), len(self.joint_names)))
        rows = np.arange(len(dense))[:, None].repeat(self.skin_joints.shape[1], 1)
        np.add.at(dense, (rows, self.skin_joints), self._t["skin_weights"])
        return dense

    @cached_property
    def garment_skin(self) -> Array:
        """Skin weights over the reduced garment skeleton, (V, 36)."""
        out = np.zeros((len(self.skin_joints), int(self.garment_joint.max()) + 1))
        np.add.at(out.T, self.garment_joint, self.dense_skin.T)
        return out

    @cached_property
    def garment_joints(self) -> NDArray[np.int64]:
        """Index of each garment joint among all joints, (36,)."""
        return np.array([int(np.argmax(self.garment_joint == g)) for g in range(int(self.garment_joint.max()) + 1)])

    def coefficients(self, phenotypes: dict[str, float] | None = None, local: dict[str, float] | None = None) -> Array:
        """Shape coefficients (K,) of phenotypes in [0, 1] (default 0.5, age 2/3) and local changes in [-1, 1]."""
        values = dict.fromkeys(self.phenotypes, 0.5) | {"age": self.meta["reference_age"]} | (phenotypes or {})
        level: dict[str, float] = {}
        for name, anchors in ANCHORS.items():
            grid = np.linspace(FIRST_ANCHOR.get(name, 0.0), 1.0, len(anchors))
            for k, anchor in enumerate(anchors):
                level[anchor] = float(np.interp(values[name], grid, np.eye(len(anchors))[k]))
        factors = np.array([level[a] for a in self.meta["anchors"]])
        weights = np.where(self._mask, factors[None], 1.0).prod(1)
        changes = np.array([(local or {}).get(name, 0.0) for name in self.local_changes])
        signed = np.stack([np.maximum(changes, 0), np.maximum(-changes, 0)], 1).ravel()
        return np.concatenate([weights @ self._t["phenotype_projection"], signed])

    def shape(self, phenotypes: dict[str, float] | None = None, local: dict[str, float] | None = None) -> ShapedBody:
        c = self.coefficients(phenotypes, local)
        t = self._t
        rest = t["template_vertices"] + np.tensordot(c.astype(np.float32), self.shape_basis, 1)
        heads = t["joint_heads"] + np.tensordot(c, t["joint_heads_basis"], 1)
        rest_rotation = procrustes(t["joint_orientation"] + np.tensordot(c, t["joint_orientation_basis"], 1))
        to_apose = t["reference_orientation"] @ rest_rotation.transpose(0, 2, 1)
        to_apose[0] = np.eye(3)
        apose = heads.copy()
        apose[0, 1] = 0.0
        for j, p in enumerate(self.parents):
            if p >= 0:
                apose[j] = apose[p] + to_apose[p] @ (heads[j] - heads[p])
        root = t["reference_orientation"][0] @ rest_rotation[0].T
        full = to_apose.copy()
        full[0] = root
        vertices = self._skin(rest, full, apose - np.einsum("jab,jb->ja", full, heads))
        lift = -float(vertices[:, 1].min())
        return ShapedBody(c, rest, heads, full, apose, vertices + np.array([0, lift, 0]), lift)

    def world_from_apose(self, body: ShapedBody, rotations: Array, translation: Array | None = None) -> Array:
        """World rotations and positions of all joints, (J, 3, 4), for local rotations (J, 3, 3)."""
        world = np.zeros((len(self.parents), 3, 4))
        joints = body.joints
        for j, p in enumerate(self.parents):
            if p < 0:
                world[j, :, :3] = rotations[j]
                world[j, :, 3] = joints[j] + (0 if translation is None else translation)
            else:
                world[j, :, :3] = world[p, :, :3] @ rotations[j]
                world[j, :, 3] = world[p, :, 3] + world[p, :, :3] @ (joints[j] - joints[p])
        return world

    def pose(self, body: ShapedBody, world: Array) -> Array:
        """Posed vertices (V, 3) for joints (J, 3, 4) from `world_from_apose`."""
        linear = world[:, :, :3] @ body.apose_from_rest
        return self._skin(body.rest_vertices, linear, world[:, :, 3] - np.einsum("jab,jb->ja", linear, body.rest_heads))

    def garment_transforms(self, body: ShapedBody, world: Array) -> Array:
        """World-from-A-pose transforms of the garment skeleton, (36, 3, 4)."""
        g = self.garment_joints
        out = world[g].copy()
        out[:, :, 3] -= np.einsum("jab,jb->ja", out[:, :, :3], body.joints[g])
        return out

    def _skin(self, vertices: Array, linear: Array, shift: Array) -> Array:
        rows = np.concatenate([linear, shift[:, :, None]], 2).reshape(len(linear), 12)
        m = (self.dense_skin @ rows).reshape(-1, 3, 4)
        return np.einsum("vab,vb->va", m[:, :, :3], vertices) + m[:, :, 3]


def procrustes(m: Array) -> Array:
    """Nearest rotations to 3x3 matrices, (J, 3, 3)."""
    u, _, vt = np.linalg.svd(m)
    u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
    return u @ vt


def vertex_normals(vertices: Array, triangles: NDArray[np.int64]) -> Array:
    """Area-weighted unit vertex normals, (V, 3)."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    out = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(out, triangles[:, k], face)
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)
