"""Whether a simulated drape can be a target: at rest, whole, outside of the body and of itself."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from body.anny_body import vertex_normals
from garment.graph import mesh_edges

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]


@dataclass(frozen=True)
class Limits:
    """What a target may have at most."""

    residual: float = 2e-3  # m that the vertices still move on average, see `simulation.Settings`
    inside: float = 0.01  # share of the vertices and triangle centres behind the skin
    stretch: float = 2.0  # 99.9th percentile of length over rest length
    crossed: float = 0.02  # share of the edges that newly pass through a triangle of the cloth


@dataclass(frozen=True)
class Judged:
    """Figures of one simulated drape."""

    residual: float
    inside: float
    stretch: float
    crossed: float

    def fault(self, limits: Limits) -> str | None:
        """The first limit that is broken, none for a target; not a number breaks all."""
        for name in Limits.__dataclass_fields__:
            if not getattr(self, name) <= getattr(limits, name):
                return name
        return None


def good(path: Path) -> Floats | None:
    """Cloth (N, 3) of a drape that is there and has no fault."""
    return None if not path.exists() or fault(path) else np.load(path)["x"]


def fault(path: Path) -> str:
    """What keeps a drape from being a target, empty for none."""
    kept = np.load(path)
    return Judged(*(float(kept[name]) for name in Judged.__dataclass_fields__)).fault(Limits()) or ""


def judge(x: Floats, residual: float, start: tuple[Ints, Floats], triangles: Ints, body: tuple[Floats, Ints]) -> Judged:
    """Judges cloth x (N, 3) on a body, (V, 3) and (F, 3).

    start: edges that cross the cloth where it started (`crossing`), and its rest pose (N, 3).
    """
    if not np.isfinite(x).all():
        return Judged(np.nan, np.nan, np.nan, np.nan)
    used = np.unique(body[1])
    normals = vertex_normals(*body)[used]
    # Only vertices collide: what bends far under a coarse triangle shows at its centre.
    points = np.concatenate([x, x[triangles].mean(1)])
    hit = cKDTree(body[0][used]).query(points)[1]
    inside = ((points - body[0][used][hit]) * normals[hit]).sum(1) < 0
    edges = mesh_edges(triangles)
    ratio = lengths(x, edges) / np.maximum(lengths(start[1], edges), 1e-5)
    crossed = np.setdiff1d(crossing(x, triangles), start[0])
    return Judged(residual, float(inside.mean()), float(np.quantile(ratio, 0.999)), len(crossed) / len(edges))


def lengths(x: Floats, edges: Ints) -> Floats:
    """(E,) of edges (E, 2)."""
    return np.linalg.norm(x[edges[:, 0]] - x[edges[:, 1]], axis=1)


def crossing(x: Floats, triangles: Ints) -> Ints:
    """Numbers of the edges that pass through a triangle of the same cloth which they do not touch."""
    edges = mesh_edges(triangles)
    centre = x[triangles].mean(1)
    radius = np.linalg.norm(x[triangles] - centre[:, None], axis=2).max(1)
    e, t = _meeting((x[edges].mean(1), lengths(x, edges) / 2), (centre, radius))
    apart = ~(triangles[t][:, :, None] == edges[e][:, None, :]).any((1, 2))
    e, t = e[apart], t[apart]
    return np.unique(e[_passes(x[edges[e]], x[triangles[t]])])


def _meeting(a: tuple[Floats, Floats], b: tuple[Floats, Floats]) -> tuple[Ints, Ints]:
    """Numbers of the spheres that meet, (K,) each, of two sets by their centres, (N, 3), and radii, (N,)."""
    pairs = [np.zeros((2, 0), np.int64)]
    # The few large ones by themselves, or all would be looked for as far away as they.
    for mine, theirs in product(_by_size(a[1]), _by_size(b[1])):
        reach = a[1][mine].max() + b[1][theirs].max()
        found = cKDTree(a[0][mine]).sparse_distance_matrix(cKDTree(b[0][theirs]), reach, output_type="ndarray")
        i, j = mine[found["i"]], theirs[found["j"]]
        meet = found["v"] <= a[1][i] + b[1][j]
        pairs.append(np.stack([i[meet], j[meet]]))
    i, j = np.concatenate(pairs, 1)
    return i, j


def _by_size(radius: Floats) -> list[Ints]:
    """Numbers of the large tenth and of the others, where there are any."""
    large = radius > np.quantile(radius, 0.9)
    return [part for part in (np.flatnonzero(~large), np.flatnonzero(large)) if len(part)]


def _passes(segment: Floats, triangle: Floats) -> NDArray[np.bool_]:
    """Whether segments (K, 2, 3) pass through triangles (K, 3, 3), by Möller and Trumbore (1997)."""
    p, d = segment[:, 0], segment[:, 1] - segment[:, 0]
    a, u, v = triangle[:, 0], triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    h = np.cross(d, v)
    det = (u * h).sum(1)
    safe = np.where(np.abs(det) < 1e-14, np.inf, det)
    s = p - a
    q = np.cross(s, u)
    along_u, along_v, at = (s * h).sum(1) / safe, (d * q).sum(1) / safe, (v * q).sum(1) / safe
    return (along_u > 0) & (along_v > 0) & (along_u + along_v < 1) & (at > 0) & (at < 1) & np.isfinite(safe)
