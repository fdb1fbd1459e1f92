"""Carrying an outfit to another body shape: made to measure, bone lengths and girth.

Each garment joint gets the affine map that best takes its part of the reference body to the other body;
blended by the diffused skin weights they carry the cloth without a seam between limbs. What the blend
misses (belly, bust) follows the skin around each vertex. The server does the same
(`toile-drape/src/shape.rs`). A-pose, metres.
"""

from __future__ import annotations

import torch
from torch import Tensor

from garment import nearest

#: Pull of each joint's map towards plain translation, kg-like weight of a point 10 cm away.
STIFFNESS = 20.0
SPREADS = 3
FOLLOW = 0.75
ROUNDS = 4
#: Rounds of averaging of what the joint maps miss.
RELAXATIONS = 6
#: Cloth keeps at most this much of its rest distance to the skin on another body, metres.
MARGIN = 0.003


def joint_maps(reference: Tensor, shaped: Tensor, skin: Tensor) -> Tensor:
    """Affine map of each garment joint, (J, 3, 4): least squares over its skin, ridge towards translation.

    reference, shaped (V, 3): the two A-poses; skin (V, J).
    """
    weight = skin.T / skin.sum(0)[:, None].clamp(min=1e-6)
    centre, moved = weight @ reference, weight @ shaped
    a = reference[None] - centre[:, None]
    b = shaped[None] - moved[:, None] - a
    ridge = STIFFNESS * 1e-4 * torch.eye(3)
    covariance = torch.einsum("jv,jva,jvb->jab", weight, a, a) + ridge
    change = torch.linalg.solve(covariance, torch.einsum("jv,jva,jvb->jab", weight, a, b)).transpose(1, 2)
    linear = change + torch.eye(3)
    return torch.cat([linear, (moved - torch.einsum("jab,jb->ja", linear, centre))[:, :, None]], 2)


def blend(maps: Tensor, points: Tensor, weights: Tensor) -> Tensor:
    """Points (N, 3) moved by their weighted maps; weights (N, J)."""
    m = torch.einsum("nj,jab->nab", weights, maps)
    return torch.einsum("nab,nb->na", m[:, :, :3], points) + m[:, :, 3]


def spread(need: Tensor, vertex_from_node: Tensor, weight: Tensor, near: Tensor, near_weight: Tensor) -> Tensor:
    """Pushes of single vertices (N, 3) spread over the graph's nodes and back (`toile-drape/src/push_out.rs`)."""
    count, size = len(near), need.norm(dim=1, keepdim=True)
    sums, shares = torch.zeros(count, 3), torch.zeros(count, 1)
    for k in range(vertex_from_node.shape[1]):
        w = weight[:, k : k + 1] * size
        sums.index_add_(0, vertex_from_node[:, k], need * w)
        shares.index_add_(0, vertex_from_node[:, k], w)
    field = sums / shares.clamp(min=1e-12)
    for _ in range(SPREADS):
        around = FOLLOW * (field[near] * near_weight[..., None]).sum(1)
        field = torch.where(around.norm(dim=1, keepdim=True) > field.norm(dim=1, keepdim=True), around, field)
    return (field[vertex_from_node] * weight[..., None]).sum(1)


def smoothed(field: Tensor, vertex_from_node: Tensor, weight: Tensor, near: Tensor, near_weight: Tensor) -> Tensor:
    """A field over vertices (N, 3) averaged on the graph's nodes, relaxed over their neighbours, and read back."""
    sums, shares = torch.zeros(len(near), 3), torch.zeros(len(near), 1)
    for k in range(vertex_from_node.shape[1]):
        sums.index_add_(0, vertex_from_node[:, k], field * weight[:, k : k + 1])
        shares.index_add_(0, vertex_from_node[:, k], weight[:, k : k + 1])
    nodes = sums / shares.clamp(min=1e-12)
    linked = near_weight.sum(1, keepdim=True)
    for _ in range(RELAXATIONS):
        around = (nodes[near] * near_weight[..., None]).sum(1)
        nodes = (1 - 0.5 * linked) * nodes + 0.5 * around
    return (nodes[vertex_from_node] * weight[..., None]).sum(1)


def push_out(
    x: Tensor, gap: Tensor, skin: tuple[Tensor, Tensor], candidates: Tensor, ring: Tensor, field: tuple[Tensor, ...]
) -> Tensor:
    """Vertices x (N, 3) moved to at least `gap` (N,) from the skin (vertices, normals) as a smooth field."""
    vertices, normals = skin
    for i in range(ROUNDS):
        hit = nearest.nearest(x[None], vertices[None], candidates, ring)[0]
        need = (gap - ((x - vertices[hit]) * normals[hit]).sum(1)).clamp(min=0)[:, None] * normals[hit]
        x = x + (spread(need, *field) if i + 1 < ROUNDS else need)
    return x
