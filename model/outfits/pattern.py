"""A pattern: the measurements of one garment, and the level set they describe."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from . import fields as fl
from . import wrinkles
from .body_fields import BodyFields
from .marching import Field
from .mesh import Array
from .remesh import Surface

ARM_LENGTH = 0.54


@dataclass(frozen=True)
class Pattern:
    """Measurements in metres; heights are y in rest space, eases are distances from the body's outline."""

    name: str
    kind: str
    top: float | None = None  # height of the waistband; None for garments that hang from the shoulders
    hem: float = 0.90
    skin: float = 0.006  # least distance from the skin
    chest: float = 0.02
    waist: float = 0.02
    hip: float = 0.02
    looseness: float = 0.7  # 0 follows the body, 1 hangs straight from the widest place
    neck: tuple[float, float, float, float, float] = (1.50, 1.545, 0.085, 2.2, 2.2)
    sleeve: float | None = None  # arc length from the shoulder; None is sleeveless
    sleeve_ease: float = 0.02
    cuff_ease: float = 0.02
    strap: float = 0.03  # inset of a sleeveless armhole
    armhole: float = 0.02  # depth of a sleeveless armhole below the armpit
    skirt_from: float | None = None  # height at which a skirt starts to fall
    flare: float = 0.0  # outward metres per metre of fall
    folds: int = 0
    fold_depth: float = 0.0
    fold_phase: float = 0.0
    thigh: float | None = None  # ease at the thigh; None has no legs
    leg_hem: float = 0.03
    rise: float = 0.015  # how far the crotch seam hangs below the body
    opening: float | None = None  # half width of the front opening at the hem; None is closed
    hem_dip: float = 0.0  # how much lower the back hem is than the front
    cape: bool = False  # falls over the arms
    split: float | None = None  # height up to which a slit runs at the left side
    wrinkle: float = 0.0  # depth of soft folds
    wrinkle_seed: int = 1
    tucked: float | None = None  # height of the waistband that a tucked garment disappears into


@dataclass(frozen=True)
class Shape:
    """A pattern on a body: the surface, the box to search, and which points are legs or sleeves."""

    pattern: Pattern
    surface: Surface
    low: Array
    high: Array
    seam: Field | None = None  # zero where the sleeve meets the trunk

    def solid(self, gap: float) -> Field:
        """Volume that an outer layer must keep out of: the worn part of this garment, grown by `gap`."""
        return lambda p: fl.smooth_max(self.surface.f(p), self.surface.g(p), 0.01) - gap


def shape(pattern: Pattern, body: BodyFields, inner: list[Shape], gap: float = 0.005) -> Shape:
    """Surface of a pattern on a body, over the shapes worn beneath it."""
    parts = [lambda p: body.distance(p) - pattern.skin]
    if pattern.cape:
        parts.append(_cape(pattern, body))
    elif pattern.top is None or pattern.thigh is None:
        parts.append(wrinkles.on_trunk(_trunk(pattern, body), pattern.wrinkle, pattern.wrinkle_seed))
    if pattern.thigh is not None:
        parts.append(wrinkles.on_legs(_legs(pattern, body), pattern.wrinkle, pattern.wrinkle_seed))
    if pattern.sleeve is not None:
        parts.append(wrinkles.on_sleeves(_sleeves(pattern, body), body, pattern.wrinkle, pattern.wrinkle_seed))
    # A wide fillet would lift tight garments off the skin.
    fillet = float(np.clip(2 * pattern.chest, 0.008, 0.05))
    solids = [s.solid(gap) for s in inner]

    def f(p: Array) -> Array:
        out = parts[0](p)
        for part in parts[1:]:
            out = fl.smooth_min(out, part(p), fillet)
        for solid in solids:
            out = fl.smooth_min(out, solid(p), 0.008)
        return out

    seam = None if pattern.sleeve is None else fl.armhole_seam(body)
    return Shape(pattern, Surface(f, _trims(pattern, body)), *_box(pattern), seam)


