"""Contacts of the cloth with itself, on a CPU: only the pairs that are near, where a sweep asks for each colour.

What `newton` does for every edge and vertex of the cloth in a thread of its own, most of which find nothing: with some
hundred pairs among thousands of edges that walk was a quarter of a drape's time. Forces and limits are its own.
World space, SI.
"""

from __future__ import annotations

import warp as wp
from newton._src.geometry.tri_mesh_collision import (
    TriMeshCollisionInfo,
    get_edge_colliding_edges_count,
    get_vertex_colliding_triangles_count,
)
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


@wp.kernel
def gather(found: TriMeshCollisionInfo, near: Near) -> None:
    """Lists the pairs of a look for contacts, one thread."""
    count = wp.int32(0)
    for e in range(found.edge_colliding_edges_buffer_sizes.shape[0]):
        start = found.edge_colliding_edges_offsets[e]
        for k in range(get_edge_colliding_edges_count(found, e)):
            near.edges[count] = wp.vec2i(e, found.edge_colliding_edges[2 * (start + k) + 1])
            count += 1
    near.counts[0] = count
    count = wp.int32(0)
    for v in range(found.vertex_colliding_triangles_buffer_sizes.shape[0]):
        start = found.vertex_colliding_triangles_offsets[v]
        for k in range(get_vertex_colliding_triangles_count(found, v)):
            near.corners[count] = wp.vec2i(v, found.vertex_colliding_triangles[2 * (start + k) + 1])
            count += 1
    near.counts[1] = count


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


@wp.func
def any_of(v: wp.vec4i, count: int, colour: int, colours: wp.array[int]) -> bool:
    """Whether one of the first `count` vertices is of a colour."""
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
    """Moves the vertices of a colour, `members`, without letting near pairs meet, one thread.

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
