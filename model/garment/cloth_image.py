"""Cloth as images: its vertices' values as pixels in pattern space, and back (Jin et al. 2020, sections 3 and 4).

Every panel has an image of its own, square. Pixels outside of the cloth that are near it go on as
the triangle beside them does, so that filters and interpolation meet no edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from garment.graph import open_sides

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: Pixels of a side (section 7), pixels that go on beyond the cloth, and least pixels from the cloth to the border.
SIZE, PADDING, MARGIN = 256, 6, 8
#: Points of an edge of the cloth that pixels beside it are measured to.
SAMPLES = 8


@dataclass(frozen=True)
class Panel:
    """A piece of a garment in its own plane, upright and seen from outside."""

    vertices: Ints  # (P,) of the garment
    triangles: Ints  # (F, 3) into `vertices`
    places: Floats  # (P, 2) m


@dataclass(frozen=True)
class ClothImages:
    """Linear maps between the garment's N vertices, the Q vertices of its panels (sites) and the M pixels of K images.

    A vertex on a seam is a site of each panel that meets there.
    """

    vertex: Ints  # (Q,) of the garment
    share: Floats  # (Q,) of its vertex; those of a vertex sum to 1
    pixel: Ints  # (M,) in the images laid out one after the other, on the cloth or its padding
    site_of_pixel: Ints  # (M, 3) corners of the triangle that each pixel lies in or goes on from
    site_weight: Floats  # (M, 3) rows sum to 1
    pixel_of_site: Ints  # (Q, 4) pixels around each site
    pixel_weight: Floats  # (Q, 4) rows sum to 1
    cloth: Mask  # (K, size, size) on the cloth
    mask: Mask  # (K, size, size) on the cloth or its padding

    def images(self, values: Floats) -> Floats:
        """Values of the sites (Q, C) as images (K, size, size, C), 0 outside."""
        out = np.zeros((self.mask.size, values.shape[1]))
        out[self.pixel] = (self.site_weight[..., None] * values[self.site_of_pixel]).sum(1)
        return out.reshape(*self.mask.shape, -1)

    def values(self, images: Floats) -> Floats:
        """What images (K, size, size, C) say at the sites, (Q, C)."""
        flat = images.reshape(-1, images.shape[-1])
        return (self.pixel_weight[..., None] * flat[self.pixel_of_site]).sum(1)

    def joined(self, values: Floats) -> Floats:
        """Values of the sites (Q, C) at the vertices, (N, C): on a seam the mean of its panels."""
        out = np.zeros((int(self.vertex.max()) + 1, values.shape[1]))
        np.add.at(out, self.vertex, self.share[:, None] * values)
        return out


def cloth_images(panels: list[Panel], count: int, size: int = SIZE) -> ClothImages:
    """Images of a garment of `count` vertices, all panels at one scale.

    Raises ValueError for a vertex on no panel.
    """
    vertex = np.concatenate([p.vertices for p in panels])
    uses = np.bincount(vertex, minlength=count)
    if (uses == 0).any():
        raise ValueError(f"{int((uses == 0).sum())} vertices of the garment lie on no panel")
    pixels = size - 1 - 2 * MARGIN
    scale = pixels / max(float(np.ptp(p.places, axis=0).max()) for p in panels)
    parts = []
    for k, panel in enumerate(panels):
        first = sum(len(p.vertices) for p in panels[:k])
        parts.append(_panel(panel, scale, size, (first, k * size * size)))
    pixel, site, site_weight, around, around_weight = (np.concatenate([p[k] for p in parts]) for k in range(5))
    cloth, mask = (np.stack([p[k] for p in parts]) for k in (5, 6))
    return ClothImages(vertex, 1 / uses[vertex], pixel, site, site_weight, around, around_weight, cloth, mask)


def _panel(panel: Panel, scale: float, size: int, first: tuple[int, int]) -> tuple[Ints | Floats | Mask, ...]:
    """The fields of `ClothImages` from `pixel` on, of one panel; first: numbers of its first site and pixel."""
    low, high = panel.places.min(0), panel.places.max(0)
    at = (panel.places - (low + high) / 2) * scale + (size - 1) / 2
    # Rows of an image run down, pattern space up.
    at = np.stack([at[:, 0], size - 1 - at[:, 1]], 1)
    inside = _triangles_of_pixels(at, panel.triangles, size)
    own = _padded(at, panel.triangles, inside)
    y, x = np.nonzero(own >= 0)
    triangle = panel.triangles[own[y, x]]
    weight = _barycentric(at[triangle], np.stack([x, y], 1).astype(float))
    around, around_weight = _bilinear(at, size)
    sites, pixels = first
    return y * size + x + pixels, triangle + sites, weight, around + pixels, around_weight, inside >= 0, own >= 0


def _triangles_of_pixels(at: Floats, triangles: Ints, size: int) -> Ints:
    """The triangle that each pixel's middle lies in, (size, size), -1 outside of all."""
    out = np.full((size, size), -1)
    for k, corners in enumerate(at[triangles]):
        low, high = np.ceil(corners.min(0)).astype(int), np.floor(corners.max(0)).astype(int)
        x, y = np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(low, high, strict=True)))
        points = np.stack([x.ravel(), y.ravel()], 1)
        held = points[(_barycentric(corners[None].repeat(len(points), 0), points.astype(float)) >= -1e-9).all(1)]
        out[held[:, 1], held[:, 0]] = k
    return out


def _padded(at: Floats, triangles: Ints, inside: Ints) -> Ints:
    """`inside` with the triangle nearest to each pixel within `PADDING` of the cloth's edge."""
    sides, owner = open_sides(triangles)
    along = (np.arange(SAMPLES) + 0.5)[:, None, None] / SAMPLES
    a, b = at[sides].transpose(1, 0, 2)
    samples = (a + along * (b - a)).reshape(-1, 2)
    y, x = np.nonzero(inside < 0)
    away, nearest = cKDTree(samples).query(np.stack([x, y], 1), distance_upper_bound=PADDING)
    near = np.isfinite(away)
    out = inside.copy()
    out[y[near], x[near]] = owner[nearest[near] % len(owner)]
    return out


def _barycentric(corners: Floats, points: Floats) -> Floats:
    """Weights of the corners (M, 3, 2) at points (M, 2), also outside, (M, 3)."""
    a, b, c = (corners[:, k] - points for k in range(3))
    cross = np.stack([u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] for u, v in ((b, c), (c, a), (a, b))], 1)
    total = cross.sum(1, keepdims=True)
    return cross / np.where(np.abs(total) < 1e-12, 1e-12, total)


def _bilinear(at: Floats, size: int) -> tuple[Ints, Floats]:
    """The four pixels around each place, (P, 4), and their weights."""
    corner = np.floor(at).astype(int)
    along, entries = at - corner, []
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        weight = np.abs(1 - dx - along[:, 0]) * np.abs(1 - dy - along[:, 1])
        entries.append(((corner[:, 1] + dy) * size + corner[:, 0] + dx, weight))
    pixel, weight = (np.stack(part, 1) for part in zip(*entries, strict=True))
    return pixel, weight
