"""PCA of cloth offsets, which smooths what networks leave (Jin et al. 2020, section 8.3).

Drapes have no kinks at the edges of patches, and no noise from pixel to pixel, so neither have their first components.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from pixel_scenes import Garment, Scenes, draped

#: Components that are chosen from by validation.
COUNTS = (32, 64, 128, 256, 512)


@dataclass(frozen=True)
class Filter:
    """Mean offsets of the sites, (3 Q), and components, (C, 3 Q), orthonormal, the largest first."""

    mean: Tensor
    components: Tensor

    @classmethod
    def of(cls, data: Scenes) -> Filter:
        """All components of some drapes' offsets."""
        rows = data.offsets.flatten(1)
        mean = rows.mean(0)
        return cls(mean, torch.linalg.svd(rows - mean, full_matrices=False).Vh)

    def apply(self, offsets: Tensor, count: int | None = None) -> Tensor:
        """Offsets (D, Q, 3) by the first `count` components, by all where none is stated."""
        some = self.components[:count]
        return (((offsets.flatten(1) - self.mean) @ some.T) @ some + self.mean).unflatten(1, (-1, 3))

    def chosen(self, offsets: Tensor, garment: Garment, validation: Scenes) -> Filter:
        """With as many components as bring a network's offsets (D, Q, 3) nearest to the validation's drapes."""
        near = lambda n: (draped(self.apply(offsets, n), garment, validation) - validation.truth).norm(dim=-1).mean()  # noqa: E731
        count = min(COUNTS, key=lambda n: near(n).item())
        return Filter(self.mean, self.components[:count])


def offsets_of(x: Tensor, garment: Garment, data: Scenes) -> Tensor:
    """Offsets of a garment's sites, (D, Q, 3), that cloth x (D, N, 3) world has in their frames."""
    return (data.axes.transpose(-2, -1) @ (x[:, garment.vertex] - data.places)[..., None])[..., 0]
