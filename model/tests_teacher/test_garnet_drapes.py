"""A simulated garment lies where GarNet learns it."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

from body import quaternions as qt
from captured import captured_poses, upright
from garnet_data import SIMULATED, Drape, Split, samples
from garnet_scenes import load
from teacher.garnet_drapes import jobs, make
from training_data import random_bodies

DENSITY = 400


def test_every_drape_is_made_once() -> None:
    made = [drape for together in jobs() for drape in together]
    assert len(made) == len(set(made)) == 4 * sum(len(split.worn) * split.poses for split in SIMULATED.splits)


def test_movement_is_captured_and_stays_upright() -> None:
    assert len(captured_poses()) > 200
    assert all(upright(pose) for pose in captured_poses())
    raised = [pose for pose in captured_poses() if qt.rotate(pose["leftUpperArm"], [1, 0, 0])[1] > 0.3]
    assert 5 < len(raised) < 150, "arms go up in some"


def test_half_of_trainings_poses_are_captured_and_all_of_the_tests() -> None:
    train, _, test = SIMULATED.splits
    for split, count in ((train, train.poses // 2), (test, test.poses)):
        few = replace(split, bodies=2)
        for (_, poses), (_, drawn) in zip(few.clothed(), random_bodies(2, split.poses, split.seed), strict=True):
            is_captured = [any(pose is other for other in captured_poses()) for pose in poses]
            assert is_captured == [True] * count + [False] * (split.poses - count)
            for pose, other in zip(poses[count:], drawn[count:], strict=True):
                assert all((pose[name] == q).all() for name, q in other.items())


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
