"""Cloth laid flat with the least stretch (Liu et al. 2008, A Local/Global Approach to Mesh Parameterization).

Local: the rotation nearest to what happened to each triangle. Global: the places whose edges come nearest to the
turned ones. Metres.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.linalg import splu

from garment.graph import open_sides

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]

STEPS = 100


def flattened(vertices: Floats, triangles: Ints, steps: int = STEPS) -> Floats:
    """Places (N, 2) in its plane of one connected piece of cloth (N, 3), faces counter-clockwise.

    Its longest edge is its outline, others are holes. Raises ValueError for a piece that is closed or where two edges
    meet in one vertex.
    """
    loops = boundary_loops(triangles)
    if not loops:
        raise ValueError("the piece is closed: cut it open before it can lie flat")
    own = _own_frames(vertices, triangles)
    weight = _cotangents(own)
    stiffness = _stiffness(weight, triangles, len(vertices))
    # One vertex is held, or the piece could lie anywhere.
    solver = splu(stiffness[1:, 1:].tocsc())
    places = _on_a_disk(vertices, triangles, max(loops, key=lambda loop: _length(vertices[loop])))
    for _ in range(steps):
        turns = _nearest_rotations(own, places[triangles], weight)
        pulled = _pull(own @ turns.transpose(0, 2, 1), weight, triangles, len(vertices))
        places = np.concatenate([np.zeros((1, 2)), solver.solve(pulled[1:])])
    return places


def stretch(vertices: Floats, triangles: Ints, places: Floats) -> Floats:
    """Largest and least stretch of every triangle laid flat, (M, 2); 1 is none, a negative least is turned over."""
    own = _own_frames(vertices, triangles)
    edges, flat = (np.stack([p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]], -1) for p in (own, places[triangles]))
    map_ = flat @ np.linalg.inv(edges)
    values = np.linalg.svd(map_, compute_uv=False)
    return values * np.stack([np.ones(len(map_)), np.sign(np.linalg.det(map_))], -1)


def boundary_loops(triangles: Ints) -> list[Ints]:
    """Vertices around every edge of the cloth, in the order of the faces. Raises ValueError where it branches."""
    after: dict[int, int] = {}
    for a, b in open_sides(triangles)[0].tolist():
        if a in after:
            raise ValueError("two edges of the piece meet in one vertex: widen it there")
        after[a] = b
    loops = []
    while after:
        loop = [next(iter(after))]
        while (then := after.pop(loop[-1])) != loop[0]:
            loop.append(then)
        loops.append(np.array(loop))
    return loops


def _length(loop: Floats) -> float:
    return float(np.linalg.norm(loop - np.roll(loop, -1, 0), axis=1).sum())


def _own_frames(vertices: Floats, triangles: Ints) -> Floats:
    """Every triangle in a plane of its own, the first corner at the origin, (M, 3, 2)."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    along = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    up = np.cross(np.cross(b - a, c - a), along)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    return np.stack([np.stack([((p - a) * along).sum(1), ((p - a) * up).sum(1)], -1) for p in (a, b, c)], 1)


def _cotangents(own: Floats) -> Floats:
    """Half the cotangent opposite to side k, from corner k to k + 1, (M, 3); slivers are bounded."""
    out = np.empty(own.shape[:2])
    for k in range(3):
        u, v = own[:, k] - own[:, (k + 2) % 3], own[:, (k + 1) % 3] - own[:, (k + 2) % 3]
        cross = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
        out[:, k] = 0.5 * (u * v).sum(1) / np.maximum(cross, 1e-12)
    return np.clip(out, 0.01, 10.0)


def _stiffness(weight: Floats, triangles: Ints, count: int) -> csr_matrix:
    a, b = triangles.ravel(), np.roll(triangles, -1, 1).ravel()
    w = weight.ravel()
    rows, columns = np.concatenate([a, b, a, b]), np.concatenate([a, b, b, a])
    return coo_matrix((np.concatenate([w, w, -w, -w]), (rows, columns)), (count, count)).tocsr()


def _nearest_rotations(own: Floats, placed: Floats, weight: Floats) -> Floats:
    """Rotations (M, 2, 2) that take own edges nearest to placed ones."""
    edges, flat = (np.roll(p, -1, 1) - p for p in (own, placed))
    across = np.einsum("mk,mki,mkj->mij", weight, flat, edges)
    cos, sin = across[:, 0, 0] + across[:, 1, 1], across[:, 1, 0] - across[:, 0, 1]
    length = np.maximum(np.hypot(cos, sin), 1e-20)
    cos, sin = cos / length, sin / length
    return np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], 1)


def _pull(turned: Floats, weight: Floats, triangles: Ints, count: int) -> Floats:
    """What turned edges ask of the vertices at their ends, (N, 2)."""
    edges = weight[..., None] * (np.roll(turned, -1, 1) - turned)
    pull = np.zeros((count, 2))
    np.add.at(pull, np.roll(triangles, -1, 1).ravel(), edges.reshape(-1, 2))
    np.subtract.at(pull, triangles.ravel(), edges.reshape(-1, 2))
    return pull


def _on_a_disk(vertices: Floats, triangles: Ints, loop: Ints) -> Floats:
    """A first map without folds: the edge on a circle, everything else amid its neighbours (Tutte 1963)."""
    steps = np.linalg.norm(vertices[loop] - vertices[np.roll(loop, -1)], axis=1)
    angle = 2 * np.pi * np.concatenate([[0], np.cumsum(steps)[:-1]]) / steps.sum()
    places = np.zeros((len(vertices), 2))
    places[loop] = steps.sum() / (2 * np.pi) * np.stack([np.cos(angle), np.sin(angle)], 1)
    inside = np.setdiff1d(np.arange(len(vertices)), loop)
    even = _stiffness(np.ones(triangles.shape), triangles, len(vertices))
    places[inside] = splu(even[inside][:, inside].tocsc()).solve(-even[inside][:, loop] @ places[loop])
    return places
