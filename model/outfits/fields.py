"""Building blocks of garment fields: smooth unions, tubes about a centre line, sleeves, openings.

A field maps points (N, 3) in rest space to signed distances in metres, negative inside the clothed volume.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import map_coordinates

from .body_fields import ANGLES, OUTLINE_COUNT, OUTLINE_LOW, OUTLINE_STEP, BodyFields, Outlines, arm_coordinates
from .marching import Field
from .mesh import Array

HEIGHTS = OUTLINE_LOW + OUTLINE_STEP * np.arange(OUTLINE_COUNT)
THETA = np.arange(ANGLES) * 2 * np.pi / ANGLES
CROTCH = 0.885
ARMPIT = np.array([0.160, 1.330])
BISECTOR = np.array([0.936, 0.352])  # unit normal, in x-y, of the plane between flank and arm


def smooth_min(a: Array, b: Array, radius: float) -> Array:
    """Union of two volumes with a fillet of about `radius`."""
    h = np.maximum(radius - np.abs(a - b), 0)
    return np.minimum(a, b) - h * h / (4 * radius)


def smooth_max(a: Array, b: Array, radius: float) -> Array:
    """Intersection of two volumes with a rounded edge."""
    return -smooth_min(-a, -b, radius)


def ramp(x: Array, start: float, end: float) -> Array:
    """Smooth step from 0 at `start` to 1 at `end`."""
    t = np.clip((x - start) / (end - start), 0, 1)
    return t * t * (3 - 2 * t)


def hang(radius: Array, slope: float) -> Array:
    """Let cloth fall from the widest ring above; it may come in by `slope` per metre of height. (H, ANGLES)."""
    out = radius.copy()
    for row in range(len(out) - 2, -1, -1):
        out[row] = np.maximum(out[row], out[row + 1] - slope * OUTLINE_STEP)
    return out


def taut(radius: Array, low: float, high: float) -> Array:
    """Straight lines of fall between two heights: the concave majorant of each column over height."""
    rows = np.flatnonzero((low - OUTLINE_STEP <= HEIGHTS) & (high + OUTLINE_STEP >= HEIGHTS))
    out = radius.copy()
    for column in range(ANGLES):
        r = radius[rows, column]
        kept: list[int] = []
        for i in range(len(rows)):
            while len(kept) > 1 and (r[kept[-1]] - r[kept[-2]]) * (i - kept[-1]) <= (r[i] - r[kept[-1]]) * (
                kept[-1] - kept[-2]
            ):
                kept.pop()
            kept.append(i)
        out[rows, column] = np.interp(np.arange(len(rows)), kept, r[kept])
    return out


def tube(centre: Array, radius: Array, mirrored: bool = False) -> Field:
    """Volume with horizontal outlines `radius` (H, ANGLES) about `centre` (H, 2); `mirrored` folds x < 0 over."""
    wrapped = np.concatenate([radius, radius[:, :2]], 1)
    rise = np.gradient(radius, OUTLINE_STEP, axis=0)
    turn = (np.roll(radius, -1, 1) - np.roll(radius, 1, 1)) * ANGLES / (4 * np.pi) / np.maximum(radius, 0.02)
    steepness = np.sqrt(1 + np.minimum(rise**2 + turn**2, 9.0))
    steepness = np.concatenate([steepness, steepness[:, :2]], 1)

    def field(p: Array) -> Array:
        row = np.clip((p[:, 1] - OUTLINE_LOW) / OUTLINE_STEP, 0, OUTLINE_COUNT - 1.001)
        k = row.astype(int)
        t = (row - k)[:, None]
        middle = centre[k] * (1 - t) + centre[k + 1] * t
        x = (np.abs(p[:, 0]) if mirrored else p[:, 0]) - middle[:, 0]
        z = p[:, 2] - middle[:, 1]
        column = np.mod(np.arctan2(z, x), 2 * np.pi) * ANGLES / (2 * np.pi)
        at = np.stack([row, column])
        r = map_coordinates(wrapped, at, order=1, mode="nearest")
        return (np.hypot(x, z) - r) / map_coordinates(steepness, at, order=1, mode="nearest")

    return field


def arm_side(p: Array) -> Array:
    """Distance to the plane between flank and arm, positive on the arm's side; below the hips it lets skirts flare."""
    side = (np.abs(p[:, 0]) - ARMPIT[0]) * BISECTOR[0] + (p[:, 1] - ARMPIT[1]) * BISECTOR[1]
    return side - 2.0 * np.maximum(1.02 - p[:, 1], 0)