def _trunk(pattern: Pattern, body: BodyFields) -> Field:
    """Torso (and skirt) as one hanging tube."""
    top = pattern.top or 1.50
    base = fl.outline_rows(body.trunk, 0.05, top)
    ease = fl.scale_by_height([(0.85, pattern.hip), (1.0, pattern.hip), (1.17, pattern.waist), (1.36, pattern.chest)])
    fitted = base + ease[:, None]
    loose = fl.hang(base + np.minimum(ease, pattern.chest)[:, None], 0.12)
    excess = pattern.looseness * np.maximum(loose - fitted, 0)
    if pattern.tucked is not None:
        free = fl.ramp(fl.HEIGHTS, pattern.tucked - 0.01, pattern.tucked + 0.10)[:, None]
        fitted = base + free * ease[:, None] + (1 - free) * (pattern.skin + 0.001)
        excess = excess * free
    radius = fitted + excess
    if pattern.skirt_from is not None:
        radius = _skirt(pattern, radius)
    if pattern.top is None:
        # Above the chest the shoulders carry the cloth, so the tube gives way to the offset skin.
        radius = radius - (0.25 * fl.ramp(fl.HEIGHTS, 1.34, 1.60))[:, None]
    volume = fl.tube(body.trunk.centre, np.maximum(radius, 0.005))
    if pattern.thigh is None:
        return volume
    return lambda p: fl.smooth_max(volume(p), 0.97 - p[:, 1], 0.05)


def _skirt(pattern: Pattern, radius: Array) -> Array:
    start = pattern.skirt_from
    below = start > fl.HEIGHTS
    falling = fl.hang(np.where((start + 0.01 > fl.HEIGHTS)[:, None], radius, 0), 0.10)
    falling = fl.taut(falling, pattern.hem, min(start, 0.94))
    drop = np.maximum(start - fl.HEIGHTS, 0)
    # The flare sets in gently, so that the skirt leaves the hip without a corner.
    flared = falling + (pattern.flare * drop * fl.ramp(drop, 0, 0.15))[:, None]
    wave = np.cos(pattern.folds * fl.THETA + pattern.fold_phase) + 0.35 * np.cos(
        (pattern.folds + 3) * fl.THETA + 2.1 * pattern.fold_phase
    )
    depth = pattern.fold_depth * fl.ramp(drop, 0.02, max(start - pattern.hem, 0.1))
    return np.where(below[:, None], flared + depth[:, None] * (wave + 0.6), radius)


def _cape(pattern: Pattern, body: BodyFields) -> Field:
    base = fl.hang(fl.outline_rows(body.cape, 1.17, 1.54), -0.05) + pattern.chest
    drop = np.maximum(1.45 - fl.HEIGHTS, 0)
    wave = np.cos(pattern.folds * fl.THETA + pattern.fold_phase)
    radius = base + (pattern.flare * drop)[:, None] + (pattern.fold_depth * fl.ramp(drop, 0, 0.4))[:, None] * wave
    radius = radius - (0.25 * fl.ramp(fl.HEIGHTS, 1.50, 1.60))[:, None]
    return fl.tube(body.cape.centre, np.maximum(radius, 0.005))


def _legs(pattern: Pattern, body: BodyFields) -> Field:
    """Seat and two trouser legs, parted by the middle plane."""
    crotch = fl.CROTCH - pattern.rise
    base = fl.outline_rows(body.leg, 0.10, 0.93)
    # The inner thigh gets less ease, so that the legs part early.
    inward = np.clip(-np.cos(fl.THETA), 0, 1)[None] * fl.ramp(fl.HEIGHTS, 0.45, 0.8)[:, None]
    ease = fl.scale_by_height(
        [(pattern.hem, pattern.leg_hem), (0.76, pattern.thigh), (0.92, min(pattern.thigh, pattern.hip))]
    )[:, None] * (1 - 0.6 * inward)
    fitted = base + ease
    slope = 0.05 + max(pattern.thigh - pattern.leg_hem, 0) / max(0.8 - pattern.hem, 0.1)
    loose = fl.hang(np.where((fl.HEIGHTS < 0.84)[:, None], fitted, 0), slope)
    leg = fl.tube(body.leg.centre, fitted + pattern.looseness * np.maximum(loose - fitted, 0), mirrored=True)
    top = pattern.top or 1.30
    seat_ease = fl.scale_by_height([(0.85, pattern.hip), (1.0, pattern.hip), (min(top, 1.17), pattern.waist)])
    lid = 1.12 if pattern.top is None else 2.0
    seat = fl.tube(body.trunk.centre, fl.outline_rows(body.trunk, 0.05, top) + seat_ease[:, None])

    def field(p: Array) -> Array:
        one_leg = fl.smooth_max(leg(p), 0.004 - np.abs(p[:, 0]), 0.006)
        one_leg = fl.smooth_max(one_leg, p[:, 1] - 0.95, 0.05)
        # The crotch seam is a U from front to back.
        forward = p[:, 2] - 0.03
        floor = crotch + np.where(forward > 0, 4.5, 3.0) * np.minimum(np.abs(forward), 0.14) ** 2
        trunk = fl.smooth_max(seat(p), np.maximum((floor - p[:, 1]) * 0.8, p[:, 1] - lid), 0.04)
        return fl.smooth_min(trunk, one_leg, 0.02)

    return field


