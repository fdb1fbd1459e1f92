"""Collars, belts, ties and bows: small pieces that lie on finished garments."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import fields as fl
from .marching import Field
from .mesh import Array, GarmentMesh, Index
from .pattern import Pattern, Shape
from .remesh import Surface

LIFT = 0.005


@dataclass(frozen=True)
class Trimming:
    """An ornament on the garments sewn before it; `values` are the measurements its maker takes, in metres."""

    kind: str  # belt, collar, lapels, tie or bow
    values: tuple[float, ...]
    on: int = -1  # index of the garment that a collar or lapels follow


def trim_shape(trimming: Trimming, worn: list[Shape]) -> Shape:
    """Shape of a belt (height, width), collar (fall, point) or lapels (width, low)."""
    first, second = trimming.values
    if trimming.kind == "belt":
        return belt(worn, first, second)
    make = {"collar": collar, "lapels": lapels}[trimming.kind]
    return make(worn[trimming.on], worn, first, second)


def trim_sheet(trimming: Trimming, worn: list[Shape], layer: int) -> GarmentMesh:
    """Mesh of a tie (top, length) or bow (x, y, size)."""
    if trimming.kind == "tie":
        return tie(worn, *trimming.values, layer)
    x, y, size = trimming.values
    return bow(worn, (x, y), size, layer)


def over(shapes: list[Shape], lift: float) -> Field:
    """Field of the surface `lift` metres above everything worn."""
    solids = [s.solid(lift) for s in shapes]

    def field(p: Array) -> Array:
        out = solids[0](p)
        for solid in solids[1:]:
            out = fl.smooth_min(out, solid(p), 0.008)
        return out

    return field


def belt(worn: list[Shape], height: float, width: float) -> Shape:
    """A closed band of `width` metres about the waist at `height`."""
    pattern = Pattern("belt", "belt", top=height + width / 2, hem=height - width / 2)
    g = lambda p: np.abs(p[:, 1] - height) - width / 2  # noqa: E731
    low, high = np.array([-0.34, height - 0.08, -0.30]), np.array([0.34, height + 0.08, 0.34])
    return Shape(pattern, Surface(over(worn, LIFT), g), low, high)


def collar(shirt: Shape, worn: list[Shape], fall: float, point: float) -> Shape:
    """A turned-down collar: from the neckline down over the shoulders, with two points in front."""
    front, back, width, *powers = shirt.pattern.neck
    neck = fl.neckline(front, back, width, (powers[0], powers[1]))

    def g(p: Array) -> Array:
        x = np.abs(p[:, 0])
        ahead = fl.ramp(p[:, 2], 0.03, 0.07)
        depth = fall + point * ahead * np.exp(-(((x - 0.052) / 0.030) ** 2))
        level = neck(p)
        reach = np.hypot(p[:, 0], p[:, 2] - 0.012) - (0.112 + 0.030 * ahead)
        gap = ahead * 0.10 + (0.006 - 0.55 * level - x) - 0.10
        outside = np.maximum(level + 0.001, -depth - level)
        return fl.smooth_max(fl.smooth_max(outside, reach, 0.01), gap, 0.004)

    pattern = Pattern("collar", "collar")
    return Shape(pattern, Surface(over(worn, 0.007), g), np.array([-0.17, 1.40, -0.13]), np.array([0.17, 1.66, 0.19]))


def lapels(jacket: Shape, worn: list[Shape], width: float, low: float) -> Shape:
    """A shawl collar along the edge of an open front down to height `low`."""
    edge = jacket.surface.g

    def g(p: Array) -> Array:
        taper = width * fl.ramp(p[:, 1], low, low + 0.22) * (1 - 0.35 * fl.ramp(p[:, 1], 1.46, 1.56))
        side = fl.smooth_max(edge(p) + 0.001, -edge(p) - taper, 0.004)
        return np.maximum(side, np.maximum(low + 0.01 - p[:, 1], np.abs(p[:, 0]) - 0.14))

    pattern = Pattern("lapels", "lapels")
    return Shape(
        pattern, Surface(over(worn, LIFT), g), np.array([-0.17, low - 0.03, -0.14]), np.array([0.17, 1.64, 0.30])
    )


def front_depth(field: Field, x: Array, y: Array) -> Array:
    """Foremost z at which a field is zero above points (x, y), by bisection inwards from z = 0.45."""
    z = np.full(x.shape, 0.45)
    for _ in range(60):
        value = field(np.stack([x, y, z], 1))
        z = z - np.clip(0.8 * value, -0.02, 0.02)
    return z


def sheet(points: Array) -> tuple[Array, Index]:
    """Quads of a grid (R, C, 3), split along alternating diagonals, facing the cross of columns and rows."""
    rows, columns = points.shape[:2]
    ids = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = ids[:-1, :-1].ravel(), ids[:-1, 1:].ravel(), ids[1:, 1:].ravel(), ids[1:, :-1].ravel()
    odd = (np.add.outer(np.arange(rows - 1), np.arange(columns - 1)) % 2).ravel() == 1
    first = np.where(odd[:, None], np.stack([a, b, c], 1), np.stack([a, b, d], 1))
    second = np.where(odd[:, None], np.stack([a, c, d], 1), np.stack([b, c, d], 1))
    return points.reshape(-1, 3), np.concatenate([first, second])


def tie(worn: list[Shape], top: float, length: float, layer: int) -> GarmentMesh:
    """A necktie lying on the shirt's front: knot, blade and pointed end; `top` is the height of the knot."""
    s = np.linspace(0, 1, int(length / 0.011))
    half = np.interp(s, [0, 0.09, 0.105, 0.85, 0.95, 1.0], [0.021, 0.014, 0.013, 0.040, 0.038, 0.002])
    across = np.linspace(-1, 1, 7)
    # The point: rows bend down towards the middle near the end.
    dip = 0.035 * fl.ramp(s, 0.86, 1.0)[:, None] * (1 - np.abs(across))[None]
    full = np.where(s[:, None] > 0.86, np.interp(s, [0.86, 1.0], [0.040, 0.036])[:, None], half[:, None])
    x = full * across
    y = top - length * s[:, None] - dip + 0 * x
    z = front_depth(over(worn, LIFT), x.ravel(), y.ravel()).reshape(x.shape)
    knot = 0.011 * np.exp(-(((s - 0.05) / 0.045) ** 4))[:, None] * (1 - across**2)
    crease = 0.0025 * (1 - across**2)[None]
    vertices, triangles = sheet(np.stack([x, y, z + knot + crease], 2)[::-1])
    return GarmentMesh("tie", "tie", layer, vertices, triangles)


