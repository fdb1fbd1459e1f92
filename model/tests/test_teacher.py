"""What decides whether a simulated drape can be a target, without the simulator."""

from __future__ import annotations

import numpy as np

from garment.waistbands import held
from teacher.checks import Judged, Limits, crossing, judge
from teacher.weight import pull, turns


def tube(around: int, rows: int, radius: float, top: float) -> tuple[np.ndarray, np.ndarray]:
    """A tube of rows 5 cm apart, from the top down: vertices and triangles."""
    angle = 2 * np.pi * np.arange(around) / around
    ring = np.stack([radius * np.cos(angle), np.zeros(around), radius * np.sin(angle)], 1)
    v = np.concatenate([ring + np.array([0, top - 0.05 * r, 0]) for r in range(rows)])
    quads = [(r * around + k, r * around + (k + 1) % around) for r in range(rows - 1) for k in range(around)]
    t = [t for a, b in quads for t in ((a, b, a + around), (b, b + around, a + around))]
    return v, np.array(t)


def test_an_edge_through_a_triangle_is_found_and_neighbours_are_not() -> None:
    v, t = tube(16, 6, 0.1, 1.0)
    assert not len(crossing(v, t))
    v[0] = [-0.12, 0.93, 0.0]  # through the opposite side
    found = crossing(v, t)
    assert {0, 1, 2} <= set(found.tolist()), "the edges of the vertex that moved"


def test_a_skirt_is_held_at_its_waist_and_a_shirt_is_not() -> None:
    body, _ = tube(32, 30, 0.09, 1.45)
    skirt, t = tube(16, 8, 0.1, 1.0)
    garment = np.zeros(len(skirt), int)
    assert set(held(skirt, t, garment, body)) == set(range(16))
    over = skirt * np.array([1.4, 1, 1.4])
    assert set(held(over, t, garment, body)) == set(range(16)), "over a shirt that is tucked in"
    assert not len(held(skirt + np.array([0, 0.4, 0]), t, garment, body)), "it hangs from the shoulders"
    assert not len(held(skirt * np.array([2, 1, 2]), t, garment, body)), "its border is not on the skin"


def test_what_is_not_a_number_is_no_target() -> None:
    assert Judged(1e-4, 0.0, 1.2, 0.0).fault(Limits()) is None
    assert Judged(1e-4, 0.2, 1.2, 0.0).fault(Limits()) == "inside"
    assert Judged(np.nan, np.nan, np.nan, np.nan).fault(Limits()) == "residual"


def test_skin_that_shows_through_a_triangle_counts_as_inside() -> None:
    body, skin = tube(48, 30, 0.1, 1.45)
    for around, shown in ((24, False), (5, True)):
        cloth, t = tube(around, 5, 0.11, 1.0)
        found = judge(cloth, 0.0, (crossing(cloth, t), cloth), t, (body, skin))
        assert (found.inside > 0.3) == shown, f"{around} corners 1 cm from the skin: {found.inside}"


def test_the_turn_of_cloth_is_found() -> None:
    v, t = tube(16, 6, 0.1, 1.0)
    tilted = v @ rotation_about_x(np.pi / 3).T
    assert np.allclose(turns(v, tilted, t), rotation_about_x(np.pi / 3), atol=1e-6)


def test_upright_cloth_on_the_skin_weighs_nothing_and_turned_or_free_cloth_does() -> None:
    v, t = tube(16, 6, 0.1, 1.0)
    on_skin, free = np.zeros(len(v)), np.full(len(v), 1.0)
    assert np.allclose(pull(v, v, t, on_skin), 0, atol=1e-6)
    assert np.allclose(pull(v, v, t, free), [0, -9.81, 0], atol=1e-6)
    lying = v @ rotation_about_x(np.pi / 2).T
    assert np.allclose(pull(v, lying, t, on_skin), [0, -9.81, 0], atol=1e-5), "nothing bears it across its own up"


def rotation_about_x(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
