"""The weight of cloth beyond what its rest pose hangs in, as the losses have it (`energies.weight_change`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fabric import Fabric
from garment.graph import mesh_edges

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]


def pull(rest: Floats, skinned: Floats, triangles: Ints, distance: Floats) -> Floats:
    """Acceleration of each vertex, (N, 3) m/s2: gravity less what the skin under the rest pose goes on bearing.

    rest and skinned (N, 3): in the A-pose and where plain skinning puts it; distance (N,) m to the skin at rest.
    """
    up = turns(rest, skinned, triangles)[:, :, 1]
    borne = np.exp(-np.maximum(distance, 0) / Fabric.hang) * np.maximum(up[:, 1], 0)
    return -Fabric.gravity * (np.array([0.0, 1.0, 0.0]) - borne[:, None] * up)


def turns(rest: Floats, posed: Floats, triangles: Ints) -> Floats:
    """How the cloth around each vertex is turned, rotations (N, 3, 3) that fit the edges within two rings (Kabsch)."""
    a, b = mesh_edges(triangles).T
    before, after = rest[b] - rest[a], posed[b] - posed[a]
    outer = after[:, :, None] * before[:, None, :] / np.maximum((before**2).sum(1), 1e-12)[:, None, None]
    ring = _around(outer, outer, a, b, len(rest))
    u, _, v = np.linalg.svd(ring + _around(ring[b], ring[a], a, b, len(rest)))
    u[:, :, 2] *= np.sign(np.linalg.det(u @ v))[:, None]
    return u @ v


def _around(at_a: Floats, at_b: Floats, a: Ints, b: Ints, count: int) -> Floats:
    """Sums over the edges (a, b) of a value for each end, (count, 3, 3)."""
    out = np.zeros((count, 3, 3))
    np.add.at(out, a, at_a)
    np.add.at(out, b, at_b)
    return out
