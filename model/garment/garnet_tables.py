"""Gather tables of GarNet: one-ring neighbours of the garment, thinned body points, nearest of them. World, metres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from garment.graph import mesh_edges

Floats = NDArray[np.floating]
Ints = NDArray[np.int64]

#: Widest one-ring that is kept whole; of wider ones the nearest neighbours stay.
RING = 10


def ring(vertices: Floats, triangles: Ints) -> tuple[Ints, Floats]:
    """Each vertex and those that it shares an edge with, (N, RING) twice: index and weight, rows sum to 1."""
    edges = mesh_edges(triangles)
    itself = np.arange(len(vertices))[:, None].repeat(2, 1)
    links = np.concatenate([edges, edges[:, ::-1], itself])
    distance = np.linalg.norm(vertices[links[:, 0]] - vertices[links[:, 1]], axis=1)
    links = links[np.lexsort((links[:, 1], distance, links[:, 0]))]
    rank = np.arange(len(links)) - np.searchsorted(links[:, 0], links[:, 0])
    kept = rank < RING
    index = np.arange(len(vertices))[:, None].repeat(RING, 1)
    weight = np.zeros(index.shape)
    index[links[kept, 0], rank[kept]] = links[kept, 1]
    weight[links[kept, 0], rank[kept]] = 1
    return index, weight / weight.sum(1, keepdims=True)


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
    """The `count` thinned points nearest to each garment vertex, (N, count); each is where its average lies."""
    centre = points[thin].mean(1)
    found = cKDTree(centre).query(garment, min(count, len(centre)))[1].reshape(len(garment), -1)
    return np.concatenate([found, found[:, :1].repeat(count - found.shape[1], 1)], 1).astype(np.int64)
