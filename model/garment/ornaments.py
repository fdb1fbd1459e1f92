"""Small loose pieces (bows, buttons, pockets) ride on the garment that carries them.

Nothing sews them on, so a network of cloth would let them fall. The server does the same
(`toile-drape/src/ornaments.rs`). `rest` space, metres.
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
SMALL = 0.25
#: A small piece is carried when some vertex of it lies this near to a larger one.
TOUCHES = 0.03


def carriers(vertices: Floats, triangles: Ints) -> Ints:
    """For every vertex of a carried piece the nearest vertex of the larger pieces, else itself. (N,)"""
    edges, n = mesh_edges(triangles), len(vertices)
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (n, n))
    count, piece = connected_components(graph, directed=False)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, piece, vertices)
    np.maximum.at(high, piece, vertices)
    small = np.linalg.norm(high - low, axis=1) < SMALL
    out, large = np.arange(n), np.flatnonzero(~small[piece])
    if len(large) == 0:
        return out
    distance, hit = cKDTree(vertices[large]).query(vertices)
    touching = np.full(count, np.inf)
    np.minimum.at(touching, piece, distance)
    carried = (small & (touching < TOUCHES))[piece]
    out[carried] = large[hit[carried]]
    return out


def ride(graph: OutfitGraph, vertices: Floats, triangles: Ints) -> OutfitGraph:
    """The same graph, with every vertex of a carried piece read where its carrier is. vertices (N, 3)."""
    carrier = carriers(vertices, triangles)
    return replace(
        graph,
        vertex_from_node=graph.vertex_from_node[carrier],
        vertex_from_node_weight=graph.vertex_from_node_weight[carrier],
    )
