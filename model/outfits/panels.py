"""The front and the back of a top laid flat, as a tailor cuts them: pattern space (Jin et al. 2020, section 3)."""

from __future__ import annotations

import numpy as np

from garment.cloth_image import Panel
from garment.flat import flattened

from . import fields as fl
from .body_fields import BodyFields
from .mesh import Array, GarmentMesh, Index, components, edges_of
from .uv import centre

#: Ears that are cut lay others bare.
EAR_PASSES = 4


def front_and_back(garment: GarmentMesh, body: BodyFields) -> tuple[Panel, Panel]:
    """A top with or without sleeves cut along its sides and over shoulders and arms.

    Raises ValueError where a half is not one piece.
    """
    facing = _without_ears(_facing_forward(garment.vertices[garment.triangles].mean(1), body), garment.triangles)
    one, two = (_panel(garment, facing == side, 1.0 if side else -1.0) for side in (True, False))
    return one, two


def _facing_forward(p: Array, body: BodyFields) -> np.ndarray:
    """Whether points (N, 3) lie before the middle of the trunk, or before the axis of their upper arm."""
    trunk = p[:, 2] > centre(body.trunk, p[:, 1])[:, 1]
    shoulder, elbow = body.arm[0], body.arm[1]
    along = np.clip((np.abs(p[:, 0]) - shoulder[0]) / (elbow[0] - shoulder[0]), 0, 1)
    arm = p[:, 2] > shoulder[2] + along * (elbow[2] - shoulder[2])
    return np.where((fl.armhole_seam(body)(p) > 0) & (p[:, 1] > 0.9), arm, trunk)


def _without_ears(facing: np.ndarray, triangles: Index) -> np.ndarray:
    """The same with triangles that hang on their panel by one side handed to the other: laid flat, they overlap."""
    owners = edges_of(triangles)[1]
    for giver in [True, False] * EAR_PASSES:
        forward, uses = (np.bincount(owners.ravel(), w, owners.max() + 1) for w in (np.repeat(facing, 3), None))
        others = np.where(facing[:, None], uses[owners] - forward[owners], forward[owners]).sum(1)
        # One panel at a time, or two ears side by side would change places.
        facing = facing ^ ((others >= 2) & (facing == giver))
    return facing


def _panel(garment: GarmentMesh, mine: np.ndarray, facing: float) -> Panel:
    triangles = garment.triangles[mine]
    pieces = len(np.unique(components(triangles, len(garment.vertices))))
    if pieces != 1:
        raise ValueError(f"half of the garment falls into {pieces} pieces: its seams cannot be told")
    vertices, local = np.unique(triangles, return_inverse=True)
    local, rest = local.reshape(-1, 3), garment.vertices[vertices]
    return Panel(vertices, local, _upright(flattened(rest, local), rest[:, :2] * [facing, 1.0]))


def _upright(places: Array, seen: Array) -> Array:
    """Turned to what is seen of it, (P, 2) both, about its middle."""
    places, seen = places - places.mean(0), seen - seen.mean(0)
    across = seen.T @ places
    angle = np.arctan2(across[1, 0] - across[0, 1], across[0, 0] + across[1, 1])
    cos, sin = np.cos(angle), np.sin(angle)
    return places @ np.array([[cos, sin], [-sin, cos]])


def patches(panels: list[Panel], garment: GarmentMesh, body: BodyFields) -> list[Panel]:
    """Panels of a top divided by a cage: sleeves, and left and right of the trunk above and below the waist."""
    return [part for panel in panels for part in _divided(panel, _patch(panel, garment, body))]


def _patch(panel: Panel, garment: GarmentMesh, body: BodyFields) -> np.ndarray:
    """Which patch each triangle of a panel belongs to."""
    p = garment.vertices[panel.vertices][panel.triangles].mean(1)
    sleeve = (fl.armhole_seam(body)(p) > 0) & (p[:, 1] > 0.9)
    middle = garment.vertices[:, 1].min() * 0.5 + p[~sleeve, 1].max() * 0.5
    return 3 * (p[:, 0] > 0) + np.where(sleeve, 2, p[:, 1] > middle)


def _divided(panel: Panel, patch: np.ndarray) -> list[Panel]:
    out = []
    for code in np.unique(patch):
        used, local = np.unique(panel.triangles[patch == code], return_inverse=True)
        out.append(Panel(panel.vertices[used], local.reshape(-1, 3), panel.places[used]))
    return out
