"""Texture coordinates in metres of cloth, cut like pattern pieces: front, back, sleeves and legs."""

from __future__ import annotations

import numpy as np

from . import fields as fl
from .body_fields import ANGLES, OUTLINE_LOW, OUTLINE_STEP, BodyFields, Outlines, arm_coordinates
from .mesh import Array, GarmentMesh, Index
from .pattern import Pattern

FRONT, BACK, SLEEVE_LEFT, SLEEVE_RIGHT, LEG_LEFT, LEG_RIGHT = range(6)


def unwrap(garment: GarmentMesh, pattern: Pattern, body: BodyFields) -> None:
    """Give a garment `uv` (C, 2), metres, and `uv_triangles` (M, 3); cuts lie where a tailor has seams."""
    v, t = garment.vertices, garment.triangles
    chart = _charts(v[t].mean(1), pattern, body)
    corner_chart = np.repeat(chart, 3)
    corners = t.ravel()
    uv = np.zeros((len(corners), 2))
    for k in np.unique(chart):
        mine = corner_chart == k
        uv[mine] = _coordinates(v[corners[mine]], int(k), body)
    uv = _close_wraps(uv.reshape(-1, 3, 2), chart).reshape(-1, 2)
    keys = np.column_stack([corners, corner_chart, np.round(uv * 1e5)])
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    garment.uv, garment.uv_triangles = uv[first], inverse.reshape(-1, 3)


def _charts(centroids: Array, pattern: Pattern, body: BodyFields) -> Index:
    chart = np.where(centroids[:, 2] > centre(body.trunk, centroids[:, 1])[:, 1], FRONT, BACK)
    if pattern.sleeve is not None:
        on_arm = (fl.armhole_seam(body)(centroids) > 0) & (centroids[:, 1] > 0.9)
        chart[on_arm] = np.where(centroids[on_arm, 0] > 0, SLEEVE_LEFT, SLEEVE_RIGHT)
    if pattern.thigh is not None:
        on_leg = centroids[:, 1] < fl.CROTCH - pattern.rise
        chart[on_leg] = np.where(centroids[on_leg, 0] > 0, LEG_LEFT, LEG_RIGHT)
    return chart


def centre(outlines: Outlines, y: Array) -> Array:
    """x and z of the middle of the outlines at heights y (N,), (N, 2). Metres."""
    row = np.clip(np.round((y - OUTLINE_LOW) / OUTLINE_STEP).astype(int), 0, len(outlines.centre) - 1)
    return outlines.centre[row]


def _coordinates(p: Array, chart: int, body: BodyFields) -> Array:
    if chart in (FRONT, BACK):
        return np.stack([_arc(p, body.trunk, 1.0 if chart == FRONT else -1.0), p[:, 1]], 1)
    if chart in (SLEEVE_LEFT, SLEEVE_RIGHT):
        along, _ = arm_coordinates(p, body.arm)
        turn, radius = _around_arm(p, body, along)
        return np.stack([turn * radius, -along], 1)
    offset = np.abs(p[:, 0]) - centre(body.leg, p[:, 1])[:, 0], p[:, 2] - centre(body.leg, p[:, 1])[:, 1]
    return np.stack([np.arctan2(offset[1], offset[0]) * 0.11, p[:, 1]], 1)


def _arc(p: Array, outlines: Outlines, facing: float) -> Array:
    """Length along the horizontal outline from the centre front (facing 1) or centre back (-1)."""
    middle = centre(outlines, p[:, 1])
    x, z = p[:, 0] - middle[:, 0], (p[:, 2] - middle[:, 1]) * facing
    row = np.clip(np.round((p[:, 1] - OUTLINE_LOW) / OUTLINE_STEP).astype(int), 0, len(outlines.radius) - 1)
    radius = outlines.radius if facing > 0 else outlines.radius[:, -np.arange(ANGLES) % ANGLES]
    step = np.hypot(radius, np.gradient(radius, axis=1) * ANGLES / (2 * np.pi)) * 2 * np.pi / ANGLES
    length = np.cumsum(step, 1) - step / 2
    column = np.mod(np.arctan2(z, x), 2 * np.pi) * ANGLES / (2 * np.pi)
    column = np.where(column > 0.75 * ANGLES, 0.0, column)
    k = np.minimum(column.astype(int), ANGLES - 2)
    t = column - k
    at = length[row, k] * (1 - t) + length[row, k + 1] * t
    body_radius = radius[row, k] * (1 - t) + radius[row, k + 1] * t
    return -(at - length[row, ANGLES // 4]) * np.hypot(x, z) / body_radius


def _around_arm(p: Array, body: BodyFields, along: Array) -> tuple[Array, float]:
    """Angle about the arm, cut under it, and a typical sleeve radius."""
    q = np.stack([np.abs(p[:, 0]), p[:, 1], p[:, 2]], 1)
    first = np.linalg.norm(body.arm[1] - body.arm[0])
    bend = fl.ramp(along, first - 0.06, first + 0.06)[:, None]
    axes = [(body.arm[k + 1] - body.arm[k]) / np.linalg.norm(body.arm[k + 1] - body.arm[k]) for k in range(2)]
    direction = axes[0] * (1 - bend) + axes[1] * bend
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    side = np.cross(direction, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, direction)
    foot = body.arm[0] + np.minimum(along, first)[:, None] * axes[0] + np.maximum(along - first, 0)[:, None] * axes[1]
    offset = q - foot
    return np.arctan2((offset * side).sum(1), (offset * up).sum(1)), 0.075


def _close_wraps(uv: Array, chart: Index) -> Array:
    """Triangles over the cut of a sleeve or leg: move corners by a full turn so that the triangle stays small."""
    period = np.select([chart >= LEG_LEFT, chart >= SLEEVE_LEFT], [2 * np.pi * 0.11, 2 * np.pi * 0.075], np.inf)
    u = uv[..., 0]
    gap = u.max(1, keepdims=True) - u
    uv[..., 0] = np.where(gap > 0.5 * period[:, None], u + np.where(np.isfinite(period), period, 0)[:, None], u)
    return uv


def planar(garment: GarmentMesh) -> None:
    """Texture coordinates of small pieces by projection on the x-y plane, metres."""
    garment.uv = garment.vertices[:, :2].copy()
    garment.uv_triangles = garment.triangles