def sleeve(body: BodyFields, radii: list[tuple[float, float]], sag: float) -> Field:
    """Tube along both arms; `radii` are (arc length from the shoulder, radius) in metres, `sag` lowers it."""
    stations, values = np.array(radii).T

    def field(p: Array) -> Array:
        raised = p + np.array([0.0, sag, 0.0])
        along, across = arm_coordinates(raised, body.arm)
        return smooth_max(across - np.interp(along, stations, values), -along - 0.03, 0.03)

    return field


def sleeve_end(body: BodyFields, length: float) -> Field:
    """Positive beyond the cuff at arc length `length`."""

    def field(p: Array) -> Array:
        along, _ = arm_coordinates(p, body.arm)
        return smooth_min(along - length, arm_side(p), 0.02)

    return field


def armhole_seam(body: BodyFields) -> Field:
    """Positive on the sleeve's side of the seam that joins it to the trunk."""

    def field(p: Array) -> Array:
        along, _ = arm_coordinates(p, body.arm)
        return smooth_min(along - 0.015, arm_side(p) - 0.006, 0.05)

    return field


def armhole(inset: float, depth: float) -> Field:
    """Positive off the shoulder of a sleeveless garment; `inset` narrows the strap, `depth` lowers the hole."""

    def field(p: Array) -> Array:
        x, y = np.abs(p[:, 0]), p[:, 1]
        cap = (x - 0.187 + inset) * 0.93 + (y - 1.47) * -0.37
        side = (x - ARMPIT[0]) * BISECTOR[0] + (y - ARMPIT[1] + depth) * BISECTOR[1] - 0.004
        side = side - 2.0 * np.maximum(1.02 - y, 0)
        return smooth_min(cap, side, 0.05)

    return field


def neckline(front: float, back: float, width: float, powers: tuple[float, float]) -> Field:
    """Positive above a neckline of given heights on the centre line, half width, and front and back curve powers."""

    def field(p: Array) -> Array:
        t = np.abs(p[:, 0]) / width
        side = max(1.565, back)
        # A stand collar is higher than its side and stays level beyond it, or it would cut the shoulders.
        low_front = front + (side - front) * np.minimum(t, 1.6 if front < side else 1.0) ** powers[0]
        low_back = back + (side - back) * np.minimum(t, 1.6 if back < side else 1.0) ** powers[1]
        mix = ramp(p[:, 2], -0.025, 0.055)
        line = np.minimum(low_back * (1 - mix) + low_front * mix, 1.62)
        slope = (side - front) / width * mix * powers[0]
        return (p[:, 1] - line) / np.sqrt(1 + np.minimum(slope, 2.0) ** 2)

    return field


def any_of(*fields: Field) -> Field:
    """Positive where any of the trims is positive."""

    def field(p: Array) -> Array:
        out = fields[0](p)
        for other in fields[1:]:
            out = smooth_max(out, other(p), 0.006)
        return out

    return field


def scale_by_height(stations: list[tuple[float, float]]) -> Array:
    """Values (H,) interpolated over (height, value) pairs, smoothly."""
    y, v = np.array(sorted(stations)).T
    values = np.interp(HEIGHTS, y, v)
    kernel = np.hanning(9) / np.hanning(9).sum()
    return np.convolve(np.pad(values, 4, mode="edge"), kernel, "valid")


def outline_rows(outlines: Outlines, low: float, high: float) -> Array:
    """Outline radii with everything outside [low, high] held at the end rows, (H, ANGLES)."""
    rows = np.clip(np.arange(OUTLINE_COUNT), np.searchsorted(HEIGHTS, low), np.searchsorted(HEIGHTS, high) - 1)
    return outlines.radius[rows]
