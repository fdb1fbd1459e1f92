"""Contacts of the cloth with itself, on a CPU: only the pairs that are near, where a sweep asks for each colour.

What `newton` does for every edge and vertex of the cloth in a thread of its own, most of which find nothing: with some
hundred pairs among thousands of edges that walk was a quarter of a drape's time. Forces and limits are its own.
World space, SI.
"""

from __future__ import annotations

import warp as wp
from newton._src.geometry.kernels import triangle_closest_point
from newton._src.solvers.vbd.particle_vbd_kernels import (
    create_edge_edge_division_plane_closest_pt,
    create_vertex_triangle_division_plane_closest_pt,
    evaluate_edge_edge_contact_2_vertices,
    evaluate_vertex_triangle_collision_force_hessian_4_vertices,
    planar_truncation_t,
)


@wp.struct
class Near:
    """Pairs of the last look for contacts."""

    edges: wp.array[wp.vec2i]  # an edge and one near it; each of a pair stands first once
    corners: wp.array[wp.vec2i]  # a vertex and a triangle near it
    counts: wp.array[int]  # of both
    edge_ends: wp.array2d[int]  # (E, 4) corners beside the edge, then its ends
    triangles: wp.array2d[int]  # (T, 3)


@wp.struct
class Touch:
    """How cloth touches cloth."""

    distance: float  # m
    stiffness: float  # N/m
    damping: float
    friction: float
    slip: float  # m/s up to which friction grows
    parallel: float  # sine of the angle below which edges count as parallel


@wp.func
def ends(pair: wp.vec2i, near: Near) -> wp.vec4i:
    """Vertices of two edges."""
    a = pair[0]
    b = pair[1]
    return wp.vec4i(near.edge_ends[a, 2], near.edge_ends[a, 3], near.edge_ends[b, 2], near.edge_ends[b, 3])


@wp.func
def points(pair: wp.vec2i, near: Near) -> wp.vec4i:
    """A vertex and those of a triangle."""
    t = pair[1]
    return wp.vec4i(pair[0], near.triangles[t, 0], near.triangles[t, 1], near.triangles[t, 2])


@wp.struct
class Search:
    """What counts as near."""

    reach: float  # m
    least: float  # m, pairs closer than this at rest are never told
    parallel: float
    rest: wp.array[wp.vec3]  # (N,)
    edges_by_edge: wp.array[int]  # edges around each edge, which are never told
    edge_rows: wp.array[int]  # (E + 1,) where they begin
    triangles_by_vertex: wp.array[int]  # the same of triangles around each vertex
    vertex_rows: wp.array[int]  # (N + 1,)


@wp.func
def listed(what: int, table: wp.array[int], rows: wp.array[int], row: int) -> bool:
    """Whether a row of a table has a number."""
    for k in range(rows[row], rows[row + 1]):  # noqa: SIM110, kernels know no generators
        if table[k] == what:
            return True
    return False


@wp.func
def edge_gap(v: wp.vec4i, x: wp.array[wp.vec3], parallel: float) -> float:
    """Distance of two edges, m."""
    return wp.closest_point_edge_edge(x[v[0]], x[v[1]], x[v[2]], x[v[3]], parallel)[2]


@wp.func
def corner_gap(v: wp.vec4i, x: wp.array[wp.vec3]) -> float:
    """Distance of a vertex and a triangle, m."""
    closest, _weights, _feature = triangle_closest_point(x[v[1]], x[v[2]], x[v[3]], x[v[0]])
    return wp.length(closest - x[v[0]])


@wp.kernel
def find_edges(tree: wp.uint64, search: Search, x: wp.array[wp.vec3], near: Near) -> None:
    """Lists edges that are near each other, a thread an edge, one after the other. tree: of the edges at x."""
    e = wp.tid()
    a = x[near.edge_ends[e, 2]]
    b = x[near.edge_ends[e, 3]]
    out = wp.vec3(search.reach)
    query = wp.bvh_query_aabb(tree, wp.min(a, b) - out, wp.max(a, b) + out)
    other = wp.int32(0)
    while wp.bvh_query_next(query, other):
        if other <= e:
            continue
        v = ends(wp.vec2i(e, other), near)
        if (
            v[0] == v[2]
            or v[0] == v[3]
            or v[1] == v[2]
            or v[1] == v[3]
            or edge_gap(v, x, search.parallel) >= search.reach
        ):
            continue
        if listed(other, search.edges_by_edge, search.edge_rows, e):
            continue
        if edge_gap(v, search.rest, search.parallel) < search.least or near.counts[0] + 2 > near.edges.shape[0]:
            continue
        k = wp.atomic_add(near.counts, 0, 2)
        near.edges[k] = wp.vec2i(e, other)
        near.edges[k + 1] = wp.vec2i(other, e)


@wp.kernel
def find_corners(tree: wp.uint64, search: Search, x: wp.array[wp.vec3], near: Near) -> None:
    """The same of vertices and triangles, a thread a vertex. tree: of the triangles at x."""
    i = wp.tid()
    out = wp.vec3(search.reach)
    query = wp.bvh_query_aabb(tree, x[i] - out, x[i] + out)
    t = wp.int32(0)
    while wp.bvh_query_next(query, t):
        v = points(wp.vec2i(i, t), near)
        if i == v[1] or i == v[2] or i == v[3] or corner_gap(v, x) >= search.reach:
            continue
        if listed(t, search.triangles_by_vertex, search.vertex_rows, i):
            continue
        if corner_gap(v, search.rest) < search.least or near.counts[1] + 1 > near.corners.shape[0]:
            continue
        k = wp.atomic_add(near.counts, 1, 1)
        near.corners[k] = wp.vec2i(i, t)


