"""Measure shapes by the baked tapes: values in cm and kg, and how they change with the shape.

Points on tapes, and the coarse mesh of the volume, are linear in the shape coefficients, so both get a
basis of their own and a measurement costs a few hundred points, not the whole body.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from body.anny_body import AnnyBody

Array = NDArray[np.float64]
CM_PER_M = 100.0


def volume(vertices: Array, triangles: NDArray) -> float:
    """Volume inside a closed mesh by the divergence theorem, m3."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float(np.einsum("ta,ta->", a, np.cross(b, c)) / 6)


class Tape:
    """The baked measurements of a body."""

    def __init__(self, body: AnnyBody) -> None:
        self.entries: list[dict] = body.meta["measurements"]
        self.names = [m["name"] for m in self.entries]
        self.volume_fit: dict = body.meta["volume"]
        self.ranges, self.triangles = body.tape["measure_ranges"], body.tape["volume_triangles"]
        i, j = body.tape["measure_points"].T
        t = body.tape["measure_t"][:, None]
        lerp = lambda x: x[..., i, :] * (1 - t) + x[..., j, :] * t  # noqa: E731
        basis, template = body.shape_basis.astype(np.float64), body.template_vertices
        self.points, self.point_basis = lerp(template), lerp(basis)
        coarse = body.tape["volume_vertices"]
        self.coarse, self.coarse_basis = template[coarse], basis[:, coarse]

    def measure(self, coefficients: Array) -> Array:
        """All measurements (M,) of shape coefficients (K,), cm and kg."""
        return self.with_jacobian(coefficients)[0]

    def with_jacobian(self, coefficients: Array) -> tuple[Array, Array]:
        """Measurements (M,) and their derivatives by the coefficients (M, K), cm and kg."""
        points = self.points + np.tensordot(coefficients, self.point_basis, 1)
        values, rows = np.zeros(len(self.entries)), np.zeros((len(self.entries), len(coefficients)))
        for m, (entry, (start, end)) in enumerate(zip(self.entries, self.ranges, strict=True)):
            if entry["kind"] == "weight":
                values[m], rows[m] = self._weight(coefficients)
                continue
            value, gradient = LENGTHS[entry["kind"]](points[start:end])
            values[m] = value * CM_PER_M
            rows[m] = np.tensordot(self.point_basis[:, start:end], gradient, 2) * CM_PER_M
        return values, rows

    def _weight(self, coefficients: Array) -> tuple[float, Array]:
        vertices = self.coarse + np.tensordot(coefficients, self.coarse_basis, 1)
        a, b, c = (vertices[self.triangles[:, k]] for k in range(3))
        gradient = np.zeros_like(vertices)
        for k, cross in enumerate((np.cross(b, c), np.cross(c, a), np.cross(a, b))):
            np.add.at(gradient, self.triangles[:, k], cross / 6)
        fit = self.volume_fit
        kilograms = fit["density"] * (fit["scale"] * volume(vertices, self.triangles) + fit["offset"])
        return kilograms, fit["density"] * fit["scale"] * np.tensordot(self.coarse_basis, gradient, 2)


def polyline_length(points: Array) -> tuple[float, Array]:
    """Length of an open tape through points (P, 3), and its gradient by them."""
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    units = steps / lengths[:, None]
    gradient = np.zeros_like(points)
    gradient[1:] += units
    gradient[:-1] -= units
    return float(lengths.sum()), gradient


def ring_length(points: Array) -> tuple[float, Array]:
    """Length of a closed tape, and its gradient."""
    value, gradient = polyline_length(np.concatenate([points, points[:1]]))
    gradient[0] += gradient[-1]
    return value, gradient[:-1]


def height_above(points: Array) -> tuple[float, Array]:
    """How far the first point lies above the mean of the others, and its gradient."""
    gradient = np.zeros_like(points)
    gradient[0, 1], gradient[1:, 1] = 1, -1 / (len(points) - 1)
    return float((points * gradient).sum()), gradient


LENGTHS = {"ring": ring_length, "polyline": polyline_length, "height": height_above}
