"""Extract the zero level set of a field by marching tetrahedra, and trim it by a second field."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .mesh import Array, Index, compact

Field = Callable[[Array], Array]
CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
# Six tetrahedra around the cube's main diagonal 0-7 (Kuhn subdivision): conforming between neighbouring cubes.
TETRAHEDRA = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])
COARSE = 4


def level_set(f: Field, low: Array, high: Array, step: float) -> tuple[Array, Index]:
    """Triangles of f = 0 inside a box, oriented towards growing f; f must change by at most about 1 per metre.

    A coarse grid finds the blocks that the surface can reach; only those are sampled at `step`.
    """
    blocks = np.ceil((np.asarray(high) - low) / (COARSE * step)).astype(int)
    size = blocks * COARSE + 1
    cubes = _cubes_near_surface(f, np.asarray(low), blocks, step)
    corner_ids = _id(cubes[:, None] + CORNERS, size)
    ids, local = np.unique(corner_ids, return_inverse=True)
    points = np.asarray(low) + np.stack(np.unravel_index(ids, size), 1) * step
    values = f(points)
    values = np.where(np.abs(values) < 1e-9, 1e-9, values)
    local = local.reshape(-1, 8)
    signs = values[local] > 0
    local = local[signs.any(1) & ~signs.all(1)]
    return _march(points, values, local[:, TETRAHEDRA].reshape(-1, 4))


def _id(cells: Index, size: Index) -> Index:
    return (cells[..., 0] * size[1] + cells[..., 1]) * size[2] + cells[..., 2]


def _cubes_near_surface(f: Field, low: Array, blocks: Index, step: float) -> Index:
    axes = [np.arange(n + 1) for n in blocks]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
    values = f(low + grid.reshape(-1, 3) * COARSE * step).reshape(blocks + 1)
    near = np.full(tuple(blocks), np.inf)
    for i, j, k in CORNERS:
        block = np.abs(values[i : i + blocks[0], j : j + blocks[1], k : k + blocks[2]])
        near = np.minimum(near, block)
    active = np.argwhere(near < COARSE * step * 1.1)
    inner = np.stack(np.meshgrid(*[np.arange(COARSE)] * 3, indexing="ij"), -1).reshape(-1, 3)
    return (active[:, None] * COARSE + inner).reshape(-1, 3)


def _march(points: Array, values: Array, tets: Index) -> tuple[Array, Index]:
    inside = values[tets] < 0
    count = inside.sum(1)
    order = np.argsort(~inside, axis=1, kind="stable")
    tets = np.take_along_axis(tets, order, 1)
    one, two, three = tets[count == 1], tets[count == 2], tets[count == 3]
    a, b, c, d = two.T
    edges = np.concatenate(
        [
            np.stack([one[:, [0, 1]], one[:, [0, 2]], one[:, [0, 3]]], 1),
            np.stack([three[:, [0, 3]], three[:, [1, 3]], three[:, [2, 3]]], 1),
            np.stack([np.stack([a, c], 1), np.stack([a, d], 1), np.stack([b, d], 1)], 1),
            np.stack([np.stack([a, c], 1), np.stack([b, d], 1), np.stack([b, c], 1)], 1),
        ]
    )
    outward = np.concatenate([_towards(points, t, n) for t, n in ((one, 1), (three, 3), (two, 2), (two, 2))])
    return _weld_crossings(points, values, edges, outward)


def _towards(points: Array, tets: Index, inside: int) -> Array:
    p = points[tets]
    return p[:, inside:].mean(1) - p[:, :inside].mean(1)


def _weld_crossings(points: Array, values: Array, edges: Index, outward: Array) -> tuple[Array, Index]:
    low, high = edges.min(-1), edges.max(-1)
    keys, inverse = np.unique(low.astype(np.int64) * len(points) + high, return_inverse=True)
    i, j = keys // len(points), keys % len(points)
    # Crossings keep off the lattice points, where all of a vertex's triangles would degenerate.
    t = np.clip(values[i] / (values[i] - values[j]), 0.05, 0.95)[:, None]
    vertices = points[i] * (1 - t) + points[j] * t
    triangles = inverse.reshape(-1, 3)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    flip = (np.cross(b - a, c - a) * outward).sum(1) < 0
    triangles[flip] = triangles[flip][:, [0, 2, 1]]
    return vertices, triangles


def trim(vertices: Array, triangles: Index, g: Field) -> tuple[Array, Index]:
    """Keep the part of a mesh where g < 0; cut triangles get straight new edges along g = 0."""
    value = g(vertices)
    value = np.where(np.abs(value) < 1e-6, -1e-6, value)
    kept = value[triangles] < 0
    count = kept.sum(1)
    whole = triangles[count == 3]
    rows = np.flatnonzero((count == 1) | (count == 2))
    # Rotate so that corner 0 is the odd one out; the winding stays.
    odd = np.where(count[rows, None] == 1, kept[rows], ~kept[rows]).argmax(1)
    cut = triangles[rows[:, None], (odd[:, None] + np.arange(3)) % 3]
    new, ab, ac = _cut_points(vertices, value, cut)
    single = count[rows] == 1
    a, b, c = cut.T
    pieces = [
        whole,
        np.stack([a, ab, ac], 1)[single],
        np.stack([ab, b, c], 1)[~single],
        np.stack([ab, c, ac], 1)[~single],
    ]
    return compact(np.concatenate([vertices, new]), np.concatenate(pieces))


def _cut_points(vertices: Array, value: Array, cut: Index) -> tuple[Array, Index, Index]:
    ends = np.concatenate([cut[:, [0, 1]], cut[:, [0, 2]]])
    low, high = ends.min(1), ends.max(1)
    keys, inverse = np.unique(low * len(vertices) + high, return_inverse=True)
    i, j = keys // len(vertices), keys % len(vertices)
    t = np.clip(value[i] / (value[i] - value[j]), 0.02, 0.98)[:, None]
    ids = len(vertices) + inverse
    return vertices[i] * (1 - t) + vertices[j] * t, ids[: len(cut)], ids[len(cut) :]
