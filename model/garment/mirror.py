"""Cloth and bodies seen in a mirror: a symmetric garment's drape in one pose is another's in the mirrored pose.

Meshes need not be symmetric: what stands opposite of a vertex is read from the triangle there.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from garment.binding import garment_joint_names
from garment.embedding import Embedding, Skin

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]

#: Of a point, in the plane between left and right.
ACROSS = torch.tensor([-1.0, 1.0, 1.0])


def opposite(vertices: Floats, triangles: Ints) -> Embedding:
    """Where the mirror images of a garment's vertices (N, 3), rest space, lie on the garment itself."""
    everywhere = [np.ones(len(vertices), bool)]
    limb = np.zeros(len(vertices), np.int64)
    return Skin(vertices, triangles, everywhere).nearest(vertices * ACROSS.numpy(), limb)


def asymmetry(vertices: Floats, there: Embedding) -> Floats:
    """How far each mirror image (N, 3) is from the garment, (N,), metres."""
    return np.linalg.norm(there.places(vertices) - vertices * ACROSS.numpy(), axis=1)


def mirrored_cloth(x: Tensor, there: Embedding) -> Tensor:
    """Drapes (D, N, 3) world in a mirror, at the vertices."""
    weight = torch.as_tensor(there.weight, dtype=x.dtype)[..., None]
    return (weight * x[:, torch.as_tensor(there.corners)]).sum(2) * ACROSS


def mirrored_joints(transforms: Tensor) -> Tensor:
    """World from A-pose (D, 36, 3, 4) of the garment joints of mirrored poses: left for right."""
    names = garment_joint_names()
    other = [names.index(_other(name)) for name in names]
    return transforms[:, other] * ACROSS[:, None] * torch.cat([ACROSS, torch.ones(1)])


def _other(name: str) -> str:
    side = {".L": ".R", ".R": ".L"}.get(name[-2:])
    return name[:-2] + side if side else name
