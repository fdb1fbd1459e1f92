"""Frames of cloth wrapped on a body: along the pattern's u and v, and off the skin (Jin et al. 2020, section 7).

Offsets in them do not notice how the limb under the cloth turns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from garment.cloth_image import Panel
from garment.embedding import Embedding

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]


@dataclass(frozen=True)
class Frames:
    """Tables of the Q vertices of a garment's panels (sites), embedded in a body."""

    corners: Tensor  # (Q, K) body vertices that hold each site, as of `Embedding`
    weight: Tensor  # (Q, K) rows sum to 1
    around: Tensor  # (Q, A) sites around each, padded with itself
    along: Tensor  # (Q, A) weights whose sum of places goes along u; rows sum to 0

    def places(self, body: Tensor) -> Tensor:
        """Of the sites on bodies (P, V, 3), (P, Q, 3), metres."""
        return (self.weight[..., None] * body[:, self.corners]).sum(2)

    def axes(self, body: Tensor, normals: Tensor) -> Tensor:
        """Columns u, v, n of the sites, (P, Q, 3, 3), on bodies with normals (P, V, 3)."""
        out = unit((self.weight[..., None] * normals[:, self.corners]).sum(2))
        along = (self.along[..., None] * self.places(body)[:, self.around]).sum(2)
        u = unit(along - (along * out).sum(-1, keepdim=True) * out)
        return torch.stack([u, torch.linalg.cross(out, u), out], -1)


def unit(x: Tensor) -> Tensor:
    """Vectors (..., 3) at length 1."""
    return x / x.square().sum(-1, keepdim=True).add(1e-20).sqrt()


def frames(panels: list[Panel], embedding: Embedding) -> Frames:
    """Frames of a garment whose vertices are embedded in a body."""
    vertex = np.concatenate([p.vertices for p in panels])
    first = np.cumsum([0, *(len(p.vertices) for p in panels)])
    tables = [_along(p.places, p.triangles) for p in panels]
    widest = max(around.shape[1] for around, _ in tables)
    around = np.concatenate(
        [_widened(a, widest, a[:, :1]) + start for (a, _), start in zip(tables, first, strict=False)]
    )
    along = np.concatenate([_widened(a, widest, np.zeros((len(a), 1))) for _, a in tables])
    as_float = lambda x: torch.as_tensor(x, dtype=torch.float32)  # noqa: E731
    corners = torch.as_tensor(embedding.corners[vertex])
    return Frames(corners, as_float(embedding.weight[vertex]), torch.as_tensor(around), as_float(along))


def _along(places: Floats, triangles: Ints) -> tuple[Ints, Floats]:
    """Sites around each (P, A), and the weights of the derivative by u, the mean of its triangles by their area."""
    count, gradient = len(places), np.zeros((len(triangles), 3))
    for k in range(3):
        # Twice the area times the derivative of a linear function that is 1 at corner k.
        gradient[:, k] = places[triangles[:, (k + 1) % 3], 1] - places[triangles[:, (k + 2) % 3], 1]
    entries: list[dict[int, float]] = [{i: 0.0} for i in range(count)]
    for corners, slope in zip(triangles.tolist(), gradient.tolist(), strict=True):
        for i in corners:
            for j, value in zip(corners, slope, strict=True):
                entries[i][j] = entries[i].get(j, 0.0) + value
    widest = max(map(len, entries))
    around, along = np.arange(count)[:, None].repeat(widest, 1), np.zeros((count, widest))
    for i, row in enumerate(entries):
        around[i, : len(row)], along[i, : len(row)] = list(row), list(row.values())
    # Only the direction counts: the largest weight is 1, whatever the size of the triangles.
    return around, along / np.maximum(np.abs(along).max(1, keepdims=True), 1e-12)


def _widened(table: NDArray, width: int, column: NDArray) -> NDArray:
    """With more of one column (Q, 1), up to `width`."""
    return np.concatenate([table, np.repeat(column, width - table.shape[1], 1)], 1)