def bow(worn: list[Shape], centre: tuple[float, float], size: float, layer: int) -> GarmentMesh:
    """A ribbon bow at (x, y) on the front: two loops, two tails and a knot, five loose pieces."""
    field = over(worn, LIFT + 0.002)
    at = np.array([*centre, front_depth(field, *np.array([[centre[0]], [centre[1]]]))[0] + 0.006])
    pieces = [_loop(at, size, s) for s in (-1, 1)] + [_tail(field, at, size, s) for s in (-1, 1)] + [_knot(at, size)]
    vertices, triangles, offset = [], [], 0
    for v, t in pieces:
        vertices.append(v)
        triangles.append(t + offset)
        offset += len(v)
    return GarmentMesh("bow", "bow", layer, np.concatenate(vertices), np.concatenate(triangles))


def _loop(at: Array, size: float, side: int) -> tuple[Array, Index]:
    t = np.linspace(0.03, 0.97, 25)
    across = np.linspace(-1, 1, 6)
    half = size * (0.10 + 0.26 * np.sin(np.pi * t) ** 0.8)
    x = side * size * np.sin(np.pi * t) ** 0.9
    z = 0.20 * size * (1 - np.cos(2 * np.pi * t)) * 0.5 + 0.16 * size * np.sin(2 * np.pi * t)
    x, z = (np.broadcast_to(k[:, None], (25, 6)) for k in (x, z))
    y = half[:, None] * across - 0.10 * np.abs(x)
    grid = np.stack([x, y, z + 0.16 * size + 0 * y], 2) + at
    return sheet(grid if side > 0 else grid[:, ::-1])


def _tail(field: Field, at: Array, size: float, side: int) -> tuple[Array, Index]:
    s = np.linspace(0, 1, 18)[:, None]
    across = np.linspace(-1, 1, 5)[None]
    half = size * (0.09 + 0.17 * s)
    x = at[0] + side * (0.10 + 0.45 * s) * size + half * across
    y = at[1] - size * (0.10 + 1.7 * s) + side * across * half * 0.3 - 0.25 * size * s * np.abs(across)
    z = front_depth(field, x.ravel(), y.ravel()).reshape(x.shape) + 0.004 + 0.003 * np.sin(6 * s) * (side > 0)
    return sheet(np.stack([x, y, z], 2)[::-1])


def _knot(at: Array, size: float) -> tuple[Array, Index]:
    """A closed ring about the x axis, bulging in the middle."""
    turn = np.linspace(0, 2 * np.pi, 17)[:-1]
    across = np.linspace(-1, 1, 5)
    radius = size * (0.13 + 0.05 * (1 - across**2))
    x = np.broadcast_to(across * 0.15 * size, (16, 5))
    y, z = np.cos(turn)[:, None] * radius * 1.1, np.sin(turn)[:, None] * radius * 0.8
    points = np.stack([x, y, z + 0.20 * size], 2) + at
    ids = np.arange(80).reshape(16, 5)
    ids = np.concatenate([ids, ids[:1]])
    a, b, c, d = ids[:-1, :-1].ravel(), ids[:-1, 1:].ravel(), ids[1:, 1:].ravel(), ids[1:, :-1].ravel()
    return points.reshape(-1, 3), np.concatenate([np.stack([a, b, d], 1), np.stack([b, c, d], 1)])
