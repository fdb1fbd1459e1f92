"""Shapes whose rest is known."""

from __future__ import annotations

import numpy as np

from fabric import Fabric

#: m/s2
DOWN = np.array([0.0, -Fabric.gravity, 0.0])


def sheet(count: int, side: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    """A level square of count x count vertices, facing up."""
    at = np.linspace(-side / 2, side / 2, count)
    x, z = np.meshgrid(at, at, indexing="ij")
    v = np.stack([x.ravel(), np.full(count**2, height), z.ravel()], 1)
    first = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    a, b, c, d = first, first + 1, first + count + 1, first + count
    return v, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def ball(radius: float) -> tuple[np.ndarray, np.ndarray]:
    """A sphere of 32 x 16 faces about the origin, facing out."""
    turn, fall = np.meshgrid(2 * np.pi * np.arange(32) / 32, np.pi * np.arange(17) / 16, indexing="ij")
    v = np.stack([np.sin(fall) * np.cos(turn), np.cos(fall), np.sin(fall) * np.sin(turn)], 2).reshape(-1, 3)
    first = (np.arange(32)[:, None] * 17 + np.arange(16)).ravel()
    beside = (first + 17) % len(v)
    t = np.concatenate([np.stack([first, beside, first + 1], 1), np.stack([beside, beside + 1, first + 1], 1)])
    return radius * v, t