def _sleeves(pattern: Pattern, body: BodyFields) -> Field:
    length = float(pattern.sleeve)
    stations = 0.02 * np.arange(len(body.arm_radius))
    wrist = 23
    needed = np.maximum.accumulate(body.arm_radius[wrist::-1])[::-1]
    needed = np.append(needed, np.full(len(stations) - len(needed), needed[-1]))
    # Over the shoulder joint the sleeve lies on; its ease starts below.
    ease = np.interp(stations, [0.0, 0.10, max(length, 0.14)], [0.0, pattern.sleeve_ease, pattern.cuff_ease])
    radii = needed + ease
    sag = 0.3 * float(ease[stations <= length].mean())
    return fl.sleeve(body, list(zip(stations, radii, strict=True)), sag)


def _trims(pattern: Pattern, body: BodyFields) -> Field:
    cuts = [_hem(pattern)]
    if pattern.top is not None:
        cuts.append(lambda p: p[:, 1] - pattern.top)
    else:
        front, back, width, *powers = pattern.neck
        cuts.append(fl.neckline(front, back, width, (powers[0], powers[1])))
        if pattern.sleeve is not None:
            cuts.append(fl.sleeve_end(body, pattern.sleeve))
        elif not pattern.cape:
            cuts.append(fl.armhole(pattern.strap, pattern.armhole))
    if pattern.opening is not None:
        cuts.append(_front_opening(pattern))
    return fl.any_of(*cuts)


def _hem(pattern: Pattern) -> Field:
    def field(p: Array) -> Array:
        cut = pattern.hem - pattern.hem_dip * fl.ramp(-p[:, 2], -0.15, 0.25) - p[:, 1]
        if pattern.split is not None:
            slit = np.minimum(
                0.004 + 0.10 * (pattern.split - p[:, 1]) - np.abs(p[:, 2] - 0.02), pattern.split - p[:, 1]
            )
            cut = np.maximum(cut, np.minimum(slit, p[:, 0] - 0.05))
        if pattern.sleeve is None or pattern.hem < 0.8:
            return cut
        return fl.smooth_min(cut, -fl.arm_side(p), 0.01)

    return field


def _front_opening(pattern: Pattern) -> Field:
    def field(p: Array) -> Array:
        half = pattern.opening * (0.45 + 0.55 * fl.ramp(-p[:, 1], -1.45, -pattern.hem))
        return np.minimum(half - np.abs(p[:, 0]), p[:, 2] - 0.02)

    return field


def _box(pattern: Pattern) -> tuple[Array, Array]:
    reach = 0.30 + pattern.flare * max((pattern.skirt_from or 1.0) - pattern.hem, 0) + 2 * pattern.fold_depth
    if pattern.sleeve is not None:
        reach = max(reach, 0.30 + 0.62 * pattern.sleeve)
    if pattern.cape:
        reach = 0.75
    depth = 0.30 + pattern.flare * max((pattern.skirt_from or 1.0) - pattern.hem, 0) + 2 * pattern.fold_depth
    back = min(depth, 0.30 if pattern.skirt_from is None and not pattern.cape else 0.9)
    top = pattern.top + 0.03 if pattern.top is not None else 1.68
    low = np.array([-reach, pattern.hem - pattern.hem_dip - 0.03, -back])
    return low, np.array([reach, top, max(depth, 0.34)])


def resized(pattern: Pattern, size: float) -> Pattern:
    """The same pattern with every ease multiplied by `size`."""
    grown = {k: getattr(pattern, k) * size for k in ("chest", "waist", "hip", "sleeve_ease", "cuff_ease", "leg_hem")}
    return replace(pattern, **grown, thigh=None if pattern.thigh is None else pattern.thigh * size)
