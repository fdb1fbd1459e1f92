"""A simulated garment lies where GarNet learns it."""

from __future__ import annotations

import time
from pathlib import Path

from garnet_data import SPLITS, Drape, Split, samples
from garnet_scenes import load
from teacher.garnet_drapes import jobs, make

DENSITY = 400


def test_every_drape_is_made_once() -> None:
    made = [drape for together in jobs() for drape in together]
    assert len(made) == len(set(made)) == 4 * sum(len(split.worn) * split.poses for split in SPLITS)


def test_a_drape_stands_on_its_body_and_is_kept(tmp_path: Path) -> None:
    samples(tmp_path, DENSITY)
    split = Split("test", 2, 1, 7_003)
    drape = Drape("tee", split, 1, 0)
    until = time.time() + 600
    assert make([drape], tmp_path, until) == {"": 1}
    _, scenes = load("tee", split, split.bank(), tmp_path)
    off = (scenes.truth - scenes.warped).norm(dim=-1)
    assert 1e-3 < off.mean() < 0.08, "settled, and on the same ground"
    assert not make([drape], tmp_path, until), "what is there is kept"