@wp.func
def any_of(v: wp.vec4i, count: int, colour: int, colours: wp.array[int]) -> bool:
    """Whether one of the first `count` vertices is of a colour; every one is of colour -1."""
    if colour < 0:
        return True
    for i in range(count):  # noqa: SIM110, kernels know no generators
        if colours[v[i]] == colour:
            return True
    return False


@wp.func
def press(
    v: int,
    force: wp.vec3,
    hessian: wp.mat33,
    colour: int,
    colours: wp.array[int],
    forces: wp.array[wp.vec3],
    hessians: wp.array[wp.mat33],
) -> None:
    """Adds to a vertex, if it is of the colour."""
    if colours[v] == colour:
        forces[v] = forces[v] + force
        hessians[v] = hessians[v] + hessian


@wp.kernel
def push_apart(
    dt: float,
    colour: int,
    colours: wp.array[int],
    near: Near,
    touch: Touch,
    before: wp.array[wp.vec3],
    now: wp.array[wp.vec3],
    forces: wp.array[wp.vec3],
    hessians: wp.array[wp.mat33],
) -> None:
    """Adds what the pairs do to the vertices of a colour, one thread."""
    for k in range(near.counts[0]):
        pair = near.edges[k]
        v = ends(pair, near)
        # The other edge stands first in a pair of its own.
        if any_of(v, 2, colour, colours):
            touches, f0, f1, h0, h1 = evaluate_edge_edge_contact_2_vertices(
                pair[0], pair[1], now, before, near.edge_ends, touch.distance, touch.stiffness, touch.damping,
                touch.friction, touch.slip, dt, touch.parallel,
            )  # fmt: skip
            if touches:
                press(v[0], f0, h0, colour, colours, forces, hessians)
                press(v[1], f1, h1, colour, colours, forces, hessians)
    for k in range(near.counts[1]):
        pair = near.corners[k]
        v = points(pair, near)
        if any_of(v, 4, colour, colours):
            touches, f0, f1, f2, f, h0, h1, h2, h = evaluate_vertex_triangle_collision_force_hessian_4_vertices(
                pair[0], pair[1], now, before, near.triangles, touch.distance, touch.stiffness, touch.damping,
                touch.friction, touch.slip, dt,
            )  # fmt: skip
            if touches:
                press(v[0], f, h, colour, colours, forces, hessians)
                press(v[1], f0, h0, colour, colours, forces, hessians)
                press(v[2], f1, h1, colour, colours, forces, hessians)
                press(v[3], f2, h2, colour, colours, forces, hessians)


@wp.func
def shorten(
    v: wp.vec4i,
    first: int,
    plane: wp.vec3,
    at: wp.vec3,
    gamma: float,
    gap: float,
    seen: wp.array[wp.vec3],
    moved: wp.array[wp.vec3],
    share: wp.array[float],
) -> None:
    """Lets four vertices, the first ones on the side that a plane faces, go no farther than to it."""
    for i in range(4):
        out = wp.where(i < first, plane, -plane)
        share[v[i]] = wp.min(share[v[i]], planar_truncation_t(seen[v[i]], moved[v[i]], out, at, gamma, gap))


@wp.func
def move(
    v: int,
    most: float,
    seen: wp.array[wp.vec3],
    share: wp.array[float],
    moved: wp.array[wp.vec3],
    now: wp.array[wp.vec3],
) -> None:
    """Moves a vertex by the share that it may go, which is all of it from then on."""
    step = share[v] * moved[v]
    length = wp.length(step)
    if length > most:
        step = step * (most / length)
    moved[v] = step
    now[v] = seen[v] + step
    share[v] = 1.0


@wp.kernel
def keep_apart(
    colour: int,
    members: wp.array[int],
    colours: wp.array[int],
    near: Near,
    gamma: float,
    most: float,
    seen: wp.array[wp.vec3],
    share: wp.array[float],
    moved: wp.array[wp.vec3],
    now: wp.array[wp.vec3],
) -> None:
    """Moves the vertices of a colour (-1: all), `members`, without letting near pairs meet, one thread.

    seen: m, where the step began. moved: m, from there, `most` at most. share: 1 for all, before and after. Pairs
    without a vertex of the colour are as they were.
    """
    for k in range(near.counts[0]):
        v = ends(near.edges[k], near)
        if any_of(v, 4, colour, colours):
            apart, plane, at, gap = create_edge_edge_division_plane_closest_pt(
                seen[v[0]], moved[v[0]], seen[v[1]], moved[v[1]], seen[v[2]], moved[v[2]], seen[v[3]], moved[v[3]]
            )
            if apart:
                shorten(v, 2, plane, at, gamma, gap, seen, moved, share)
    for k in range(near.counts[1]):
        v = points(near.corners[k], near)
        if any_of(v, 4, colour, colours):
            apart, plane, at, gap = create_vertex_triangle_division_plane_closest_pt(
                seen[v[0]], moved[v[0]], seen[v[1]], moved[v[1]], seen[v[2]], moved[v[2]], seen[v[3]], moved[v[3]]
            )
            if apart:
                shorten(v, 1, plane, at, gamma, gap, seen, moved, share)
    for k in range(members.shape[0]):
        move(members[k], most, seen, share, moved, now)
    for k in range(near.counts[0]):
        v = ends(near.edges[k], near)
        for i in range(4):
            move(v[i], most, seen, share, moved, now)
    for k in range(near.counts[1]):
        v = points(near.corners[k], near)
        for i in range(4):
            move(v[i], most, seen, share, moved, now)
