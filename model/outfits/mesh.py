"""Triangle meshes of garments and the few measurements everything here needs."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass
class GarmentMesh:
    """One garment in rest space (metres, Y up, facing +Z), outward triangles."""

    name: str
    kind: str
    layer: int
    vertices: Array  # (N, 3)
    triangles: Index  # (M, 3)
    material: dict = field(default_factory=dict)
    uv: Array | None = None  # (C, 2) one per corner vertex of `uv_triangles`
    uv_triangles: Index | None = None  # (M, 3) into `uv`


@dataclass
class OutfitMesh:
    """Garments in layer order, innermost first."""

    family: str
    seed: int
    garments: list[GarmentMesh]

    @property
    def vertex_count(self) -> int:
        return sum(len(g.vertices) for g in self.garments)


def edges_of(triangles: Index) -> tuple[Index, Index, Index]:
    """Unique edges (E, 2), the edge of each triangle side (M, 3) (side k is opposite corner k), and use counts (E,)."""
    sides = np.stack([triangles[:, [1, 2]], triangles[:, [2, 0]], triangles[:, [0, 1]]], 1).reshape(-1, 2)
    low, high = sides.min(1), sides.max(1)
    base = int(triangles.max()) + 1
    keys, inverse, counts = np.unique(low * base + high, return_inverse=True, return_counts=True)
    return np.stack([keys // base, keys % base], 1), inverse.reshape(-1, 3), counts


def boundary_vertices(triangles: Index, count: int) -> NDArray[np.bool_]:
    """Mask (count,) of vertices on an open boundary."""
    edges, _, uses = edges_of(triangles)
    mask = np.zeros(count, bool)
    mask[edges[uses == 1].ravel()] = True
    return mask


def face_normals(vertices: Array, triangles: Index) -> Array:
    """Area-weighted (twice the area) face normals, (M, 3)."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def vertex_normals(vertices: Array, triangles: Index) -> Array:
    """Area-weighted unit vertex normals, (N, 3)."""
    face = face_normals(vertices, triangles)
    out = np.stack([np.bincount(triangles.ravel(), np.repeat(face[:, k], 3), len(vertices)) for k in range(3)], 1)
    return out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-12)


def corner_angles(vertices: Array, triangles: Index) -> Array:
    """Corner angles in degrees, (M, 3)."""
    p = vertices[triangles]
    out = np.empty(triangles.shape)
    for k in range(3):
        u, v = p[:, (k + 1) % 3] - p[:, k], p[:, (k + 2) % 3] - p[:, k]
        norm = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
        out[:, k] = np.degrees(np.arccos(np.clip((u * v).sum(1) / np.maximum(norm, 1e-15), -1, 1)))
    return out


def area(vertices: Array, triangles: Index) -> float:
    """Surface area in square metres."""
    return float(np.linalg.norm(face_normals(vertices, triangles), axis=1).sum() / 2)


def compact(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """Drop vertices that no triangle uses."""
    used, inverse = np.unique(triangles, return_inverse=True)
    return vertices[used], inverse.reshape(-1, 3)


def components(triangles: Index, count: int) -> Index:
    """Connected component label of each triangle, (M,)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    rows = triangles[:, [0, 1]].ravel()
    cols = triangles[:, [1, 2]].ravel()
    graph = coo_matrix((np.ones(len(rows)), (rows, cols)), (count, count))
    return connected_components(graph, directed=False)[1][triangles[:, 0]]


def largest_component(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """Keep the component of largest area."""
    label = components(triangles, len(vertices))
    size = np.bincount(label, np.linalg.norm(face_normals(vertices, triangles), axis=1))
    return compact(vertices, triangles[label == size.argmax()])
