"""Small loose pieces (bows, buttons, pockets) ride on the garment that carries them.

Nothing sews them on, so a network of cloth would let them fall. A piece moves as the one point that carries it does:
rigidly. A small garment in several pieces (the knot and tails of a bow) is one. `rest` space, metres. The server does
the same (`toile-drape/src/ornaments.rs`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from garment.graph import OutfitGraph, mesh_edges

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Pieces whose bounding box has a diagonal below this are small.
SMALL = 0.33
#: A small piece is carried when some vertex of it lies this near to a larger one.
TOUCHES = 0.03


def carriers(vertices: Floats, triangles: Ints, garment: Ints) -> Ints:
    """For every vertex of a carried piece the vertex of the larger pieces that carries it, else itself. (N,)

    That is the one nearest to where the piece touches them highest: from there it hangs. garment (N,): garment of
    each vertex.
    """
    edges, n = mesh_edges(triangles), len(vertices)
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (n, n))
    piece = connected_components(graph, directed=False)[1]
    whole = _small(vertices, garment)[garment]
    piece = np.unique(np.where(whole, -1 - garment, piece), return_inverse=True)[1]
    small, count = _small(vertices, piece), piece.max() + 1
    out, large = np.arange(n), np.flatnonzero(~small[piece])
    if len(large) == 0:
        return out
    distance, hit = cKDTree(vertices[large]).query(vertices)
    order = np.lexsort((distance, -vertices[:, 1], distance >= TOUCHES, piece))
    hook = order[np.searchsorted(piece[order], np.arange(count))]  # the vertex that each piece hangs from
    carried = (small & (distance[hook] < TOUCHES))[piece]
    out[carried] = large[hit[hook]][piece][carried]
    return out


def _small(vertices: Floats, label: Ints) -> NDArray[np.bool_]:
    """Whether the bounding box of the vertices of each label is small, (labels,)."""
    low, high = np.full((label.max() + 1, 3), np.inf), np.full((label.max() + 1, 3), -np.inf)
    np.minimum.at(low, label, vertices)
    np.maximum.at(high, label, vertices)
    return np.linalg.norm(high - low, axis=1) < SMALL


def ride(graph: OutfitGraph, vertices: Floats, triangles: Ints, garment: Ints) -> OutfitGraph:
    """The same graph, with every vertex of a carried piece read where its carrier is. vertices (N, 3)."""
    carrier = carriers(vertices, triangles, garment)
    return replace(
        graph,
        vertex_from_node=graph.vertex_from_node[carrier],
        vertex_from_node_weight=graph.vertex_from_node_weight[carrier],
    )
