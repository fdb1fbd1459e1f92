"""Gather tables of GarNet: rings of the garment's nodes, thinned body points, nearest of them. Metres.

The server makes the same tables (`toile-drape/src/garnet_tables.rs`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.spatial import cKDTree

from garment.graph import NEIGHBOURS

Floats = NDArray[np.floating]
Ints = NDArray[np.int64]

#: Entries of a ring: a node and its neighbours.
RING = NEIGHBOURS + 1


def ring(near: Ints, near_weight: Floats) -> tuple[Ints, Floats]:
    """Each node and the nodes that touch it (M, NEIGHBOURS), (M, RING) twice: index and weight, rows sum to 1."""
    index = np.concatenate([np.arange(len(near))[:, None], near], 1)
    weight = np.concatenate([np.ones((len(near), 1)), near_weight > 0], 1)
    return index, weight / weight.sum(1, keepdims=True)


def nodes_on_body(nodes: Floats, rest: Floats, on_body: Floats, support: Ints, weight: Floats) -> Floats:
    """Nodes of the reference body's rest pose carried to another body, (M, 3): they follow the vertices around them.

    nodes (M, 3); rest, on_body (N, 3) vertices on the reference body and on the other; support, weight (N, SUPPORTS):
    nodes that each vertex is interpolated from. Nodes that no vertex reads stay.
    """
    rows = np.repeat(np.arange(len(rest)), support.shape[1])
    reads = coo_matrix((weight.ravel(), (support.ravel(), rows)), (len(nodes), len(rest))).tocsr()
    total = np.asarray(reads.sum(1))
    return nodes + reads @ (on_body - rest) / np.maximum(total, 1e-9)


def spread_out(points: Floats, wanted: int) -> Ints:
    """About `wanted` of the points (M, 3), evenly spread: the most central one in each cell of a grid.

    The order of the points does not matter.
    """
    if len(points) <= wanted:
        return np.arange(len(points))
    low = points.min(0)
    cell = _cell_size(points, wanted)
    keys = np.floor((points - low) / cell).astype(np.int64)
    centre = low + (keys + 0.5) * cell
    order = np.lexsort((((points - centre) ** 2).sum(1), keys[:, 2], keys[:, 1], keys[:, 0]))
    first = np.ones(len(points), bool)
    first[1:] = (np.diff(keys[order], axis=0) != 0).any(1)
    return order[first].astype(np.int64)


def thinned(points: Floats, factor: int, averaged: int) -> Ints:
    """Which points (M, 3) each of about M / factor thinned ones averages, (M', averaged)."""
    if len(points) <= averaged:
        return np.arange(len(points))[:, None].repeat(averaged, 1)
    seeds = spread_out(points, len(points) // factor)
    return cKDTree(points).query(points[seeds], averaged)[1].astype(np.int64)


def _cell_size(points: Floats, wanted: int) -> float:
    """Edge of the grid cells of which about `wanted` hold a point."""
    low, high = 1e-4, float(np.ptp(points, axis=0).max()) + 1e-3
    for _ in range(24):
        middle = np.sqrt(low * high)
        cells = np.unique(np.floor((points - points.min(0)) / middle).astype(np.int64), axis=0)
        low, high = (middle, high) if len(cells) > wanted else (low, middle)
    return float(np.sqrt(low * high))


def nearest_thinned(garment: Floats, points: Floats, thin: Ints, count: int) -> Ints:
    """The `count` thinned points nearest to each garment node, (M, count); each is where its average lies."""
    centre = points[thin].mean(1)
    found = cKDTree(centre).query(garment, min(count, len(centre)))[1].reshape(len(garment), -1)
    return np.concatenate([found, found[:, :1].repeat(count - found.shape[1], 1)], 1).astype(np.int64)
