"""A few small outfits and bodies that the tests share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from outfits.dataset import save
from outfits.generate import generate
from training_data import BodyBank, Sample, load_sample

SEEDS = {"tank": 3, "straight_skirt": 4}


@pytest.fixture(scope="session")
def outfits(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two generated outfits in `train` and the same two in `validation`."""
    torch.set_num_threads(2)
    folder = tmp_path_factory.mktemp("outfits")
    for part in ("train", "validation"):
        (folder / part).mkdir()
        for family, seed in SEEDS.items():
            save(generate(seed, family), folder / part / f"{seed}_{family}.npz")
    return folder


@pytest.fixture(scope="session")
def sample(outfits: Path) -> Sample:
    paths = sorted(p for p in (outfits / "train").glob("*.npz") if p.name.count(".") == 1)
    return load_sample(paths[0])


@pytest.fixture(scope="session")
def bank() -> BodyBank:
    return BodyBank(2, 3, seed=11)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)
