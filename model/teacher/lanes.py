"""Stretch and bending at sixteen vertices of a colour at a time, on a CPU.

`newton` has a thread a vertex, which a CPU runs one after the other; the wide registers of one core do the same for
sixteen (`lanes.h`). That was two fifths of a drape's time.
"""

from __future__ import annotations

from pathlib import Path

import newton
import numpy as np
import warp as wp
from numpy.typing import NDArray

Ints = NDArray[np.integer]
#: Vertices at a time, as in `lanes.h`.
WIDTH = 16


@wp.struct
class Lanes:
    """Groups of vertices of one colour, and what each vertex is part of, from its own point of view.

    Of K-th triangles, hinges and so on of a group, (K, ..., WIDTH) flat; a vertex that has fewer than others of its
    group has some of no size.
    """

    vertices: wp.array[int]  # (G, WIDTH), filled up with the group's last
    sizes: wp.array[int]  # (G,) vertices of each group
    first_triangle: wp.array[int]  # (G + 1,)
    triangles: wp.array[int]  # (K, 2, WIDTH) the other corners
    shapes: wp.array[float]  # (K, 5, WIDTH) inverse of the edges to them at rest, row by row, and area, m2
    first_tip: wp.array[int]  # hinges beside whose edge the vertex lies
    tips: wp.array[int]  # (K, 3, WIDTH) the corner opposite, the ends of the edge
    tip_bends: wp.array[float]  # (K, 2, WIDTH) stiffness, N m, and angle at rest
    first_end: wp.array[int]  # hinges whose edge begins at the vertex
    ends: wp.array[int]  # (K, 3, WIDTH) the corners beside the edge, its other end
    end_bends: wp.array[float]


@wp.struct
class Skin:
    """The body where it is near a vertex."""

    first: wp.array[int]  # (N,) 3 times the contact of each vertex, or -1
    points: wp.array[wp.vec3]  # m, of each contact, world
    normals: wp.array[wp.vec3]
    stiffness: wp.array[float]  # N/m
    radius: wp.array[float]  # (N,) m, distance that each vertex keeps
    damping: float  # N s/m
    friction: float
    slip: float  # m/s up to which friction grows


@wp.func_native((Path(__file__).parent / "lanes.h").read_text())
def solve(
    group: int,
    dt: float,
    lame: float,
    cloth: Lanes,
    skin: Skin,
    before: wp.array[wp.vec3],
    positions: wp.array[wp.vec3],
    inertia: wp.array[wp.vec3],
    mass: wp.array[float],
    forces: wp.array[wp.vec3],
    hessians: wp.array[wp.mat33],
    displacements: wp.array[wp.vec3],
) -> None: ...


@wp.kernel
def solve_elasticity(
    first: int,
    dt: float,
    lame: float,
    cloth: Lanes,
    skin: Skin,
    before: wp.array[wp.vec3],
    positions: wp.array[wp.vec3],
    inertia: wp.array[wp.vec3],
    mass: wp.array[float],
    forces: wp.array[wp.vec3],
    hessians: wp.array[wp.mat33],
    displacements: wp.array[wp.vec3],
) -> None:
    """Adds a Newton step of each vertex to its displacement, a thread a group from `first` on."""
    solve(first + wp.tid(), dt, lame, cloth, skin, before, positions, inertia, mass, forces, hessians, displacements)


