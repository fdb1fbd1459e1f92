"""Bending in closed form against the simulator's own."""

from __future__ import annotations

import numpy as np
import warp as wp

from teacher import hinges

#: Hinges of four vertices each.
COUNT = 100


def each_corner(law: wp.Function) -> tuple[np.ndarray, np.ndarray]:
    """Force and Hessian that a law gives at every corner of random hinges."""

    @wp.kernel(module="unique")
    def ask(
        pos: wp.array[wp.vec3], before: wp.array[wp.vec3], corners: wp.array2d[wp.int32], angle: wp.array[float],
        length: wp.array[float], force: wp.array[wp.vec3], hessian: wp.array[wp.mat33],
    ) -> None:  # fmt: skip
        i = wp.tid()
        f, h = law(i // 4, i % 4, pos, before, corners, angle, length, 2.0, 0.3, 0.1)
        force[i] = f
        hessian[i] = h

    rng = np.random.default_rng(0)
    pos = rng.normal(size=(4 * COUNT, 3)).astype(np.float32)
    before = (pos + rng.normal(0, 0.1, pos.shape)).astype(np.float32)
    corners = np.arange(4 * COUNT, dtype=np.int32).reshape(COUNT, 4)
    corners[0, 1] = -1  # at the border of the cloth
    given = [wp.array(pos, dtype=wp.vec3), wp.array(before, dtype=wp.vec3), wp.array(corners, dtype=wp.int32)]
    given += [wp.array(rng.uniform(*span, COUNT).astype(np.float32)) for span in ((-2, 2), (0.5, 1))]
    force, hessian = wp.zeros(4 * COUNT, dtype=wp.vec3), wp.zeros(4 * COUNT, dtype=wp.mat33)
    wp.launch(ask, dim=4 * COUNT, inputs=[*given, force, hessian])
    return force.numpy(), hessian.numpy()


def test_bending_in_closed_form_is_the_solvers() -> None:
    for ours, theirs in zip(each_corner(hinges.bending_force_hessian), each_corner(hinges.PRINTED), strict=True):
        assert (ours[:4] == 0).all(), "no bending at a border"
        largest = np.abs(theirs).reshape(len(theirs), -1).max(1)
        assert (largest[4:] > 0).all()
        off = np.abs(ours - theirs).reshape(len(theirs), -1).max(1)
        assert (off <= 1e-4 * largest).all(), (off / largest)[4:].max()
