"""The quick solver takes the steps of newton's own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import newton
import numpy as np
import pytest
from newton.solvers import SolverVBD
from shapes import DOWN, ball, sheet

from teacher.quick_solver import QuickSolver
from teacher.simulation import QUICK, Cloth, CollisionSlot, Floats, Frequency, Ints, scene, solver

NEWTONS = replace(QUICK, damping=1e-12)  # which the quick solver does not know


@pytest.fixture(scope="module")
def held_over_a_ball() -> tuple[Cloth, Floats, tuple[Floats, Ints]]:
    """Two sheets that start 2 mm apart, 20 mm at rest, on a ball that one touches; a corner is held."""
    v, t = sheet(13, 0.4, 0.0)
    v, t = np.concatenate([v, v + np.array([0.004, 0.02, 0.007])]), np.concatenate([t, t + len(v)])
    n = len(v)
    cloth = Cloth(v, t, np.full(n, 0.02), np.ones(n, bool), np.broadcast_to(DOWN, (n, 3)), np.array([0]))
    down = np.where(np.arange(n) < n // 2, 0.158, 0.14)[:, None] * [0, 1, 0]
    return cloth, v + down, ball(0.15)


def steps(moving: SolverVBD, model: newton.Model, start: Floats, pull: Floats, step: float) -> Iterator[Floats]:
    """Where the cloth is after each step."""
    now, then, control = model.state(), model.state(), model.control()
    now.particle_q.assign(start.astype(np.float32))
    for state in (now, then):
        state.particle_f.assign(model.particle_mass.numpy()[:, None] * pull.astype(np.float32))
    pipeline = newton.CollisionPipeline(model)
    contacts = pipeline.contacts()
    while True:
        pipeline.collide(now, contacts)
        moving.step(now, then, control, contacts, step)
        now, then = then, now
        yield now.particle_q.numpy().astype(np.float64)


def test_it_takes_newtons_steps(held_over_a_ball: tuple[Cloth, Floats, tuple[Floats, Ints]]) -> None:
    cloth, start, body = held_over_a_ball
    model = scene(cloth, body, NEWTONS)
    # Enough of damping and of stretch to tell.
    start = start * [1.6, 1, 1]
    model.soft_contact_kd = 5.0
    model.shape_material_kd.fill_(5.0)
    quick, theirs = solver(model, QUICK), solver(model, NEWTONS)
    assert isinstance(quick, QuickSolver) and not isinstance(theirs, QuickSolver)
    ours, printed = (steps(s, model, start, cloth.pull, 0.004) for s in (quick, theirs))
    for k in range(25):
        x, expected = next(ours), next(printed)
        # What rounding makes of it grows from step to step, most where cloth slips.
        assert np.abs(x - expected).mean() < (5e-7 if k < 8 else 1e-4), k
    assert (quick.near.counts.numpy() > 0).all(), "cloth touches cloth"
    assert (quick._particle_contact_head.numpy() >= 0).any(), "and the skin"
    assert np.abs(x - start).max() > 0.03
    assert np.array_equal(x[0], start[0].astype(np.float32)), "the corner is held"


def test_a_look_for_contacts_does_for_two_steps(held_over_a_ball: tuple[Cloth, Floats, tuple[Floats, Ints]]) -> None:
    cloth, start, body = held_over_a_ball
    model = scene(cloth, body, QUICK)
    rare, often = solver(model, QUICK), solver(model, QUICK)
    for s in (rare, often):
        s.set_collision_frequency(collision_frequency_type={CollisionSlot.SOFT_SELF_CONTACT: Frequency.PRE_INIT})
    rare.every = 2
    ours, expected = (steps(s, model, start, cloth.pull, 0.002) for s in (rare, often))
    for k in range(15):
        rare.looking = k % 2 == 0
        x, near = next(ours), next(expected)
    apart = x[169:] - x[:169]
    assert np.linalg.norm(apart, axis=1).min() > 0.001, "the sheets stay apart"
    assert np.abs(x - near).max() < 1e-4


def test_it_finds_newtons_pairs(held_over_a_ball: tuple[Cloth, Floats, tuple[Floats, Ints]]) -> None:
    cloth, start, body = held_over_a_ball
    model = scene(cloth, body, QUICK)
    crumpled = model.state()
    x = start * [0.3, 3, 0.3] + np.random.default_rng(0).normal(0, 0.004, start.shape)
    crumpled.particle_q.assign(x.astype(np.float32))
    quick, theirs = solver(model, QUICK), solver(model, NEWTONS)
    for s in (quick, theirs):
        s._collision_detection_penetration_free(crumpled, reset_reference=False)
    found = theirs.trimesh_collision_info
    counts = quick.near.counts.numpy()
    for k, (ours, rows, sizes) in enumerate((
        (quick.near.edges, found.edge_colliding_edges, found.edge_colliding_edges_count),
        (quick.near.corners, found.vertex_colliding_triangles, found.vertex_colliding_triangles_count),
    )):  # fmt: skip
        expected = {tuple(pair) for pair in rows.numpy().reshape(-1, 2).tolist() if pair[0] >= 0}
        assert len(expected) == sizes.numpy().sum() == counts[k] > 200
        assert {tuple(pair) for pair in ours.numpy()[: counts[k]].tolist()} == expected
