"""Relaxation finds cloth of less energy, and training aims at it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

import cloth_energy
import posed_bodies
import relax
from posed_bodies import Bodies
from train_deepsd import Data, DeePSD, Settings, Sizes, step
from training_data import BodyBank, OutfitPool, Sample, TargetPool, carry

POSES = torch.arange(3)


@pytest.fixture(scope="module")
def skirt(outfits: Path) -> Sample:
    return next(s for s in OutfitPool(outfits / "train").samples if "skirt" in s.name)


@pytest.fixture(scope="module")
def relaxed(skirt: Sample, bank: BodyBank) -> Tensor:
    return relax.relaxed(skirt, bank, bank.entries[1], POSES)


def at_first(sample: Sample, bank: BodyBank) -> cloth_energy.Posed:
    entry = bank.entries[1]
    return relax.skinned(sample, relax.Worn.of(sample, bank, entry, len(POSES)).rest, entry.transforms[POSES])


def strain(sample: Sample, bank: BodyBank, x: Tensor) -> float:
    """Energy of stretch and contact, J/m2."""
    entry = bank.entries[1]
    mesh = carry(sample, bank, entry)[1]
    d = replace(at_first(sample, bank), posed=x)
    terms = cloth_energy.terms(
        d, x - d.skinned, mesh, cloth_energy.contacts(d, sample, bank, Bodies.of(entry, POSES)), sample
    )
    return float(terms["stretch"] + terms["contact"])


def test_relaxed_cloth_has_a_fraction_of_the_strain_and_stays_near_the_body(
    skirt: Sample, bank: BodyBank, relaxed: Tensor
) -> None:
    entry = bank.entries[1]
    start = at_first(skirt, bank)
    assert strain(skirt, bank, relaxed) < 0.2 * strain(skirt, bank, start.skinned)
    distance = torch.cdist(relaxed, entry.vertices[POSES]).min(2).values
    assert distance.max() < 0.5


def test_a_skirt_stays_at_its_waistband(skirt: Sample, bank: BodyBank, relaxed: Tensor) -> None:
    start = at_first(skirt, bank).skinned
    moved = (relaxed - start).norm(dim=2)
    assert len(skirt.held) > 10
    assert moved[:, skirt.held].max() < 1e-4
    assert moved.max() > 0.02


def test_a_drape_with_a_piece_that_fell_off_is_no_target(skirt: Sample, bank: BodyBank, relaxed: Tensor) -> None:
    fallen = relaxed.clone()
    fallen[1, 0, 1] -= 1.0
    assert relax.worn_still(skirt, bank, bank.entries[1], POSES, fallen).tolist() == [True, False, True]


def test_bodies_bend_from_the_a_pose_to_the_pose_and_stay_whole(bank: BodyBank) -> None:
    bodies = Bodies.of(bank.entries[1], POSES)
    posed, joints = bodies.transforms.double().numpy(), bodies.joints.double().numpy()
    np.testing.assert_allclose(posed_bodies.shared(posed, joints, bank.parents, 1.0), posed, atol=1e-5)
    still = np.tile(np.eye(3, 4), (*joints.shape[:2], 1, 1))
    np.testing.assert_allclose(posed_bodies.shared(posed, joints, bank.parents, 0.0), still, atol=1e-5)
    half = posed_bodies.shared(posed, joints, bank.parents, 0.5)[2]
    for j, parent in enumerate(bank.parents.tolist()):
        if parent >= 0:
            at = [half[k, :, :3] @ joints[2, j] + half[k, :, 3] for k in (j, parent)]
            np.testing.assert_allclose(*at, atol=1e-9)
    body = posed_bodies.bent(bodies, bank, 1.0)
    assert (body.vertices - bodies.vertices).norm(dim=2).median() < 1e-4


def test_the_metric_turns_the_slope_of_a_quadratic_into_its_minimum() -> None:
    """Two drapes at once, each with a stiffness of its own."""
    half = torch.randn(2, 6, 6, dtype=torch.float64, generator=torch.manual_seed(3))
    stiffness, goal = half @ half.mT + torch.eye(6), torch.randn(2, 6, 3, dtype=torch.float64)
    soft, pairs, x = torch.eye(6, dtype=torch.float64) / 4, [], torch.zeros_like(goal)
    for _ in range(60):
        here = relax.Point(x, torch.zeros(2), stiffness @ (x - goal))
        move = -relax.two_loops(here.slope, pairs[-8:], soft)
        along = relax.inner(move, stiffness @ move)
        x = x - move * relax.inner(here.slope, move) / along.clamp(min=1e-300)
        pairs.append(relax.Pair.between(here, relax.Point(x, torch.zeros(2), stiffness @ (x - goal))))
    np.testing.assert_allclose(x, goal, atol=1e-4)


def test_a_search_shortens_steps_and_leaves_what_does_not_get_better() -> None:
    """A bowl, a hill, and one that is told to stay."""
    held, x = torch.zeros(0, dtype=torch.int64), torch.full((3, 1, 3), 0.1)
    bowl = torch.tensor([100.0, -1.0, 1.0])
    energy = lambda x: bowl * x.square().sum((1, 2))  # noqa: E731
    here = relax.point(energy, x, held)
    move = torch.tensor([-0.9, 0.2, -0.1])[:, None, None] * torch.ones_like(x)
    there, went = relax.search(energy, here, -move.abs() * here.x.sign(), held, torch.tensor([False, False, True]))
    assert went.tolist() == [True, False, False]
    assert there.value[0] < here.value[0]
    assert torch.equal(there.x[1:], here.x[1:])


def test_drapes_relaxed_together_are_what_each_is_alone(skirt: Sample, bank: BodyBank, relaxed: Tensor) -> None:
    alone = relax.relaxed(skirt, bank, bank.entries[1], POSES[1:2])
    assert (alone[0] - relaxed[1]).norm(dim=1).mean() < 5e-3


def test_training_draws_relaxed_outfits_of_its_own_bodies_only(
    outfits: Path, skirt: Sample, bank: BodyBank, relaxed: Tensor, tmp_path: Path
) -> None:
    pool = OutfitPool(outfits / "train")
    transforms = bank.entries[1].transforms[POSES]
    kept = {"outfit": skirt.name, "entry": 1, "poses": POSES.numpy(), "x": relaxed}
    np.savez(tmp_path / "mine.npz", transforms=transforms, **kept)
    np.savez(tmp_path / "other_bodies.npz", transforms=transforms + 1, **kept)
    targets = TargetPool(tmp_path, pool, bank)
    assert len(targets.targets) == 1
    data = Data(pool, bank, targets, pool.samples, bank)
    first = step(DeePSD(Sizes()), data, np.random.default_rng(0), Settings(1, copied=0.5, aimed=0.0), 0.0)
    assert first["target"] > 0 and "stretch" not in first, "a run begins by copying"
    later = step(DeePSD(Sizes()), data, np.random.default_rng(0), Settings(1, copied=0.5, aimed=1.0), 0.5)
    assert later["target"] > 0 and later["stretch"] > 0 and "hold" not in later
    torch.manual_seed(0)
    once = step(DeePSD(Sizes()), data, np.random.default_rng(0), Settings(1, copied=0.5, aimed=1.0), 0.5)
    torch.manual_seed(0)
    thrice = step(DeePSD(Sizes()), data, np.random.default_rng(0), Settings(1, copied=0.5, aimed=1.0, contact=3.0), 0.5)
    assert thrice["contact"] == pytest.approx(3 * once["contact"]) and once["contact"] > 0
    assert thrice["stretch"] == once["stretch"]
    free = step(DeePSD(Sizes()), data, np.random.default_rng(0), Settings(1, poses=2, copied=0.5, aimed=0.0), 0.5)
    assert free["hold"] >= 0 and "target" not in free
    net = DeePSD(Sizes())
    step(net, data, np.random.default_rng(0), Settings(1, copied=0.0, aimed=1.0, terms=frozenset({"smooth"})), 0.0)
    assert net.static.psi[0].weight.grad is None, "the offsets have no part in what counts"
