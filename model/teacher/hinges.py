"""What bending does at a vertex of a hinge, in the closed form of the angle's gradient.

The same force, Hessian and damping as `newton`'s own function (shells after Grinspun et al., Discrete Shells, 2003),
which takes the gradient by products of matrices, a fifth of a drape's time on a CPU.
"""

from __future__ import annotations

import warp as wp
from newton._src.solvers.vbd import particle_vbd_kernels

#: The solver's own.
PRINTED = particle_vbd_kernels.evaluate_dihedral_angle_based_bending_force_hessian
#: m or m2, lengths and areas below which a hinge has no angle.
LEAST = wp.constant(1e-6)


@wp.func
def angle(n1: wp.vec3, n2: wp.vec3, e: wp.vec3) -> float:
    """Dihedral angle at an edge e of triangles with normals n1 and n2 of any length, rad; 0 flat."""
    return wp.atan2(wp.dot(wp.cross(n1, n2), e) / wp.length(e), wp.dot(n1, n2))


@wp.func
def gradient(corner: int, n1: wp.vec3, n2: wp.vec3, e: wp.vec3, to0: wp.vec3, to1: wp.vec3) -> wp.vec3:
    """Of the angle by the position of one corner, rad/m.

    n1, n2: normals, twice their triangles' areas long. e: the edge. to0, to1: from its start to the corners beside.
    """
    length = wp.length(e)
    # By the height of the corners 0 and 1 over the edge; the ends of the edge balance them.
    at0 = -n1 * (length / wp.length_sq(n1))
    at1 = -n2 * (length / wp.length_sq(n2))
    if corner == 0:
        return at0
    if corner == 1:
        return at1
    share0 = wp.dot(to0, e) / (length * length)
    share1 = wp.dot(to1, e) / (length * length)
    if corner == 2:
        return (share0 - 1.0) * at0 + (share1 - 1.0) * at1
    return -share0 * at0 - share1 * at1


@wp.func
def bending_force_hessian(
    hinge: int,
    corner: int,
    pos: wp.array[wp.vec3],
    before: wp.array[wp.vec3],
    corners: wp.array2d[wp.int32],
    rest_angle: wp.array[float],
    rest_length: wp.array[float],
    stiffness: float,
    damping: float,
    dt: float,
) -> tuple[wp.vec3, wp.mat33]:
    """Force (N) and Hessian (N/m) of one hinge on one of its corners."""
    force = wp.vec3(0.0)
    hessian = wp.mat33(0.0)
    if corners[hinge, 0] == -1 or corners[hinge, 1] == -1:
        return force, hessian
    x0 = pos[corners[hinge, 0]]
    x1 = pos[corners[hinge, 1]]
    x2 = pos[corners[hinge, 2]]
    x3 = pos[corners[hinge, 3]]
    e = x3 - x2
    n1 = wp.cross(x2 - x0, x3 - x0)
    n2 = wp.cross(x3 - x1, x2 - x1)
    least = LEAST * LEAST
    if wp.length_sq(n1) < least or wp.length_sq(n2) < least or wp.length_sq(e) < least:
        return force, hessian
    now = angle(n1, n2, e)
    slope = gradient(corner, n1, n2, e, x0 - x2, x1 - x2)
    along = wp.outer(slope, slope)
    length = rest_length[hinge]
    force = -stiffness * length * (now - rest_angle[hinge]) * slope
    hessian = stiffness * length * along
    if damping > 0.0:
        b0 = before[corners[hinge, 0]]
        b1 = before[corners[hinge, 1]]
        b2 = before[corners[hinge, 2]]
        b3 = before[corners[hinge, 3]]
        last = angle(wp.cross(b2 - b0, b3 - b0), wp.cross(b3 - b1, b2 - b1), b3 - b2)
        turned = now - last
        if turned > wp.pi:
            turned = turned - 2.0 * wp.pi
        elif turned < -wp.pi:
            turned = turned + 2.0 * wp.pi
        force = force - damping * length * turned / dt * slope
        hessian = hessian + damping * length / dt * along
    return force, hessian


def use() -> None:
    """Lets the solver bend this way; before its kernels are compiled."""
    particle_vbd_kernels.evaluate_dihedral_angle_based_bending_force_hessian = bending_force_hessian
