"""Nearest surface points by candidates and descent, batched over poses (no gradient). World space, metres."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

DESCENTS = 4
RING = 8


def ring_table(count: int, edges: np.ndarray) -> Tensor:
    """Up to RING neighbours of each vertex, padded with the vertex itself, (V, RING)."""
    table = np.arange(count)[:, None].repeat(RING, 1)
    both = np.concatenate([edges, edges[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    rank = np.arange(len(both)) - np.searchsorted(both[:, 0], both[:, 0])
    keep = rank < RING
    table[both[keep, 0], rank[keep]] = both[keep, 1]
    return torch.as_tensor(table)


@torch.no_grad()
def nearest(x: Tensor, surface: Tensor, candidates: Tensor, ring: Tensor) -> Tensor:
    """Index of the (locally) nearest surface vertex of each x: best candidate, then descent over the surface.

    x (P, N, 3), surface (P, V, 3), candidates (N, K), ring (V, RING) -> (P, N).
    """
    best = best_of(x, surface, candidates[None].expand(x.shape[0], -1, -1))
    for _ in range(DESCENTS):
        best = best_of(x, surface, torch.cat([best[..., None], ring[best]], 2))
    return best


def best_of(x: Tensor, surface: Tensor, index: Tensor) -> Tensor:
    """The nearest of given surface vertices: x (P, N, 3), surface (P, V, 3), index (P, N, K) -> (P, N).

    One axis at a time: a sum over three neighbouring numbers costs several times as much.
    """
    count, size = surface.shape[:2]
    flat = (index + size * torch.arange(count, device=index.device)[:, None, None]).reshape(-1)
    distance = surface.new_zeros(index.shape)
    for along_surface, along_x in zip(surface.reshape(-1, 3).T.contiguous(), x.unbind(2), strict=True):
        distance += (along_surface.index_select(0, flat).reshape(index.shape) - along_x[..., None]).square_()
    return index.gather(2, distance.argmin(2, keepdim=True))[..., 0]


def surface_at(surface: Tensor, index: Tensor) -> Tensor:
    """Rows of a per-pose table: (P, V, 3), (P, N) -> (P, N, 3)."""
    return surface.gather(1, index[..., None].expand(-1, -1, 3))


def vertex_normals(x: Tensor, triangles: Tensor) -> Tensor:
    """Area-weighted unit vertex normals, (P, N, 3); differentiable."""
    a, b, c = (x[:, triangles[:, k]] for k in range(3))
    face = torch.linalg.cross(b - a, c - a)
    out = torch.zeros_like(x)
    for k in range(3):
        out = out.index_add(1, triangles[:, k], face)
    return out / out.square().sum(-1, keepdim=True).add(1e-18).sqrt()
