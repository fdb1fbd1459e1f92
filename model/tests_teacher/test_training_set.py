"""A simulated drape is read by training where its own body stands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from body.anny_body import AnnyBody
from relax import skinned
from teacher import training_set
from teacher.training_set import Size, Worn, coarse, make, training_bodies
from training_data import BodyBank, OutfitPool, Target, TargetPool

SKIRT = 5


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> tuple[Target, BodyBank]:
    """A straight skirt of few vertices in one pose, as training has it, beside one of which no drape is good."""
    out: Path = tmp_path_factory.mktemp("simulated")
    (out / "outfits").mkdir()
    counts = make(SKIRT, Size(1, 1, 200), out)
    assert counts == {"": 1}
    assert make(SKIRT, Size(1, 1, 200), out) == counts, "what is there is kept"
    entry, bank = Worn.drawn(SKIRT, 1).entry, BodyBank(0, 0, 0)
    bank.entries = [bank.random_entry(AnnyBody.load(), *training_bodies()[entry])] * (entry + 1)
    (made,) = (np.load(path) for path in out.glob("*.npz"))
    none = {key: made[key][:0] for key in ("poses", "transforms", "x")}
    np.savez(out / "none_good_0.npz", outfit=made["outfit"], entry=made["entry"], **none)
    (target,) = TargetPool(out, OutfitPool(out / "outfits"), bank).targets
    return target, bank


def test_cloth_is_near_where_skinning_puts_it_on_that_body(target: tuple[Target, BodyBank]) -> None:
    drape, bank = target
    transforms = bank.entries[drape.entry].transforms[drape.poses]
    there = skinned(drape.sample, drape.rest.expand_as(drape.x), transforms).skinned
    off = (drape.x - there).norm(dim=-1)
    assert 1e-4 < off.mean() < 0.08, "settled, and on the same ground"
    assert off.max() < 0.4


def test_the_bank_and_the_simulator_pose_one_body(target: tuple[Target, BodyBank]) -> None:
    drape, bank = target
    worn = Worn.drawn(SKIRT, 1)
    ours = training_set.transforms(worn.values, worn.rotations)
    assert np.allclose(bank.entries[drape.entry].transforms[drape.poses], ours, atol=1e-5)
    assert len(coarse(SKIRT, 200).garments[0].vertices) < 260
