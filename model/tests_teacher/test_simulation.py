"""The simulator on cloth whose rest is known: it hangs from what holds it and lies on what is below."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import DOWN, ball, sheet

from fabric import Fabric
from garment.graph import mesh_edges
from teacher.checks import Limits, crossing, judge, lengths
from teacher.race import whole
from teacher.simulation import QUICK, Cloth, Settings, Stage, equilibrium, kept_off


def cloth(v: np.ndarray, t: np.ndarray, held: list[int], pull: np.ndarray) -> Cloth:
    n = len(v)
    return Cloth(v, t, np.full(n, 0.02), np.ones(n, bool), np.broadcast_to(pull, (n, 3)), np.array(held, np.int64))


@pytest.fixture(scope="module")
def over_a_ball() -> tuple[Cloth, np.ndarray, float, tuple[np.ndarray, np.ndarray]]:
    v, t = sheet(15, 0.5, 0.0)
    square, body = cloth(v, t, [], DOWN), ball(0.15)
    end = equilibrium(square, v + np.array([0, 0.17, 0]), body, Settings())
    return square, end.x, end.residual, body


def test_cloth_lies_on_a_ball_and_hangs_around_it(
    over_a_ball: tuple[Cloth, np.ndarray, float, tuple[np.ndarray, np.ndarray]],
) -> None:
    square, x, residual, body = over_a_ball
    already = crossing(square.rest, square.triangles)
    judged = judge(x, residual, (already, square.rest), square.triangles, body)
    assert judged.fault(Limits()) is None, judged
    assert x[112, 1] > 0.15, "the middle rests on top"
    corners = x[[0, 14, 210, 224], 1]
    assert (corners < 0.0).all(), f"the corners hang beside the ball: {corners}"
    edges = mesh_edges(square.triangles)
    assert np.abs(lengths(x, edges) / lengths(square.rest, edges) - 1).mean() < 0.03


def test_cloth_without_weight_stays_and_held_cloth_hangs_from_its_edge() -> None:
    v, t = sheet(9, 0.3, 1.0)
    far = ball(0.1)
    still = equilibrium(cloth(v, t, [], 0 * DOWN), v, far, Settings((Stage(0.002, 30, 0.98),)))
    assert np.allclose(still.x, v, atol=1e-4)
    edge = list(range(9))
    hung = equilibrium(cloth(v, t, edge, DOWN), v, far, Settings()).x
    assert np.allclose(hung[edge], v[edge], atol=1e-6)
    assert (hung[-9:, 1] < 0.75).all(), "30 cm of cloth below the edge that is held"


def test_cloth_to_learn_from_is_not_at_rest_before_its_least_steps() -> None:
    v, t = sheet(9, 0.3, 1.0)
    still = equilibrium(cloth(v, t, [], 0 * DOWN), v, ball(0.1), QUICK)
    assert still.steps == sum(stage.least for stage in QUICK.stages)
    assert still.residual < QUICK.still


def test_hanging_cloth_is_stretched_by_its_weight_and_no_more() -> None:
    """A strip: on average by half of its weight a metre over the stiffness, a third of that of the losses' springs."""
    v, t = sheet(31, 0.6, 1.0)
    strip = np.abs(v[:, 2]) < 0.07
    number = np.cumsum(strip) - 1
    v, t = v[strip], number[t[strip[t].all(1)]]
    hung = np.stack([v[:, 2], v[:, 0] - v[:, 0].max(), 0 * v[:, 0]], 1)
    top = np.flatnonzero(hung[:, 1] > -1e-9).tolist()
    end = equilibrium(cloth(hung, t, top, DOWN), hung, ball(0.01), Settings()).x
    fabric = Fabric()
    expected = fabric.density * fabric.gravity * 0.6 / 2 / (fabric.stretch / 3)
    low = hung[:, 1] < -0.599
    assert 0.7 < (end[low, 1].mean() + 0.6) / -(0.6 * expected) < 1.3


def test_corners_of_large_triangles_keep_farther_off_where_there_is_room() -> None:
    small, large = (cloth(*sheet(9, side, 1.0), [], DOWN) for side in (0.05, 0.6))
    s = Settings()
    assert np.allclose(kept_off(small, s), s.radius, atol=1e-3)
    assert np.allclose(kept_off(large, s), s.most_off)


def test_the_race_reads_the_time_of_a_method() -> None:
    report = (
        "| once | ms |\n|---|---:|\n\n| stage, median ms | deepsd | garnet |\n|---|---:|---:|\n| whole | 3.0 | 68.9 |"
    )
    assert whole(report, "garnet") == 68.9
    with pytest.raises(ValueError, match="not in list"):
        whole(report, "pixel_cloth")
