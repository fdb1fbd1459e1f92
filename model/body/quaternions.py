"""Unit quaternions, xyzw, in numpy. Products compose right to left, as matrices do."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
X, Y, Z = np.eye(3)


def multiply(*quaternions: ArrayLike) -> Array:
    """Product of quaternions (4,), leftmost applied last."""
    out = IDENTITY
    for q in quaternions:
        q = np.asarray(q, dtype=float)
        xyz = out[3] * q[:3] + q[3] * out[:3] + np.cross(out[:3], q[:3])
        out = np.append(xyz, out[3] * q[3] - out[:3] @ q[:3])
    return out


def inverse(q: ArrayLike) -> Array:
    return np.asarray(q, dtype=float) * [-1, -1, -1, 1]


def about(axis: ArrayLike, degrees: float) -> Array:
    """Rotation about an axis (3,) of any length by an angle in degrees."""
    axis = np.asarray(axis, dtype=float)
    half_angle = np.radians(degrees) / 2
    return np.append(axis / np.linalg.norm(axis) * np.sin(half_angle), np.cos(half_angle))


def half(q: ArrayLike) -> Array:
    """The rotation halfway from identity to q, the short way round (slerp at 1/2)."""
    q = np.asarray(q, dtype=float) * (1.0 if q[3] >= 0 else -1.0)
    out = q + IDENTITY
    return out / np.linalg.norm(out)


def swing_twist(q: ArrayLike, axis: Array) -> tuple[Array, Array]:
    """q = swing * twist, the twist about the unit axis (3,); no twist where it is undefined."""
    q = np.asarray(q, dtype=float)
    twist = np.append(axis * (q[:3] @ axis), q[3])
    length = np.linalg.norm(twist)
    twist = twist / length if length > 1e-9 else IDENTITY
    return multiply(q, inverse(twist)), twist


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Rotate a vector (3,)."""
    return to_matrix(q) @ np.asarray(v, dtype=float)


def to_matrix(q: ArrayLike) -> Array:
    x, y, z, w = np.asarray(q, dtype=float)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def from_matrix(m: Array) -> Array:
    """Quaternion with w >= 0 of a rotation matrix (3, 3), by the largest component (Shepperd 1978)."""
    trace = np.trace(m)
    squares = np.append(np.diag(m) * 2 - trace, trace) + 1
    k = int(np.argmax(squares))
    if k == 3:
        q = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]])
    else:
        i, j = (k + 1) % 3, (k + 2) % 3
        q = np.zeros(4)
        q[k], q[i], q[j], q[3] = squares[k], m[i, k] + m[k, i], m[j, k] + m[k, j], m[j, i] - m[i, j]
    q /= np.linalg.norm(q)
    return q if q[3] >= 0 else -q
