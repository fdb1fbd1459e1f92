"""Isotropic remeshing of a trimmed level set: split, collapse, flip, relax, project.

The scheme of Botsch and Kobbelt, "A remeshing approach to multiresolution modeling" (SGP 2004), in array form:
each pass works on an independent set of edges. Interior vertices stay on f = 0, boundary vertices on f = g = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .marching import Field
from .mesh import Array, Index, boundary_vertices, compact, corner_angles, edges_of, face_normals


@dataclass(frozen=True)
class Surface:
    """The level set f = 0 trimmed to g < 0."""

    f: Field
    g: Field

    def project(self, p: Array, on_trim: Array, rounds: int = 3) -> Array:
        """Move points (N, 3) back to f = 0, and those of the mask `on_trim` (N,) to f = g = 0 too."""
        p = p.copy()
        rim = np.flatnonzero(on_trim)
        for _ in range(rounds):
            p += _newton_step(self.f, p)
            if len(rim):
                q = p[rim]
                for _ in range(2):
                    q += _newton_step(self.g, q)
                    q += _newton_step(self.f, q)
                p[rim] = q + _newton_step(self.g, q)
        return p


def _newton_step(f: Field, p: Array, delta: float = 2e-3, longest: float = 8e-3) -> Array:
    axes = np.concatenate([np.eye(3), -np.eye(3)]) * delta
    values = f((p[None] + axes[:, None]).reshape(-1, 3)).reshape(6, -1)
    gradient = (values[:3] - values[3:]).T / (2 * delta)
    step = -(f(p) / np.maximum((gradient**2).sum(1), 0.1))[:, None] * gradient
    length = np.linalg.norm(step, axis=1, keepdims=True)
    return step * np.minimum(1, longest / np.maximum(length, 1e-12))


def remesh(vertices: Array, triangles: Index, surface: Surface, edge: float, passes: int = 6) -> tuple[Array, Index]:
    """Remesh to target edge length `edge` (metres)."""
    rng = np.random.default_rng(len(vertices))
    for i in range(50):
        count = len(vertices)
        vertices, triangles = collapse_short(vertices, triangles, (0.75 * edge, 1.4 * edge), rng)
        if i % 2:
            triangles = flip_to_delaunay(vertices, triangles)
        if i % 6 == 5:
            vertices = relax(vertices, triangles, surface, 0.3)
        if len(vertices) > 0.985 * count:
            break
    for i in range(passes):
        vertices, triangles = split_long(vertices, triangles, 1.38 * edge)
        for _ in range(2):
            vertices, triangles = collapse_short(vertices, triangles, (0.75 * edge, 1.38 * edge), rng)
        for _ in range(2):
            triangles = flip_to_delaunay(vertices, triangles)
        vertices = relax(vertices, triangles, surface, 0.5 if i < passes - 2 else 0.3)
    for _ in range(4):
        triangles = flip_to_delaunay(vertices, triangles)
    return remove_slivers(vertices, triangles, surface)


def remove_slivers(vertices: Array, triangles: Index, surface: Surface) -> tuple[Array, Index]:
    """Collapse the shortest side of triangles with an angle below 22 degrees, then relax once."""
    rng = np.random.default_rng(1)
    for _ in range(3):
        angles = corner_angles(vertices, triangles)
        thin = np.flatnonzero(angles.min(1) < 22)
        if len(thin) == 0:
            break
        _, sides, _ = edges_of(triangles)
        chosen = sides[thin, angles[thin].argmin(1)]
        vertices, triangles = collapse_short(vertices, triangles, (np.inf, np.inf), rng, chosen)
        for _ in range(2):
            triangles = flip_to_delaunay(vertices, triangles)
        vertices = relax(vertices, triangles, surface, 0.3)
        triangles = flip_to_delaunay(vertices, triangles)
    return vertices, triangles


def split_long(vertices: Array, triangles: Index, longest: float) -> tuple[Array, Index]:
    """Split every edge that is longer than `longest` and the longest of its triangles."""
    edges, sides, _ = edges_of(triangles)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    rank = length + np.arange(len(length)) * 1e-12
    top = np.zeros(len(edges))
    np.maximum.at(top, sides.ravel(), rank[sides].max(1).repeat(3))
    chosen = (length > longest) & (rank >= top)
    if not chosen.any():
        return vertices, triangles
    new_id = np.full(len(edges), -1)
    new_id[chosen] = len(vertices) + np.arange(chosen.sum())
    vertices = np.concatenate([vertices, vertices[edges[chosen]].mean(1)])
    hit = new_id[sides] >= 0
    rows = np.flatnonzero(hit.any(1))
    k = hit[rows].argmax(1)
    a, b, c = (triangles[rows, (k + s) % 3] for s in range(3))
    middle = new_id[sides[rows, k]]
    pieces = [triangles[~hit.any(1)], np.stack([a, b, middle], 1), np.stack([a, middle, c], 1)]
    return vertices, np.concatenate(pieces)


def collapse_short(
    vertices: Array,
    triangles: Index,
    bounds: tuple[float, float],
    rng: np.random.Generator,
    only: Index | None = None,
) -> tuple[Array, Index]:
    """Collapse an independent set of edges below the first of `bounds`.

    None may make an edge longer than the second bound, flip a triangle or make a sliver; `only` restricts the edges.
    """
    shortest, longest = bounds
    edges, _, uses = edges_of(triangles)
    i, j = edges.T
    rim = np.zeros(len(vertices), bool)
    rim[edges[uses == 1].ravel()] = True
    length = np.linalg.norm(vertices[i] - vertices[j], axis=1)
    allowed = (
        (length < shortest) & ~(rim[i] & rim[j] & (uses == 2)) & _link_condition(edges, triangles, uses, len(vertices))
    )
    if only is not None:
        allowed &= np.isin(np.arange(len(edges)), only)
    if not allowed.any():
        return vertices, triangles
    for _ in range(2):
        chosen = _independent(
            edges, np.where(allowed, length * (1 + 0.1 * rng.random(len(edges))), np.inf), len(vertices)
        )
        target = np.where((rim[i] & ~rim[j])[:, None], vertices[i], vertices[edges].mean(1))
        target = np.where((rim[j] & ~rim[i])[:, None], vertices[j], target)
        bad = _spoiled(vertices, triangles, edges, (chosen, target, longest))
        allowed &= ~bad
        chosen &= ~bad
        if chosen.any():
            break
    vertices = vertices.copy()
    vertices[i[chosen]] = target[chosen]
    merged = np.arange(len(vertices))
    merged[j[chosen]] = i[chosen]
    triangles = merged[triangles]
    keep = (triangles != np.roll(triangles, 1, 1)).all(1)
    return compact(vertices, triangles[keep])


def _link_condition(edges: Index, triangles: Index, uses: Index, count: int) -> Array:
    """An edge may collapse only if its ends share exactly the neighbours opposite to it."""
    from scipy.sparse import coo_matrix

    ones = np.ones(2 * len(edges), np.int32)
    both = np.concatenate([edges, edges[:, ::-1]])
    adjacency = coo_matrix((ones, both.T), (count, count)).tocsr()
    shared = np.asarray(adjacency[edges[:, 0]].multiply(adjacency[edges[:, 1]]).sum(1)).ravel()
    return shared == uses


def _independent(edges: Index, rank: Array, count: int) -> Array:
    """Edges whose finite rank is the least of all that touch the rings of their ends: no triangle has two of them."""
    least = np.full(count, np.inf)
    np.minimum.at(least, edges.ravel(), rank.repeat(2))
    spread = least.copy()
    np.minimum.at(spread, edges[:, 0], least[edges[:, 1]])
    np.minimum.at(spread, edges[:, 1], least[edges[:, 0]])
    return np.isfinite(rank) & (rank <= spread[edges[:, 0]]) & (rank <= spread[edges[:, 1]])


def _spoiled(vertices: Array, triangles: Index, edges: Index, plan: tuple[Array, Array, float]) -> Array:
    """Which chosen edges would flip a triangle, make a sliver or an edge that is too long."""
    chosen, target, longest = plan
    owner = np.full(len(vertices), -1)
    rows = np.flatnonzero(chosen)
    owner[edges[rows].ravel()] = rows.repeat(2)
    corner_owner = owner[triangles]
    touched = (corner_owner >= 0).sum(1) == 1
    faces, owners = triangles[touched], corner_owner[touched]
    after = vertices[faces]
    moved = owners >= 0
    after[moved] = target[owners[moved]]
    before_n = face_normals(vertices, faces)
    after_n = np.cross(after[:, 1] - after[:, 0], after[:, 2] - after[:, 0])
    norm = np.linalg.norm(before_n, axis=1) * np.linalg.norm(after_n, axis=1)
    sides = np.linalg.norm(after - np.roll(after, 1, 1), axis=2)
    sides_before = np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, 1)], axis=2)
    quality = np.linalg.norm(after_n, axis=1) / sides.max(1) ** 2
    quality_before = np.linalg.norm(before_n, axis=1) / np.maximum(sides_before.max(1), 1e-9) ** 2
    thin = quality < np.minimum(0.25, 0.8 * quality_before)
    wrong = ((before_n * after_n).sum(1) < 0.3 * norm) & (np.linalg.norm(before_n, axis=1) > 1e-9)
    flagged = wrong | thin | (sides.max(1) > longest)
    bad = np.zeros(len(edges), bool)
    bad[owners.max(1)[flagged]] = True
    return bad


def flip_to_delaunay(vertices: Array, triangles: Index, below: float = 180.0, keep: Array | None = None) -> Index:
    """Flip an independent set of interior edges whose opposite angles sum to more than 180 degrees.

    Only edges of triangles with an angle under `below` degrees are considered; edges between two vertices of the
    mask `keep` (N,) stay.
    """
    edges, sides, uses = edges_of(triangles)
    angles = corner_angles(vertices, triangles)
    total = np.bincount(sides.ravel(), angles.ravel(), len(edges))
    flat = sides.ravel()
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], np.arange(len(edges)))
    thin = np.bincount(sides.ravel(), (angles.min(1) < below).repeat(3), len(edges)) > 0
    free = thin if keep is None else thin & ~keep[edges].all(1)
    rows = np.flatnonzero((uses == 2) & (total > 181) & free)
    if len(rows) == 0:
        return triangles
    first, second = order[starts[rows]], order[starts[rows] + 1]
    t1, k1, t2, k2 = first // 3, first % 3, second // 3, second % 3
    c, a, b = triangles[t1, k1], triangles[t1, (k1 + 1) % 3], triangles[t1, (k1 + 2) % 3]
    d = triangles[t2, k2]
    base = len(vertices)
    known = edges[:, 0] * base + edges[:, 1]
    fresh = ~np.isin(np.minimum(c, d) * base + np.maximum(c, d), known)
    fine = fresh & _flip_keeps_shape(vertices, (a, b, c, d))
    best = np.full(len(triangles), -np.inf)
    gain = np.where(fine, total[rows] + rows * 1e-9, -np.inf)
    np.maximum.at(best, t1, gain)
    np.maximum.at(best, t2, gain)
    take = fine & (gain >= best[t1]) & (gain >= best[t2])
    key = np.minimum(c, d) * base + np.maximum(c, d)
    unique = np.zeros(len(rows), bool)
    unique[np.flatnonzero(take)[np.unique(key[take], return_index=True)[1]]] = True
    out = triangles.copy()
    out[t1[unique]] = np.stack([c, a, d], 1)[unique]
    out[t2[unique]] = np.stack([c, d, b], 1)[unique]
    return out


def _flip_keeps_shape(vertices: Array, quad: tuple[Index, Index, Index, Index]) -> Array:
    a, b, c, d = (vertices[q] for q in quad)
    old = np.cross(a - c, b - c) + np.cross(b - d, a - d)
    new1, new2 = np.cross(a - c, d - c), np.cross(d - c, b - c)
    norm = np.linalg.norm(old, axis=1)
    return ((new1 * old).sum(1) > 0.3 * norm * np.linalg.norm(new1, axis=1)) & (
        (new2 * old).sum(1) > 0.3 * norm * np.linalg.norm(new2, axis=1)
    )


def relax(vertices: Array, triangles: Index, surface: Surface, amount: float) -> Array:
    """Move vertices towards the centre of their ring (rim vertices along the rim) and back to the surface."""
    edges, _, uses = edges_of(triangles)
    rim = boundary_vertices(triangles, len(vertices))
    kept = (uses == 1) | ~(rim[edges[:, 0]] & rim[edges[:, 1]])
    i, j = edges[kept].T
    rim_edge = uses[kept] == 1
    total = np.zeros_like(vertices)
    count = np.zeros(len(vertices))
    for a, b in ((i, j), (j, i)):
        use = ~rim[a] | rim_edge
        for k in range(3):
            total[:, k] += np.bincount(a[use], vertices[b[use], k], len(vertices))
        count += np.bincount(a[use], minlength=len(vertices))
    centre = total / np.maximum(count, 1)[:, None]
    moved = np.where(count[:, None] > 1, vertices + amount * (centre - vertices), vertices)
    return surface.project(moved, rim, 1)


def subdivide(vertices: Array, triangles: Index, surface: Surface) -> tuple[Array, Index]:
    """Cut each triangle into four, and project the new vertices."""
    edges, sides, _ = edges_of(triangles)
    m = sides + len(vertices)
    a, b, c = triangles.T
    out = np.concatenate(
        [np.stack(t, 1) for t in ((a, m[:, 2], m[:, 1]), (m[:, 2], b, m[:, 0]), (m[:, 1], m[:, 0], c), m.T)]
    )
    vertices = np.concatenate([vertices, vertices[edges].mean(1)])
    return surface.project(vertices, boundary_vertices(out, len(vertices)), 2), out


def kites(vertices: Array, triangles: Index, surface: Surface, diagonal: int) -> tuple[Array, Index]:
    """Cut each triangle into three quads, split by one diagonal (0), the other (1) or alternately (2)."""
    edges, sides, _ = edges_of(triangles)
    m = sides + len(vertices)
    centre = len(vertices) + len(edges) + np.arange(len(triangles))
    pieces = []
    for k in range(3):
        corner, left, right = triangles[:, k], m[:, (k + 2) % 3], m[:, (k + 1) % 3]
        long = np.stack([np.stack([corner, left, centre], 1), np.stack([corner, centre, right], 1)], 1)
        short = np.stack([np.stack([corner, left, right], 1), np.stack([left, centre, right], 1)], 1)
        pick = np.full(len(triangles), diagonal) if diagonal < 2 else (np.arange(len(triangles)) + k) % 2
        pieces.append(np.where(pick[:, None, None] == 0, long, short).reshape(-1, 3))
    out = np.concatenate(pieces)
    vertices = np.concatenate([vertices, vertices[edges].mean(1), vertices[triangles].mean(1)])
    return surface.project(vertices, boundary_vertices(out, len(vertices)), 2), out
