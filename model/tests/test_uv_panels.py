"""UVs as a sewing pattern, and those that are none."""

from __future__ import annotations

import numpy as np
import pytest

from garment.uv_panels import MOST, UnusableUVs, uv_panels

Arrays = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def sheet(side: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """A flat square of 0.4 m before the body: vertices (N, 3) and triangles."""
    x, y = np.meshgrid(np.linspace(0, 0.4, side), np.linspace(0, 0.4, side))
    corner = np.array([[r * side + c for c in range(side - 1)] for r in range(side - 1)]).ravel()
    triangles = np.concatenate(
        [np.stack([corner, corner + 1, corner + side], 1), np.stack([corner + 1, corner + side + 1, corner + side], 1)]
    )
    return np.stack([x.ravel(), 1 + y.ravel(), np.full(x.size, 0.2)], 1), triangles


def two_panels() -> Arrays:
    """Two sheets that share no vertex, drawn one vertex each, their UVs in quarters of the texture."""
    v, t = sheet()
    vertices = np.concatenate([v, v - [0, 0, 0.4]])
    uvs = np.concatenate([v[:, :2] - [0, 1], v[:, :2] - [-0.5, 1]])
    return vertices, np.arange(len(vertices)), np.concatenate([t, t[:, ::-1] + len(v)]), uvs


def test_islands_become_panels_in_metres_whatever_their_scale() -> None:
    vertices, drawn, triangles, uvs = two_panels()
    uvs[len(uvs) // 2 :] *= 0.1
    panels = uv_panels(vertices, drawn, triangles, uvs)
    assert [len(p.vertices) for p in panels] == [36, 36]
    assert np.unique(np.concatenate([p.vertices for p in panels])).size == len(vertices)
    for panel in panels:
        np.testing.assert_allclose(np.ptp(panel.places, axis=0), 0.4, rtol=1e-6)
        a, b, c = panel.places[panel.triangles].transpose(1, 0, 2)
        (p, q) = (b - a, c - a)
        assert (p[:, 0] * q[:, 1] > p[:, 1] * q[:, 0]).all(), "seen from outside"


def test_a_tube_cut_open_is_one_panel_with_its_seam_twice() -> None:
    v, t = sheet()
    turn = 2 * np.pi * v[:, 0] / 0.4
    tube = np.stack([np.cos(turn) * 0.4 / 2 / np.pi, v[:, 1], np.sin(turn) * 0.4 / 2 / np.pi], 1)
    first, last = np.arange(0, 36, 6), np.arange(5, 36, 6)
    drawn = np.arange(36)
    drawn[last] = first
    (panel,) = uv_panels(tube, drawn, t, v[:, :2])
    assert len(panel.vertices) == 36
    assert len(np.unique(panel.vertices)) == 30


def without(uvs: np.ndarray) -> np.ndarray:
    return uvs[:0]


def on_a_line(uvs: np.ndarray) -> np.ndarray:
    return uvs * [1, 0]


def folded(uvs: np.ndarray) -> np.ndarray:
    return np.stack([np.abs(uvs[:, 0] - 0.2), uvs[:, 1]], 1)


def squeezed(uvs: np.ndarray) -> np.ndarray:
    return uvs**6


def rolled(uvs: np.ndarray) -> np.ndarray:
    """Around a circle one and a half times."""
    turn = 3 * np.pi * uvs[:, 0] / 0.4
    return np.stack([np.cos(turn), np.sin(turn)], 1) * (1 + uvs[:, 1:])


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (without, "no UVs"),
        (on_a_line, "no area"),
        (folded, "folded over"),
        (squeezed, "no pattern"),
        (rolled, "lies over"),
    ],
)
def test_uvs_that_are_no_pattern_are_refused_with_what_is_wrong(spoil, says: str) -> None:  # noqa: ANN001
    v, t = sheet(40)
    with pytest.raises(UnusableUVs, match=says):
        uv_panels(v, np.arange(len(v)), t, spoil(v[:, :2] - [0, 1]))


def test_too_many_islands_are_refused() -> None:
    v, t = sheet()
    count = MOST + 1
    vertices = np.concatenate([v + np.array([0, 0, k]) for k in range(count)])
    triangles = np.concatenate([t + k * len(v) for k in range(count)])
    with pytest.raises(UnusableUVs, match=f"{count} islands"):
        uv_panels(vertices, np.arange(len(vertices)), triangles, vertices[:, :2])