def lanes(model: newton.Model) -> tuple[Lanes, list[int]]:
    """Groups of a model's vertices that move, and where each colour's begin, with their end."""
    moves = (model.particle_flags.numpy() & int(newton.ParticleFlags.ACTIVE) != 0) & (model.particle_mass.numpy() > 0)
    corners, shapes = _triangles(model)
    tips, tip_bends, ends, end_bends = _hinges(model)
    parts = [_of_vertices(p, len(moves)) for p in (corners[:, 0], tips[:, 0], ends[:, 0])]
    groups, firsts = [], [0]
    for members in model.particle_color_groups:
        mine = members.numpy()
        mine = mine[moves[mine]]
        # Of like counts, so that few lanes stand idle.
        mine = mine[np.lexsort([[len(p[v]) for v in mine] for p in parts])]
        groups += [mine[i : i + WIDTH] for i in range(0, len(mine), WIDTH)]
        firsts.append(len(groups))
    out = Lanes()
    out.vertices = _array([np.pad(g, (0, WIDTH - len(g)), mode="edge") for g in groups], np.int32)
    out.sizes = _array([len(g) for g in groups], np.int32)
    out.first_triangle, out.triangles, out.shapes = _rows(groups, parts[0], corners[:, 1:], shapes)
    out.first_tip, out.tips, out.tip_bends = _rows(groups, parts[1], tips[:, 1:], tip_bends)
    out.first_end, out.ends, out.end_bends = _rows(groups, parts[2], ends[:, 1:], end_bends)
    return out, firsts


def _triangles(model: newton.Model) -> tuple[Ints, NDArray]:
    """Every triangle from each of its corners, (3 T, 3), with what `Lanes.shapes` says of it, (3 T, 5)."""
    triangles, area = model.tri_indices.numpy(), model.tri_areas.numpy()
    edges = np.linalg.inv(model.tri_poses.numpy().astype(np.float64))
    at = np.concatenate([np.zeros((len(edges), 1, 2)), edges.transpose(0, 2, 1)], 1)  # (T, corner, 2) in the plane
    corners, shapes = [], []
    for k in range(3):
        order = [k, (k + 1) % 3, (k + 2) % 3]
        from_here = (at[:, order[1:]] - at[:, order[:1]]).transpose(0, 2, 1)
        corners.append(triangles[:, order])
        shapes.append(np.column_stack([np.linalg.inv(from_here).reshape(-1, 4), area]))
    return np.concatenate(corners), np.concatenate(shapes)


def _hinges(model: newton.Model) -> tuple[Ints, NDArray, Ints, NDArray]:
    """Every hinge from its corners beside the edge and from its ends, (2 H, 4) and (2 H, 2) each."""
    hinges = model.edge_indices.numpy()
    stiffness = model.edge_bending_properties.numpy()[:, 0] * model.edge_rest_length.numpy()
    bends = np.column_stack([stiffness, model.edge_rest_angle.numpy()])
    bending = (hinges[:, :2] >= 0).all(1) & (stiffness > 0)
    hinges, bends = hinges[bending], np.tile(bends[bending], (2, 1))
    # Seen from the other side, corners and ends change places and the angle stays.
    around = np.concatenate([hinges, hinges[:, [1, 0, 3, 2]]])
    return around, bends, around[:, [2, 0, 1, 3]], bends


def _of_vertices(of: Ints, count: int) -> list[Ints]:
    """Rows that belong to each vertex."""
    order = np.argsort(of, kind="stable")
    return np.split(order, np.searchsorted(of[order], np.arange(1, count)))


def _rows(groups: list[Ints], parts: list[Ints], corners: Ints, values: NDArray) -> tuple[wp.array, wp.array, wp.array]:
    """Where each group's begin, and their corners and values a lane each."""
    firsts, indices, numbers = [0], [], []
    for group in groups:
        most = max(len(parts[v]) for v in group)
        index = np.empty((most, corners.shape[1], WIDTH), np.int32)
        number = np.zeros((most, values.shape[1], WIDTH), np.float32)
        for lane in range(WIDTH):
            v = group[min(lane, len(group) - 1)]
            mine, size = parts[v], len(parts[v])
            index[:size, :, lane], index[size:, :, lane] = corners[mine], v
            number[:size, :, lane] = values[mine]
        firsts.append(firsts[-1] + most)
        indices.append(index)
        numbers.append(number)
    return (
        _array(firsts, np.int32),
        _array(np.concatenate(indices), np.int32),
        _array(np.concatenate(numbers), np.float32),
    )


def _array(values: object, kind: type) -> wp.array:
    flat = np.asarray(values, kind).reshape(-1)
    return wp.array(flat, dtype=int if kind is np.int32 else float)
