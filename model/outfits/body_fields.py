"""What garments need to know of a body: its signed distance, horizontal outlines, and arm axes.

All in rest space (A-pose, metres, Y up, facing +Z). Computed once per body and kept beside the data.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d, map_coordinates
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody, ShapedBody

from .mesh import Array, Index, vertex_normals

CACHE = Path(__file__).parents[1] / "data" / "body_fields"
STEP = 0.008
LOW = np.array([-0.64, -0.02, -0.24])
HIGH = np.array([0.64, 1.90, 0.42])
OUTLINE_LOW, OUTLINE_STEP, OUTLINE_COUNT = 0.03, 0.01, 182
ANGLES = 96


@dataclass(frozen=True)
class Outlines:
    """Convex horizontal outlines: radius over height and angle about a centre line."""

    centre: Array  # (H, 2) x and z
    radius: Array  # (H, ANGLES), angle from +x towards +z


@dataclass(frozen=True)
class BodyFields:
    """Lookups on one body."""

    points: Array  # (P, 3) dense samples of the skin
    normals: Array  # (P, 3)
    tree: cKDTree
    distance_grid: Array  # signed distance at STEP, slightly smoothed
    trunk: Outlines  # torso, hips and both legs, without arms and head
    leg: Outlines  # the left leg (x > 0)
    cape: Outlines  # trunk and upper arms
    arm: Array  # (3, 3) left shoulder, elbow, wrist
    arm_radius: Array  # (K,) largest distance from the arm's axis at arc length k * 0.02

    def distance(self, p: Array) -> Array:
        """Signed distance to the smoothed skin at points (N, 3), metres, negative inside."""
        q = np.clip(p, LOW, HIGH - STEP)
        outside = np.linalg.norm(p - q, axis=1)
        return map_coordinates(self.distance_grid, ((q - LOW) / STEP).T, order=1, mode="nearest") + outside

    def clearance(self, p: Array) -> tuple[Array, Array]:
        """Distance from points (N, 3) to the skin along its nearest normal, and that normal (N, 3)."""
        _, nearest = self.tree.query(p, k=3)
        offset = ((p[:, None] - self.points[nearest]) * self.normals[nearest]).sum(2)
        return offset.min(1), self.normals[nearest[:, 0]]


@lru_cache(2)
def _load(path: str) -> BodyFields:
    data = np.load(path)
    outlines = {k: Outlines(data[k + "_centre"], data[k + "_radius"]) for k in ("trunk", "leg", "cape")}
    points, normals = data["points"].astype(float), data["normals"].astype(float)
    return BodyFields(
        points, normals, cKDTree(points), data["grid"], **outlines, arm=data["arm"], arm_radius=data["arm_radius"]
    )


def body_fields(model: AnnyBody, body: ShapedBody) -> BodyFields:
    """Fields of a body; a few seconds the first time, then read from the cache."""
    digest = hashlib.sha256(body.apose_vertices.astype(np.float32).tobytes() + b"5").hexdigest()[:16]
    path = CACHE / f"{digest}.npz"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch = path.with_suffix(f".{np.random.default_rng().integers(1 << 40)}.npz")
        np.savez_compressed(scratch, **_measure(model, body))
        scratch.rename(path)
    return _load(str(path))


def _measure(model: AnnyBody, body: ShapedBody) -> dict[str, Array]:
    vertices, names = body.apose_vertices, model.joint_names
    normals = vertex_normals(vertices, model.triangles)
    part = _part_weights(model)
    points, point_normals, weights = _dense_samples(vertices, normals, part, model.triangles)
    arm = np.array([body.joints[names.index(n)] for n in ("upperarm01.L", "lowerarm01.L", "wrist.L")])
    legs = weights[:, 1] + weights[:, 3]
    trunk = weights[:, 0] + legs > 0.5
    out = {"points": points.astype(np.float32), "normals": point_normals.astype(np.float32), "arm": arm}
    out["grid"] = _distance_grid(points, point_normals)
    out["arm_radius"] = _arm_profile(points[(weights[:, 2] > 0.6) & (points[:, 0] > 0)], arm)
    left = (points[:, 0] > 0) & (points[:, 1] < 1.0) & (legs > 0.3)
    near_arm = (weights[:, 2] > 0.5) & (points[:, 1] > 1.2)
    for key, mask in (("trunk", trunk), ("leg", left), ("cape", trunk | near_arm)):
        outlines = _outlines(points[mask], keep_centre=key != "leg")
        out[key + "_centre"], out[key + "_radius"] = outlines.centre, outlines.radius
    return out


def _part_weights(model: AnnyBody) -> Array:
    """Skin weight of (trunk, left leg, arms, right leg, head) per vertex, (V, 5)."""
    names = [model.joint_names[j] for j in model.garment_joints]

    def group(name: str) -> int:
        if any(k in name for k in ("leg", "foot")):
            return 1 if name.endswith(".L") else 3
        if any(k in name for k in ("arm", "wrist")):
            return 2
        return 4 if name == "head" else 0

    out = np.zeros((len(model.garment_skin), 5))
    for j, name in enumerate(names):
        out[:, group(name)] += model.garment_skin[:, j]
    return out


def _dense_samples(vertices: Array, normals: Array, part: Array, triangles: Index) -> tuple[Array, Array, Array]:
    """Sample every triangle at 10 barycentric points: positions, interpolated unit normals, part weights."""
    grid = np.array([(i, j, 3 - i - j) for i in range(4) for j in range(4 - i)]) / 3.0
    inner = 0.9 * grid + 0.1 / 3
    p = np.einsum("sk,tkd->tsd", inner, vertices[triangles]).reshape(-1, 3)
    n = np.einsum("sk,tkd->tsd", inner, normals[triangles]).reshape(-1, 3)
    w = np.einsum("sk,tkd->tsd", inner, part[triangles]).reshape(-1, 5)
    return p, n / np.linalg.norm(n, axis=1, keepdims=True), w


def _distance_grid(points: Array, normals: Array) -> Array:
    """Signed distance on the lattice: exact within 6 cm of the skin, interpolated from every fourth node beyond."""
    axes = [np.arange(lo, hi, STEP) for lo, hi in zip(LOW, HIGH, strict=True)]
    tree = cKDTree(points)
    coarse = [np.append(a[::4], a[::4][-1] + 4 * STEP) for a in axes]
    shape = [len(a) for a in coarse]
    far = _signed_distance(tree, normals, np.stack(np.meshgrid(*coarse, indexing="ij"), -1).reshape(-1, 3)).reshape(
        shape
    )
    index = np.stack(np.meshgrid(*[np.arange(len(a)) for a in axes], indexing="ij"), -1).reshape(-1, 3)
    signed = map_coordinates(far, index.T / 4.0, order=1)
    near = np.abs(signed) < 0.06
    signed[near] = _signed_distance(tree, normals, LOW + STEP * index[near])
    return gaussian_filter(signed.reshape([len(a) for a in axes]), 1.0).astype(np.float32)


def _signed_distance(tree: cKDTree, normals: Array, p: Array) -> Array:
    far, nearest = tree.query(p)
    plane = ((p - tree.data[nearest]) * normals[nearest]).sum(1)
    return np.where(far < 0.012, plane, np.copysign(far, plane))


def _arm_profile(points: Array, arm: Array) -> Array:
    along, across = arm_coordinates(points, arm)
    bins = [across[np.abs(along - s) < 0.02] for s in np.arange(0, 0.60, 0.02)]
    radius = np.array([np.percentile(b, 95) if len(b) else np.nan for b in bins])
    good = np.isfinite(radius)
    filled = np.interp(np.arange(len(radius)), np.flatnonzero(good), radius[good])
    return gaussian_filter1d(filled, 1.5, mode="nearest")


def arm_coordinates(p: Array, arm: Array) -> tuple[Array, Array]:
    """Arc length along the left arm from the shoulder and distance from its axis; x is mirrored. (N,), (N,)."""
    q = np.stack([np.abs(p[:, 0]), p[:, 1], p[:, 2]], 1)
    lengths = np.linalg.norm(np.diff(arm, axis=0), axis=1)
    results = []
    for k in range(2):
        direction = (arm[k + 1] - arm[k]) / lengths[k]
        s = (q - arm[k]) @ direction
        foot = np.maximum(s, 0) if k else np.minimum(s, lengths[0])
        results.append((s + k * lengths[0], np.linalg.norm(q - arm[k] - foot[:, None] * direction, axis=1)))
    (s0, d0), (s1, d1) = results
    # Blend over the elbow, so that sleeves bend without a crease.
    t = np.clip((0.5 * (s0 + s1) - lengths[0]) / 0.12 + 0.5, 0, 1)
    t = t * t * (3 - 2 * t)
    return (1 - t) * s0 + t * s1, (1 - t) * d0 + t * d1


def _outlines(points: Array, keep_centre: bool) -> Outlines:
    heights = OUTLINE_LOW + OUTLINE_STEP * np.arange(OUTLINE_COUNT)
    angles = np.arange(ANGLES) * 2 * np.pi / ANGLES
    directions = np.stack([np.cos(angles), np.sin(angles)], 1)
    slices = [points[np.abs(points[:, 1] - h) < 0.009][:, [0, 2]] for h in heights]
    full = np.array([len(s) > 20 for s in slices])
    centre = np.array([(s.min(0) + s.max(0)) / 2 if ok else [np.nan] * 2 for s, ok in zip(slices, full, strict=True)])
    if keep_centre:
        centre[:, 0] = np.where(full, 0.0, np.nan)
    centre = np.stack([_fill(c, full) for c in centre.T], 1)
    centre = gaussian_filter1d(centre, 6, axis=0, mode="nearest")
    support = np.full((OUTLINE_COUNT, ANGLES), np.nan)
    for k in np.flatnonzero(full):
        support[k] = ((slices[k] - centre[k]) @ directions.T).max(0)
    facing = np.cos(angles[:, None] - angles)
    ratio = np.where(facing > 0.2, support[:, None, :] / np.maximum(facing, 0.2), np.inf)
    radius = ratio.min(2)
    radius = np.stack([_fill(r, full) for r in radius.T], 1)
    radius = gaussian_filter1d(radius, 1.5, axis=1, mode="wrap")
    return Outlines(centre, gaussian_filter1d(radius, 1.2, axis=0, mode="nearest"))


def _fill(values: Array, good: Array) -> Array:
    return np.interp(np.arange(len(values)), np.flatnonzero(good), values[good])
