"""Pixel-based cloth (Jin et al. 2020, section 7): a pose to cloth images, by transpose convolutions.

Images hold offsets of the cloth from where the body carries its pixels, in the frame of each (`garment.local_frames`).
A whole garment has one decoder for all of its images; patches have a small one each (section 4.1), side by side in
grouped convolutions.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import torch
from torch import Tensor, nn

from pixel_poses import POSE

#: m, unit of the offsets, so that the network works near one.
OFFSET_UNIT = 0.03


@dataclass(frozen=True)
class Sizes:
    """Channels of the decoder after each of its transpose convolutions; the first makes 4 x 4, the others double."""

    images: int = 2
    channels: tuple[int, ...] = (256, 128, 96, 64, 32, 16)
    groups: int = 1  # networks side by side
    pose: int = POSE  # numbers of a pose

    @property
    def side(self) -> int:
        """Pixels of an image's side."""
        return 4 << len(self.channels)


class PixelCloth(nn.Module):
    """Poses (P, sizes.pose) to cloth images, (P, 3 images, side, side), metres."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.sizes, g = sizes, sizes.groups
        first, last = sizes.channels[0] * g, sizes.channels[-1] * g
        layers: list[nn.Module] = [nn.ConvTranspose2d(sizes.pose * g, first, 4, bias=False, groups=g)]
        for inlet, outlet in pairwise(sizes.channels):
            layers += [nn.BatchNorm2d(inlet * g), nn.ReLU()]
            layers += [nn.ConvTranspose2d(inlet * g, outlet * g, 4, 2, 1, bias=False, groups=g)]
        layers += [nn.BatchNorm2d(last), nn.ReLU(), nn.ConvTranspose2d(last, 3 * sizes.images, 4, 2, 1, groups=g)]
        self.layers = nn.Sequential(*layers)
        nn.init.zeros_(self.layers[-1].bias)

    def forward(self, pose: Tensor) -> Tensor:
        return self.layers(pose.repeat(1, self.sizes.groups)[..., None, None]) * OFFSET_UNIT


def multiplications(sizes: Sizes) -> int:
    """Multiply-adds of one pose."""
    widths, total = (*sizes.channels, 3 * sizes.images // sizes.groups), 16 * sizes.pose * sizes.channels[0]
    for k, (inlet, outlet) in enumerate(pairwise(widths)):
        total += 16 * inlet * outlet * (4 << k) ** 2
    return total * sizes.groups


def at_sites(images: Tensor, pixel_of_site: Tensor, pixel_weight: Tensor) -> Tensor:
    """What images (P, 3 K, side, side) say at the Q sites, (P, Q, 3); tables (Q, 4) as of `ClothImages`."""
    pixels = images.unflatten(1, (-1, 3)).permute(0, 1, 3, 4, 2).flatten(1, 3)
    return (pixel_weight[..., None] * pixels[:, pixel_of_site]).sum(2)


def in_images(sites: Tensor, site_of_pixel: Tensor, site_weight: Tensor) -> Tensor:
    """Values of the sites (P, Q, 3) at the M pixels of the mask, (P, M, 3)."""
    return (site_weight[..., None] * sites[:, site_of_pixel]).sum(2)


def of_mask(images: Tensor, pixel: Tensor) -> Tensor:
    """Values of images (P, 3 K, side, side) at the M pixels of the mask, (P, M, 3)."""
    return images.unflatten(1, (-1, 3)).permute(0, 1, 3, 4, 2).flatten(1, 3)[:, pixel]


def vertices(sites: Tensor, places: Tensor, axes: Tensor, vertex: Tensor, share: Tensor) -> Tensor:
    """Cloth (P, N, 3) world from offsets of its sites, (P, Q, 3), in their frames; on a seam the mean of its panels.

    places (P, Q, 3), axes (P, Q, 3, 3): of `Frames`; vertex, share (Q,): of `ClothImages`.
    """
    world = places + (axes @ sites[..., None])[..., 0]
    out = torch.zeros(len(world), int(vertex.max()) + 1, 3, device=world.device)
    return out.index_add(1, vertex, share[:, None] * world)
