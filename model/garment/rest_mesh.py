"""Constant tables of a mesh for the energies: edges, hinges, areas."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray

from energies import RestMesh, dihedral
from garment.graph import mesh_edges

Ints = NDArray[np.int64]


def hinges(triangles: Ints) -> Ints:
    """Interior edges with their two opposite vertices, (H, 4): a, b, opposite in the first and second triangle."""
    directed = np.concatenate([triangles[:, [0, 1, 2]], triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]])
    key = np.sort(directed[:, :2], 1)
    order = np.lexsort((key[:, 1], key[:, 0]))
    key, directed = key[order], directed[order]
    pair = np.flatnonzero((key[1:] == key[:-1]).all(1) & (directed[1:, 0] == directed[:-1, 1]))
    return np.concatenate([directed[pair], directed[pair + 1, 2:3]], 1)


def topology(triangles: Ints) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Edges (E, 2), hinges (H, 4) and triangles (F, 3) as tensors."""
    return tuple(torch.as_tensor(t) for t in (mesh_edges(triangles), hinges(triangles), triangles))  # type: ignore[return-value]


def rest_mesh(x: torch.Tensor, tables: tuple[torch.Tensor, torch.Tensor, torch.Tensor]) -> RestMesh:
    """Lengths, angles and areas of rest vertices x (N, 3), metres."""
    edges, hinge, triangles = tables
    a, b, c = (x[triangles[:, k]] for k in range(3))
    face = torch.linalg.cross(b - a, c - a).norm(dim=1) / 2
    area = torch.zeros(len(x)).index_add_(0, triangles.reshape(-1), face.repeat_interleave(3) / 3)
    length = (x[edges[:, 0]] - x[edges[:, 1]]).norm(dim=1).clamp(min=1e-4)
    valence = torch.zeros(len(x)).index_add_(0, edges.reshape(-1), torch.ones(2 * len(edges)))
    share = area / valence.clamp(min=1)
    edge_area = share[edges[:, 0]] + share[edges[:, 1]]
    hinge_length = (x[hinge[:, 0]] - x[hinge[:, 1]]).norm(dim=1)
    hinge_area = (area[hinge[:, 0]] + area[hinge[:, 1]]).clamp(min=1e-7) / 3
    return RestMesh(
        edges, length, edge_area, hinge, dihedral(x[None], hinge)[0], hinge_length.square() / hinge_area, area
    )
