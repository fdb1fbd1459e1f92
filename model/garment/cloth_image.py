"""Cloth as images: its vertices' values as pixels in pattern space, and back (Jin et al. 2020, sections 3 and 4).

Every panel has an image of its own, `SIZE` pixels square. Pixels outside of the cloth that are near it go on as
the triangle beside them does, so that filters and interpolation meet no edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, vstack
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
    """Linear maps between the garment's N vertices and its K images."""

    pixel_from_vertex: csr_matrix  # (K * SIZE * SIZE, N); empty rows outside
    vertex_from_pixel: csr_matrix  # (N, K * SIZE * SIZE)
    cloth: Mask  # (K, SIZE, SIZE) on the cloth
    mask: Mask  # (K, SIZE, SIZE) on the cloth or its padding

    def images(self, values: Floats) -> Floats:
        """Values of the vertices (N, C) as images (K, SIZE, SIZE, C)."""
        return (self.pixel_from_vertex @ values).reshape(*self.mask.shape, -1)

    def values(self, images: Floats) -> Floats:
        """What images (K, SIZE, SIZE, C) say at the vertices, (N, C); on a seam the mean of its panels."""
        return self.vertex_from_pixel @ images.reshape(-1, images.shape[-1])


def cloth_images(panels: list[Panel], count: int) -> ClothImages:
    """Images of a garment of `count` vertices, all panels at one scale.

    Raises ValueError for a vertex on no panel.
    """
    pixels = SIZE - 1 - 2 * MARGIN
    scale = pixels / max(float(np.ptp(p.places, axis=0).max()) for p in panels)
    made = [_panel(panel, scale, count) for panel in panels]
    reads = _mean_of([reader for _, reader, _, _ in made])
    cloth, mask = (np.stack([part[k] for part in made]) for k in (2, 3))
    return ClothImages(vstack([writer for writer, _, _, _ in made]).tocsr(), reads, cloth, mask)


def _panel(panel: Panel, scale: float, count: int) -> tuple[csr_matrix, csr_matrix, Mask, Mask]:
    """Pixels from vertices (S * S, N), vertices from pixels (N, S * S), cloth and mask of one panel."""
    low, high = panel.places.min(0), panel.places.max(0)
    at = (panel.places - (low + high) / 2) * scale + (SIZE - 1) / 2
    # Rows of an image run down, pattern space up.
    at = np.stack([at[:, 0], SIZE - 1 - at[:, 1]], 1)
    inside = _triangles_of_pixels(at, panel.triangles)
    own = _padded(at, panel.triangles, inside)
    y, x = np.nonzero(own >= 0)
    triangle = panel.triangles[own[y, x]]
    weight = _barycentric(at[triangle], np.stack([x, y], 1).astype(float))
    rows = np.repeat(y * SIZE + x, 3)
    writer = coo_matrix((weight.ravel(), (rows, panel.vertices[triangle].ravel())), (SIZE * SIZE, count))
    return writer.tocsr(), _bilinear(at, panel.vertices, count), inside >= 0, own >= 0


def _triangles_of_pixels(at: Floats, triangles: Ints) -> Ints:
    """The triangle that each pixel's middle lies in, (SIZE, SIZE), -1 outside of all."""
    out = np.full((SIZE, SIZE), -1)
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


def _bilinear(at: Floats, vertices: Ints, count: int) -> csr_matrix:
    """Rows that read the four pixels around each vertex."""
    corner = np.floor(at).astype(int)
    along = at - corner
    entries = []
    for dx, dy in ((0, 0), (1, 0), (0, 1), (1, 1)):
        weight = np.abs(1 - dx - along[:, 0]) * np.abs(1 - dy - along[:, 1])
        entries.append((weight, (corner[:, 1] + dy) * SIZE + corner[:, 0] + dx))
    weight, pixel = (np.concatenate(part) for part in zip(*entries, strict=True))
    return coo_matrix((weight, (np.tile(vertices, 4), pixel)), (count, SIZE * SIZE)).tocsr()


def _mean_of(readers: list[csr_matrix]) -> csr_matrix:
    """Readers of the panels side by side, each vertex the mean over the panels that have it."""
    joined = [r.tocoo() for r in readers]
    rows, columns, data = (
        np.concatenate(parts)
        for parts in (
            [r.row for r in joined],
            [r.col + k * SIZE * SIZE for k, r in enumerate(joined)],
            [r.data for r in joined],
        )
    )
    out = coo_matrix((data, (rows, columns)), (readers[0].shape[0], len(readers) * SIZE * SIZE)).tocsr()
    total = np.asarray(out.sum(1))
    if (total == 0).any():
        raise ValueError(f"{int((total == 0).sum())} vertices of the garment lie on no panel")
    return out.multiply(1 / total).tocsr()
