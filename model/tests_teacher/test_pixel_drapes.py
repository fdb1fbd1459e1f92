"""A simulated garment lies where pixel cloth learns it."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

import hero
from pixel_data import Source, necktie, shirt, worn
from pixel_poses import upper_body_poses
from relax import skinned
from teacher.checks import Limits
from teacher.garment import simulated
from teacher.pixel_drapes import make

DENSITY = 400


def test_a_chunk_stands_on_the_body_of_training_and_is_kept(tmp_path: Path) -> None:
    sample, source = shirt(tmp_path, DENSITY), Source(tmp_path, hero.CHUNK)
    path = source.files()[0]
    hero.make(worn(sample), path, 0, True)
    drapes = source.load()["train"]
    assert len(drapes.x) > hero.CHUNK // 2, "most are good"
    there = skinned(sample, sample.vertices.expand_as(drapes.x), drapes.transforms).skinned
    off = (drapes.x - there).norm(dim=-1)
    assert 1e-3 < off.mean() < 0.06, "settled, and on the same ground"
    kept = path.read_bytes()
    assert not make((path, upper_body_poses(1, 1)), time.time() + 60), "what is there is kept"
    assert path.read_bytes() == kept


def test_a_necktie_hangs_from_its_knot(tmp_path: Path) -> None:
    sample, bow = necktie(tmp_path), {"spine": [np.sin(0.5), 0.0, 0.0, np.cos(0.5)]}
    entry, x, found = simulated(worn(sample), [bow], tmp_path / "scratch", knot=sample.held.numpy())
    assert found[0].fault(Limits()) is None
    there = skinned(sample, sample.vertices[None], entry.transforms).posed[0].numpy()
    knot, point = sample.held.numpy(), sample.vertices[:, 1].argmin().item()
    assert np.linalg.norm(x[0, knot] - there[knot], axis=1).max() < 0.005, "up to what leaves the body"
    aside = lambda v: np.linalg.norm((v[point] - v[knot].mean(0))[[0, 2]])  # noqa: E731
    assert aside(there) > 0.2 and aside(x[0]) < 0.05, "straight down, not along the body"


def test_no_chunk_is_begun_when_the_time_is_over(tmp_path: Path) -> None:
    path = tmp_path / "000.npz"
    assert not make((path, upper_body_poses(1, 1)), time.time() - 1)
    assert not path.exists()
