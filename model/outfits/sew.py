"""Turn shapes into finished meshes: extract, trim, remesh, and keep clear of the body and of inner layers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from .body_fields import BodyFields
from .marching import COARSE, level_set, trim
from .mesh import Array, GarmentMesh, Index, largest_component, vertex_normals
from .pattern import Shape
from .remesh import Surface, flip_to_delaunay, kites, relax, remesh, subdivide
from .seams import align

TRIANGULATIONS = ("isotropic", "subdivided", "kites", "kites_alternating")
FACTOR = {"isotropic": 1.0, "subdivided": 5.5, "kites": 9.0, "kites_alternating": 9.0}
GAP = 0.003


@dataclass(frozen=True)
class Cloth:
    """How finely and in which pattern a garment is meshed."""

    density: int  # vertices per square metre
    triangulation: str = "isotropic"
    seamed: bool = False  # mesh edges follow the armhole


def sew(shape: Shape, body: BodyFields, worn: list[GarmentMesh], cloth: Cloth) -> GarmentMesh:
    """Mesh a shape worn over `worn`; the result keeps clear of the body and of them."""
    # Coarser base meshes would lose the necklines.
    edge = min(float(np.sqrt(FACTOR[cloth.triangulation] / (0.80 * cloth.density))), 0.055)
    vertices, triangles = _cut_out(shape, float(np.clip(1.15 * edge, 0.006, 0.026)))
    vertices, triangles = remesh(vertices, triangles, shape.surface, edge)
    if cloth.seamed and shape.seam is not None:
        vertices, triangles = align(vertices, triangles, shape.surface, shape.seam)
    vertices, triangles = retriangulate(vertices, triangles, shape.surface, cloth.triangulation)
    vertices = keep_clear(vertices, triangles, body, shape.pattern.skin, worn)
    return GarmentMesh(shape.pattern.name, shape.pattern.kind, len(worn), vertices, triangles)


def _cut_out(shape: Shape, step: float) -> tuple[Array, Index]:
    low = shape.low.copy()
    # A lattice plane at x = 0 keeps the narrow gap between two trouser legs open.
    low[0] = -COARSE * step * np.ceil(-low[0] / (COARSE * step))
    vertices, triangles = level_set(shape.surface.f, low, shape.high, step)
    return largest_component(*trim(vertices, triangles, shape.surface.g))


def retriangulate(vertices: Array, triangles: Index, surface: Surface, style: str) -> tuple[Array, Index]:
    if style == "subdivided":
        vertices, triangles = subdivide(vertices, triangles, surface)
    elif style.startswith("kites"):
        vertices, triangles = kites(vertices, triangles, surface, 2 if style.endswith("alternating") else 0)
    else:
        return vertices, triangles
    # Quads keep their diagonals but where that would leave a sliver.
    below = 180.0 if style == "subdivided" else 20.0
    for _ in range(3):
        triangles = flip_to_delaunay(vertices, triangles, below)
        vertices = relax(vertices, triangles, surface, 0.25)
    return vertices, flip_to_delaunay(vertices, triangles, below)


def keep_clear(vertices: Array, triangles: Index, body: BodyFields, skin: float, worn: list[GarmentMesh]) -> Array:
    """Push vertices out until they and the triangle centroids keep their distance from skin and inner layers."""
    vertices = vertices.copy()
    wanted = 0.0024 if skin < 0.005 else 0.0045
    inner = [_Layer(g) for g in worn]
    for _ in range(8):
        probes = np.concatenate([vertices, vertices[triangles].mean(1)])
        distance, normal = body.clearance(probes)
        push = np.maximum(wanted - distance, 0)[:, None] * normal
        for layer in inner:
            push += layer.push(probes, GAP + 0.0006)
        if not push.any():
            break
        vertices += _spread(push, triangles, len(vertices))
    return vertices


def _spread(push: Array, triangles: Index, count: int) -> Array:
    """Pushes of vertices and of centroids as pushes of vertices: the longest wins."""
    own, faces = push[:count], push[count:]
    best = own.copy()
    length = np.linalg.norm(best, axis=1)
    for k in range(3):
        size = np.linalg.norm(faces, axis=1)
        order = np.argsort(size)
        strongest = np.zeros((count, 3))
        strongest[triangles[order, k]] = faces[order]
        s = np.linalg.norm(strongest, axis=1)
        better = s > length
        best[better], length[better] = strongest[better], s[better]
    return best * 1.02


class _Layer:
    """Dense samples of an inner garment with normals."""

    def __init__(self, garment: GarmentMesh) -> None:
        v, t = garment.vertices, garment.triangles
        n = vertex_normals(v, t)
        grid = np.array([(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)]) / 4.0
        self.points = np.einsum("sk,tkd->tsd", grid, v[t]).reshape(-1, 3)
        normals = np.einsum("sk,tkd->tsd", grid, n[t]).reshape(-1, 3)
        self.normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
        self.tree = cKDTree(self.points)

    def push(self, p: Array, gap: float) -> Array:
        """Displacements (N, 3) that bring points at least `gap` outside where they lie over this garment."""
        far, nearest = self.tree.query(p, distance_upper_bound=0.03)
        hit = np.isfinite(far)
        out = np.zeros_like(p)
        offset = p[hit] - self.points[nearest[hit]]
        normal = self.normals[nearest[hit]]
        height = (offset * normal).sum(1)
        sideways = np.linalg.norm(offset - height[:, None] * normal, axis=1)
        over = sideways < 0.02
        out[hit] = (np.maximum(gap - height, 0) * over)[:, None] * normal
        return out
