"""Relaxation finds cloth of less energy, and training aims at it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

import bending
import cloth_energy
import relax
from train_deepsd import Data, DeePSD, Settings, Sizes, step
from training_data import BodyBank, OutfitPool, Sample, TargetPool, carry

POSES = torch.arange(3)


@pytest.fixture(scope="module")
def skirt(outfits: Path) -> Sample:
    return next(s for s in OutfitPool(outfits / "train").samples if "skirt" in s.name)


@pytest.fixture(scope="module")
def relaxed(skirt: Sample, bank: BodyBank) -> Tensor:
    return relax.relaxed(skirt, bank, bank.entries[1], POSES)


def strain(sample: Sample, bank: BodyBank, x: Tensor) -> float:
    """Energy of stretch and contact, J/m2."""
    entry = bank.entries[1]
    rest, mesh = carry(sample, bank, entry)
    d = replace(relax.skinned(sample, rest, entry, POSES), posed=x)
    terms = cloth_energy.terms(d, x - d.skinned, mesh, cloth_energy.contacts(d, sample, bank, entry, POSES), sample)
    return float(terms["stretch"] + terms["contact"])


def test_relaxed_cloth_has_a_fraction_of_the_strain_and_stays_near_the_body(
    skirt: Sample, bank: BodyBank, relaxed: Tensor
) -> None:
    entry = bank.entries[1]
    start = relax.skinned(skirt, carry(skirt, bank, entry)[0], entry, POSES)
    assert strain(skirt, bank, relaxed) < 0.2 * strain(skirt, bank, start.skinned)
    distance = torch.cdist(relaxed, entry.vertices[POSES]).min(2).values
    assert distance.max() < 0.5


def test_a_skirt_stays_at_its_waistband(skirt: Sample, bank: BodyBank, relaxed: Tensor) -> None:
    start = relax.skinned(skirt, carry(skirt, bank, bank.entries[1])[0], bank.entries[1], POSES).skinned
    moved = (relaxed - start).norm(dim=2)
    assert len(skirt.held) > 10
    assert moved[:, skirt.held].max() < 1e-4
    assert moved.max() > 0.02


def test_bodies_bend_from_the_a_pose_to_the_pose_and_stay_whole(bank: BodyBank) -> None:
    entry = bank.entries[1]
    posed, joints = entry.transforms[2].double().numpy(), entry.joints.double().numpy()
    np.testing.assert_allclose(bending.shared(posed, joints, bank.parents, 1.0), posed, atol=1e-5)
    still = np.tile(np.eye(3, 4), (len(joints), 1, 1))
    np.testing.assert_allclose(bending.shared(posed, joints, bank.parents, 0.0), still, atol=1e-5)
    half = bending.shared(posed, joints, bank.parents, 0.5)
    for j, parent in enumerate(bank.parents.tolist()):
        if parent >= 0:
            at = [half[k, :, :3] @ joints[j] + half[k, :, 3] for k in (j, parent)]
            np.testing.assert_allclose(*at, atol=1e-9)
    body = bending.bent(entry, bank, 2, 1.0)
    assert (body.vertices[0] - entry.vertices[2]).norm(dim=1).median() < 1e-4


def test_the_metric_turns_the_slope_of_a_quadratic_into_its_minimum() -> None:
    rng = np.random.default_rng(3)
    half = rng.normal(size=(6, 6))
    stiffness, goal = half @ half.T + np.eye(6), rng.normal(size=(6, 3))
    pairs, x = [], np.zeros((6, 3))
    for _ in range(60):
        slope = stiffness @ (x - goal)
        if np.abs(slope).max() < 1e-9:
            break
        move = -relax.two_loops(slope, pairs[-8:], lambda q: q / 4)
        move *= -(slope * move).sum() / (move * (stiffness @ move)).sum()
        pairs.append((move, stiffness @ move))
        x = x + move
    np.testing.assert_allclose(x, goal, atol=1e-5)


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
    free = step(DeePSD(Sizes()), data, np.random.default_rng(0), Settings(1, poses=2, copied=0.5, aimed=0.0), 0.5)
    assert free["hold"] >= 0 and "target" not in free
    net = DeePSD(Sizes())
    step(net, data, np.random.default_rng(0), Settings(1, copied=0.0, aimed=1.0, terms=frozenset({"smooth"})), 0.0)
    assert net.static.psi[0].weight.grad is None, "the offsets have no part in what counts"
