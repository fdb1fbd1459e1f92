"""Coarse outfits, cut finer for the network's graph. `rest` space, metres.

The server cuts the same way (`toile-drape/src/refine.rs`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from garment.graph import mesh_edges

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Edges longer than this are halved, metres.
LONGEST = 0.03
#: Times that an edge is halved at most.
ROUNDS = 4
#: Vertices from which nothing is halved any more.
ENOUGH = 60_000


@dataclass(frozen=True)
class Refined:
    """A mesh whose long edges are halved. The vertices of the coarse mesh come first."""

    vertices: Floats  # (R, 3)
    triangles: Ints  # (F, 3)
    origin: Ints  # (R,) a vertex of the coarse mesh whose garment each vertex shares


def refined(vertices: Floats, triangles: Ints) -> Refined:
    """Halves the long edges of a mesh until none is left, or the mesh is large enough. (N, 3), (F, 3)."""
    mesh = Refined(vertices, triangles, np.arange(len(vertices)))
    for _ in range(ROUNDS):
        edges = mesh_edges(mesh.triangles)
        ends = mesh.vertices[edges]
        long = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) > LONGEST
        if len(mesh.vertices) >= ENOUGH or not long.any():
            break
        mesh = _halved(mesh, edges[long])
    return mesh


def _halved(mesh: Refined, edges: Ints) -> Refined:
    """Halves the given edges (E, 2), sorted."""
    count = len(mesh.vertices)
    middle = {(int(a), int(b)): count + k for k, (a, b) in enumerate(edges)}
    triangles = [piece for t in mesh.triangles.tolist() for piece in _cut(t, middle)]
    return Refined(
        np.concatenate([mesh.vertices, mesh.vertices[edges].mean(1)]),
        np.asarray(triangles, dtype=np.int64),
        np.concatenate([mesh.origin, mesh.origin[edges[:, 0]]]),
    )


def _cut(triangle: list[int], middle: dict[tuple[int, int], int]) -> list[list[int]]:
    """One triangle as one to four, by which of its edges have a middle."""
    a, b, c = triangle
    ab, bc, ca = (middle.get((min(p, q), max(p, q))) for p, q in ((a, b), (b, c), (c, a)))
    if ab is not None and bc is not None and ca is not None:
        return [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    if ab is None and bc is None and ca is None:
        return [triangle]
    while ab is None or ca is not None:  # turned until the edges with a middle come first
        (a, b, c), (ab, bc, ca) = (b, c, a), (bc, ca, ab)
    if bc is None:
        return [[a, ab, c], [ab, b, c]]
    return [[ab, b, bc], [a, ab, bc], [a, bc, c]]
