"""Let mesh edges follow a seam, so that the texture of two pattern pieces meets in a clean line."""

from __future__ import annotations

import numpy as np

from .marching import Field
from .mesh import Array, Index, boundary_vertices, corner_angles, edges_of
from .remesh import Surface, collapse_short, flip_to_delaunay, relax


def align(vertices: Array, triangles: Index, surface: Surface, seam: Field) -> tuple[Array, Index]:
    """Move the nearer end of every edge that crosses seam = 0 onto the seam, then even out the neighbours."""
    vertices = vertices.copy()
    on_seam = np.zeros(len(vertices), bool)
    fixed = boundary_vertices(triangles, len(vertices))
    for _ in range(3):
        side = np.where(on_seam, 0.0, seam(vertices))
        edges = edges_of(triangles)[0]
        crossing = edges[(side[edges[:, 0]] * side[edges[:, 1]] < 0) & ~fixed[edges].any(1)]
        if not len(crossing):
            break
        nearer = np.abs(side[crossing]).argmin(1)
        rows = np.arange(len(crossing))
        mover, other = crossing[rows, nearer], crossing[rows, 1 - nearer]
        t = (side[mover] / (side[mover] - side[other]))[:, None]
        vertices[mover] += t * (vertices[other] - vertices[mover])
        on_seam[mover] = True
    return _even_out(vertices, triangles, surface, on_seam)


def _even_out(vertices: Array, triangles: Index, surface: Surface, on_seam: Array) -> tuple[Array, Index]:
    for _ in range(4):
        triangles = flip_to_delaunay(vertices, triangles, keep=on_seam)
        moved = relax(vertices, triangles, surface, 0.4)
        vertices = np.where(on_seam[:, None], vertices, moved)
    triangles = flip_to_delaunay(vertices, triangles, keep=on_seam)
    # A triangle whose three corners lie on the seam is flat: its shortest side goes.
    for _ in range(3):
        angles = corner_angles(vertices, triangles)
        thin = np.flatnonzero(angles.min(1) < 15)
        chosen = edges_of(triangles)[1][thin, angles[thin].argmin(1)]
        vertices, triangles = collapse_short(vertices, triangles, (np.inf, np.inf), np.random.default_rng(1), chosen)
    return vertices, triangles
