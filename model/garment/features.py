"""Body-relative input features of the graph's nodes. `rest` space on the reference body, metres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from garment.binding import BodySurface, hands_and_head
from garment.graph import OutfitGraph

Floats = NDArray[np.float64]

WAVELENGTHS = (0.5, 0.2)
#: Unit of distances to the body, metres.
DISTANCE_UNIT = 0.1
FEATURES = 3 + 3 + 3 + 1 + 3 + 3 * 2 * len(WAVELENGTHS) + 36 + 1


def node_features(
    graph: OutfitGraph, vertices_normals: Floats, prior: Floats, layer: NDArray[np.int64], surface: BodySurface
) -> Floats:
    """Features of each node, (M, FEATURES).

    Position (m), garment normal, body normal at the nearest body vertex, signed distance to it (dm, clipped),
    unit-free direction to it, sines and cosines of the position, diffused skin weights, layer.
    vertices_normals: (N, 3); prior: (M, 36); layer: (N,) 0 is next to the skin.
    """
    count = len(graph.nodes.positions)
    normal = np.stack([np.bincount(graph.nodes.cluster_of, vertices_normals[:, k], count) for k in range(3)], 1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    allowed = np.flatnonzero(~hands_and_head(surface))
    hit = allowed[cKDTree(surface.vertices[allowed]).query(graph.nodes.positions)[1]]
    offset = graph.nodes.positions - surface.vertices[hit]
    signed = np.einsum("ij,ij->i", offset, surface.normals[hit])
    centred = graph.nodes.positions - np.array([0.0, 1.0, 0.0])
    waves = [f(2 * np.pi * centred / w) for w in WAVELENGTHS for f in (np.sin, np.cos)]
    first = np.zeros(count)
    first[graph.nodes.cluster_of] = layer
    columns = [
        centred,
        normal,
        surface.normals[hit],
        np.clip(signed / DISTANCE_UNIT, -1, 3)[:, None],
        np.clip(offset / DISTANCE_UNIT, -3, 3),
    ]
    columns += [*waves, prior, np.minimum(first, 3)[:, None] / 3]
    return np.concatenate(columns, 1)
