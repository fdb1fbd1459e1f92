"""Where a posed body meets itself: belly on thigh, thigh on thigh, calf on thigh (`toile-drape/src/folds.rs`).

Cloth cannot lie in a fold that leaves no room for it; the server's resolve lifts it out. World space, metres.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody
from garment.binding import ARM_PARTS, LEG_PARTS, limb_weights

Floats = NDArray[np.float64]

#: Surfaces further apart than this do not pinch cloth.
REACH = 0.04
#: Cosine of the normals of surfaces that face each other, at most; the resolve takes open creases for folds too.
OPPOSED = -0.1
#: Least gap between two surfaces that leaves room for cloth.
ROOM = 0.012
#: Height of the reference body's chest, above which nothing meets a thigh.
CHEST = 1.25
TRUNK, THIGH_LEFT, THIGH_RIGHT, CALF_LEFT, CALF_RIGHT = range(5)
PAIRS = ((TRUNK, THIGH_LEFT), (TRUNK, THIGH_RIGHT), (THIGH_LEFT, THIGH_RIGHT), (THIGH_LEFT, CALF_LEFT),
         (THIGH_RIGHT, CALF_RIGHT))  # fmt: skip


@lru_cache(1)
def body_parts() -> NDArray[np.int64]:
    """Part of every body vertex, (V,); -1 for arms, head and feet."""
    body = AnnyBody.load()
    names = [body.joint_names[j] for j in body.garment_joints]
    skin = body.garment_skin
    thigh, calf, foot = (limb_weights(skin, names, p) for p in (LEG_PARTS[:2], LEG_PARTS[2:4], LEG_PARTS[4:]))
    parts = np.full(len(skin), TRUNK)
    for side, (upper, lower) in enumerate(((THIGH_LEFT, CALF_LEFT), (THIGH_RIGHT, CALF_RIGHT))):
        leg = thigh[:, side] + calf[:, side] > 0.5
        parts[leg] = np.where(thigh[leg, side] > calf[leg, side], upper, lower)
    apart = (foot.sum(1) > 0.5) | (limb_weights(skin, names, ARM_PARTS).sum(1) >= 0.6)
    parts[apart | (body.shape().apose_vertices[:, 1] >= CHEST)] = -1
    return parts


def pinched(vertices: Floats, normals: Floats) -> NDArray[np.bool_]:
    """Body vertices (V,) that another part faces so near that no cloth fits between."""
    parts, out = body_parts(), np.zeros(len(vertices), bool)
    for pair in PAIRS:
        for here, there in (pair, pair[::-1]):
            a, b = np.flatnonzero(parts == here), np.flatnonzero(parts == there)
            near, hit = cKDTree(vertices[b]).query(vertices[a], distance_upper_bound=REACH)
            a, other = a[np.isfinite(near)], b[hit[np.isfinite(near)]]
            opposed = (normals[a] * normals[other]).sum(1) < OPPOSED
            gap = ((vertices[other] - vertices[a]) * normals[a]).sum(1)
            out[a[opposed & (gap < ROOM)]] = True
    return out
