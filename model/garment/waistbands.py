"""Which cloth a waistband holds: physics alone would let skirts and trousers slide to the hips."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]

#: m from the skin within which a border can be a waistband, over what is tucked in; m above the hem at least.
NEAR, ABOVE = 0.06, 0.1
#: Share of the body's height from which a garment hangs from the shoulders.
SHOULDERS = 0.77


def held(rest: Floats, triangles: Ints, garment: Ints, body: Floats) -> Ints:
    """Vertices of the highest border near the skin of every garment that does not reach the shoulders.

    rest (N, 3), triangles (T, 3), garment (N,), body (V, 3): all in the A-pose.
    """
    edges = borders(triangles)
    if not len(edges):
        return np.zeros(0, np.int64)
    count, shoulders = len(rest), float(body[:, 1].min() + SHOULDERS * np.ptp(body[:, 1]))
    links = coo_matrix((np.ones(len(edges)), edges.T), (count, count))
    loop = connected_components(links, directed=False)[1]
    on_border, distance = np.unique(edges), cKDTree(body).query(rest)[0]
    found = []
    for g in np.unique(garment):
        mine = on_border[garment[on_border] == g]
        if not len(mine) or rest[garment == g, 1].max() > shoulders:
            continue
        loops = [mine[loop[mine] == k] for k in np.unique(loop[mine])]
        loops = [v for v in loops if np.median(distance[v]) < NEAR]
        if loops:
            top = max(loops, key=lambda v: rest[v, 1].mean())
            if rest[top, 1].mean() > rest[garment == g, 1].min() + ABOVE:
                found.append(top)
    return np.concatenate(found) if found else np.zeros(0, np.int64)


def borders(triangles: Ints) -> Ints:
    """Edges of one triangle only, (E, 2)."""
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), 1)
    edges, uses = np.unique(sides, axis=0, return_counts=True)
    return edges[uses == 1]
