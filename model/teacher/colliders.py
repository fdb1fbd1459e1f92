"""Which part of the body cloth collides with in a simulation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody
from garment.binding import garment_joint_names

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]

#: Upwards from the hand; a part counts where most of a vertex's skin weight is on it.
ARM = (("upperarm01", "upperarm02"), ("lowerarm01", "lowerarm02", "wrist"))
#: Share of the cloth that lies nearest to a part of an arm that is in a sleeve.
SLEEVE = 0.005


def touched(rest: Floats, skin: Floats, body: AnnyBody) -> Ints:
    """Triangles (F, 3) of the body without arms that are in no sleeve.

    As in the service, cloth keeps its place where a bare arm passes through it. rest (N, 3), skin (V, 3): A-pose.
    """
    near = cKDTree(skin).query(rest)[1]
    bare = np.zeros(len(skin), bool)
    names = garment_joint_names()
    for side in (".L", ".R"):
        for part in ARM:
            joints = [names.index(p + side) for p in part]
            mine = body.garment_skin[:, joints].sum(1) > 0.5
            bare |= mine & (mine[near].mean() < SLEEVE)
    return body.triangles[~bare[body.triangles].any(1)].astype(np.int64)
