"""Soft folds: band-limited waves that run as cloth creases on trunk, sleeves and legs."""

from __future__ import annotations

import numpy as np

from . import fields as fl
from .body_fields import BodyFields, arm_coordinates
from .marching import Field
from .mesh import Array

WAVES = 5


def _waves(seed: int, axes: Array, wavelengths: tuple[float, float]) -> Field:
    """Sum of warped sine waves of unit amplitude whose directions scatter about `axes` weights (3,)."""
    rng = np.random.default_rng([seed, 11])
    directions = rng.normal(size=(WAVES, 3)) * axes
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    numbers = 2 * np.pi * directions / rng.uniform(*wavelengths, (WAVES, 1))
    bends = rng.normal(size=(WAVES, 3)) * 2 * np.pi / 0.35
    phases, turns = rng.uniform(0, 2 * np.pi, (2, WAVES))

    def field(p: Array) -> Array:
        # Left and right differ, as on a worn garment.
        side = 1.9 * (p[:, :1] > 0)
        return np.sin(p @ numbers.T + phases + side + 0.8 * np.sin(p @ bends.T + turns)).sum(1) / np.sqrt(WAVES)

    return field


def _bump(x: Array, centre: float, width: float) -> Array:
    return np.exp(-(((x - centre) / width) ** 2))


def on_trunk(volume: Field, depth: float, seed: int) -> Field:
    """Upright folds below the chest."""
    rng_waves = _waves(seed, np.array([1.0, 0.45, 1.0]), (0.10, 0.22))

    def field(p: Array) -> Array:
        # The plane x = 0 has no seam: the wave's two halves meet there with equal weight zero.
        near_middle = fl.ramp(np.abs(p[:, 0]), 0.0, 0.05)
        strength = fl.ramp(-p[:, 1], -1.40, -1.22) * near_middle
        return volume(p) - depth * strength * rng_waves(p)

    return field


def on_legs(volume: Field, depth: float, seed: int) -> Field:
    """Creases across the knee and above the shoe, radiating from the crotch."""
    waves = _waves(seed + 1, np.array([0.5, 1.0, 0.5]), (0.07, 0.14))

    def field(p: Array) -> Array:
        y = p[:, 1]
        strength = 0.25 + 0.75 * _bump(y, 0.52, 0.10) + 0.9 * _bump(y, 0.14, 0.09) + 0.5 * _bump(y, 0.82, 0.06)
        strength = strength * fl.ramp(-y, -1.0, -0.9) * fl.ramp(np.abs(p[:, 0]), 0.0, 0.05)
        return volume(p) - depth * strength * waves(p)

    return field


def on_sleeves(volume: Field, body: BodyFields, depth: float, seed: int) -> Field:
    """Creases across the elbow and above the cuff."""
    waves = _waves(seed + 2, np.array([1.0, 1.0, 0.7]), (0.06, 0.12))

    def field(p: Array) -> Array:
        along, _ = arm_coordinates(p, body.arm)
        strength = 0.35 + 0.8 * _bump(along, 0.29, 0.09) + 0.5 * _bump(along, 0.47, 0.05)
        return volume(p) - depth * strength * fl.ramp(along, 0.06, 0.16) * waves(p)

    return field
