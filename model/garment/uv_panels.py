"""Panels of a garment by its UVs: every island is a piece of pattern (Jin et al. 2020, section 3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from garment.cloth_image import Panel

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]

#: Islands that a garment may have: each is an image of its own.
MOST = 16
#: Shares of an island's area: laid over other parts of it, turned over, and stretched more than `STRETCH` times.
OVERLAP, TURNED, STRETCHED, STRETCH = 0.02, 0.02, 0.05, 4.0
#: Cells of a side in which overlaps are looked for.
CELLS = 256


class UnusableUVs(ValueError):
    """UVs that are no sewing pattern."""


def uv_panels(vertices: Floats, drawn: Ints, triangles: Ints, uvs: Floats) -> list[Panel]:
    """The islands of a garment, each in metres at its own scale, the largest first.

    vertices (N, 3) rest space; drawn (D,): the vertex of each drawn vertex; triangles (F, 3) and uvs (D, 2) over drawn
    ones. Raises UnusableUVs with what is wrong.
    """
    if len(uvs) != len(drawn):
        raise UnusableUVs("The garment has no UVs. Lay its pattern out in UV space, one island a piece.")
    links = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    graph = coo_matrix((np.ones(len(links)), links.T), (len(drawn), len(drawn)))
    island = connected_components(graph, directed=False)[1][triangles[:, 0]]
    codes = np.unique(island)
    if len(codes) > MOST:
        raise UnusableUVs(f"The UVs fall into {len(codes)} islands, more than {MOST}: sew some of them together.")
    panels = [_panel(vertices, drawn, triangles[island == code], uvs) for code in codes]
    return sorted(panels, key=lambda panel: -len(panel.triangles))


def _panel(vertices: Floats, drawn: Ints, triangles: Ints, uvs: Floats) -> Panel:
    used, local = np.unique(triangles, return_inverse=True)
    local, own, flat = local.reshape(-1, 3), drawn[used], uvs[used].astype(np.float64)
    area, signed = _areas(vertices[own], local), _signed(flat, local)
    if signed.sum() == 0 or not np.isfinite(flat).all():
        raise UnusableUVs("An island of the UVs has no area: lay the pattern out in UV space.")
    # V may run down, and a pattern be cut for the other side.
    flat = flat * [1.0, np.sign(signed.sum())]
    signed = np.abs(signed) * np.sign(signed * signed.sum())
    places = flat * np.sqrt(area.sum() / np.abs(signed).sum())
    _check(places, local, area, signed / np.abs(signed).sum() * area.sum())
    return Panel(own, local, places)


def _check(places: Floats, triangles: Ints, area: Floats, laid: Floats) -> None:
    """Refuses a panel that is folded over, overlaps itself or is stretched. area, laid (F,): on the cloth, in UVs."""
    if laid[laid < 0].sum() < -TURNED * area.sum():
        raise UnusableUVs("The UVs are folded over within an island: lay every piece of the pattern flat.")
    ratio = np.abs(laid) / np.maximum(area, 1e-12)
    if area[(ratio > STRETCH) | (ratio < 1 / STRETCH)].sum() > STRETCHED * area.sum():
        raise UnusableUVs("The UVs are no pattern: parts of an island are many times as large as others.")
    if (share := _overlap(places, triangles)) > OVERLAP:
        raise UnusableUVs(f"{100 * share:.0f} % of an island of the UVs lies over other parts of it: cut it open.")


def _areas(x: Floats, triangles: Ints) -> Floats:
    a, b, c = x[triangles].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def _signed(flat: Floats, triangles: Ints) -> Floats:
    (a, b, c) = flat[triangles].transpose(1, 0, 2)
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def _overlap(places: Floats, triangles: Ints) -> float:
    """Share of the covered cells whose middle lies in two triangles or more."""
    low, high = places.min(0), places.max(0)
    at = (places - low) / max(float((high - low).max()), 1e-9) * CELLS
    count = np.zeros((CELLS + 2, CELLS + 2), np.int64)
    for corners in at[triangles]:
        first, last = np.ceil(corners.min(0) - 0.5).astype(int), np.floor(corners.max(0) - 0.5).astype(int)
        x, y = np.meshgrid(*(np.arange(a, b + 1) for a, b in zip(first, last, strict=True)), indexing="ij")
        points = np.stack([x.ravel(), y.ravel()], 1) + 0.5
        side = [_cross(corners[(k + 1) % 3] - corners[k], points - corners[k]) for k in range(3)]
        held = np.all(np.stack(side) > 0, 0) | np.all(np.stack(side) < 0, 0)
        count[x.ravel()[held], y.ravel()[held]] += 1
    return float((count > 1).sum() / max(int((count > 0).sum()), 1))


def _cross(one: Floats, others: Floats) -> Floats:
    return one[0] * others[:, 1] - one[1] * others[:, 0]
