"""A simulated garment lies where pixel cloth learns it."""

from __future__ import annotations

import time
from pathlib import Path

import hero
from pixel_data import Source, shirt, worn
from pixel_poses import upper_body_poses
from relax import skinned
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


def test_no_chunk_is_begun_when_the_time_is_over(tmp_path: Path) -> None:
    path = tmp_path / "000.npz"
    assert not make((path, upper_body_poses(1, 1)), time.time() - 1)
    assert not path.exists()
