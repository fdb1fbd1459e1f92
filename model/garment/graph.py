"""The canonical graph of an outfit: nodes of a fixed size, whatever the mesh's resolution.

The network runs on clusters of vertices, not on vertices, so that the same outfit gives the same
answer at a quarter or four times the vertices. A cluster is a connected piece of one garment inside
one cell of a grid. Two levels: nodes (2.5 cm) and patches (10 cm). `rest` space, metres.
The server builds the same graph (`toile-drape/src/graph.rs`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NODE_SIZE = 0.025
PATCH_SIZE = 0.10
NEIGHBOURS = 8
MEMBERS = 16
SUPPORTS = 8
#: Radius of the interpolation kernel in cluster sizes.
KERNEL = 2.0


@dataclass(frozen=True)
class Clusters:
    """One level of clustering of points."""

    positions: Floats  # (M, 3) mean of the members
    cluster_of: Ints  # (N,) cluster of each point
    edges: Ints  # (E, 2) pairs of touching clusters, both directions
    garment: Ints  # (M,)


@dataclass(frozen=True)
class OutfitGraph:
    """Index tables of the network's gathers, padded; a row's padding repeats its first entry with weight 0."""

    nodes: Clusters
    patches: Clusters
    near: Ints  # (M, NEIGHBOURS) nodes touching each node
    near_weight: Floats  # (M, NEIGHBOURS) rows sum to 1
    members: Ints  # (P, MEMBERS) nodes of each patch
    members_weight: Floats
    patch_near: Ints  # (P, NEIGHBOURS)
    patch_near_weight: Floats
    node_from_patch: Ints  # (M, SUPPORTS)
    node_from_patch_weight: Floats
    vertex_from_node: Ints  # (N, SUPPORTS)
    vertex_from_node_weight: Floats

    def of_first(self, count: int) -> OutfitGraph:
        """The same graph, read at the first `count` vertices only: those of the mesh before it was refined."""
        index, weight = self.vertex_from_node[:count], self.vertex_from_node_weight[:count]
        return replace(self, vertex_from_node=index, vertex_from_node_weight=weight)


def mesh_edges(triangles: Ints) -> Ints:
    """Undirected edges (E, 2), sorted, each once."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def open_sides(triangles: Ints) -> tuple[Ints, Ints]:
    """Sides (E, 2) that only one triangle has, in its order, and which triangle that is, (E,)."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, first, uses = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
    alone = first[uses == 1]
    return sides[alone], alone % len(triangles)


def cluster(points: Floats, edges: Ints, garment: Ints, size: float) -> Clusters:
    """Connected pieces of one garment inside one grid cell. edges: (E, 2) over points."""
    cell = np.floor(points / size).astype(np.int64)
    same = (cell[edges[:, 0]] == cell[edges[:, 1]]).all(1) & (garment[edges[:, 0]] == garment[edges[:, 1]])
    inside = edges[same]
    n = len(points)
    graph = coo_matrix((np.ones(len(inside)), (inside[:, 0], inside[:, 1])), (n, n))
    count, cluster_of = connected_components(graph, directed=False)
    cluster_of = cluster_of.astype(np.int64)
    size_of = np.bincount(cluster_of, minlength=count)[:, None]
    centre = np.stack([np.bincount(cluster_of, points[:, k], count) for k in range(3)], 1) / size_of
    between = cluster_of[edges]
    between = between[between[:, 0] != between[:, 1]]
    both = np.unique(np.concatenate([between, between[:, ::-1]]), axis=0)
    first = np.zeros(count, dtype=np.int64)
    first[cluster_of] = garment
    return Clusters(centre, cluster_of, both, first)


def build(vertices: Floats, triangles: Ints, garment: Ints) -> OutfitGraph:
    """The graph of a welded outfit. vertices (N, 3) rest space, triangles (F, 3), garment (N,)."""
    nodes = cluster(vertices, mesh_edges(triangles), garment, NODE_SIZE)
    patches = cluster(nodes.positions, nodes.edges, nodes.garment, PATCH_SIZE)
    near = nearest_linked(nodes.positions, nodes.edges, nodes.positions, NEIGHBOURS)
    patch_near = nearest_linked(patches.positions, patches.edges, patches.positions, NEIGHBOURS)
    member_pairs = np.stack([patches.cluster_of, np.arange(len(nodes.positions))], 1)
    members = nearest_linked(patches.positions, member_pairs, nodes.positions, MEMBERS)
    node_support = interpolation(nodes.positions, patches, PATCH_SIZE)
    vertex_support = interpolation(vertices, nodes, NODE_SIZE)
    return OutfitGraph(nodes, patches, *near, *members, *patch_near, *node_support, *vertex_support)


def nearest_linked(origin: Floats, links: Ints, target: Floats, width: int) -> tuple[Ints, Floats]:
    """For each origin the `width` nearest targets that it is linked to, with equal weights summing to 1.

    An origin without links gets target 0 with weight 0.
    """
    distance = np.linalg.norm(origin[links[:, 0]] - target[links[:, 1]], axis=1)
    order = np.lexsort((links[:, 1], distance, links[:, 0]))
    index, rank = _pad(links[order], len(origin), width)
    used = rank >= 0
    weight = used / np.maximum(used.sum(1, keepdims=True), 1)
    return index, weight.astype(np.float64)


def interpolation(points: Floats, clusters: Clusters, size: float) -> tuple[Ints, Floats]:
    """Partition-of-unity weights of the clusters around each point, (N, SUPPORTS) twice.

    Kernel (1 - (d / KERNEL size)^2)^2 over the point's own cluster and the two rings around it.
    """
    ring = coo_matrix(
        (np.ones(len(clusters.edges)), (clusters.edges[:, 0], clusters.edges[:, 1])), (len(clusters.positions),) * 2
    ).tocsr()
    own = coo_matrix(
        (np.ones(len(points)), (np.arange(len(points)), clusters.cluster_of)), (len(points), len(clusters.positions))
    ).tocsr()
    reach = (own + own @ ring + own @ ring @ ring).tocoo()
    links = np.stack([reach.row, reach.col], 1).astype(np.int64)
    distance = np.linalg.norm(points[links[:, 0]] - clusters.positions[links[:, 1]], axis=1)
    weight = np.maximum(1 - (distance / (KERNEL * size)) ** 2, 0) ** 2
    weight[links[:, 1] == clusters.cluster_of[links[:, 0]]] += 1e-3
    order = np.lexsort((links[:, 1], -weight, links[:, 0]))
    index, rank = _pad(links[order], len(points), SUPPORTS)
    padded = np.where(rank >= 0, np.append(weight[order], 0.0)[rank], 0.0)
    return index, padded / padded.sum(1, keepdims=True)


def _pad(links: Ints, count: int, width: int) -> tuple[Ints, Ints]:
    """First `width` targets of each origin in the order given, (count, width), and their rows in links or -1."""
    start = np.searchsorted(links[:, 0], np.arange(count))
    end = np.searchsorted(links[:, 0], np.arange(count), side="right")
    row = start[:, None] + np.arange(width)[None]
    used = row < end[:, None]
    row = np.where(used, row, -1)
    target = np.append(links[:, 1], 0)
    index = np.where(used, target[row], 0)
    index = np.where(used, index, index[:, :1])
    return index, row
