"""From a garment's drapes to a trained GarNet, tiny."""

from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

import garnet_losses as losses
from evaluate_garnet import measured, row
from evaluate_garnet_motion import Captured, relaxed, table
from garnet_data import SPLITS, Drape, Maker, Split, drapes, missing, samples
from garnet_scenes import Garment, Scenes, load, shown
from nets.garnet import GarNet, Sizes
from train_garnet import Settings, curvature, draped, learn, physical
from training_data import BodyBank

SPLIT = Split("train", 1, 3, 5)


def dresses(out: Path) -> BodyBank:
    """Makes the drapes, and their bodies."""
    samples(out, density=600)
    maker = Maker(out, "cpu", 1, (SPLIT,), steps=80)
    assert [f.result() for f in maker.make([Drape("dress", SPLIT, 0, pose) for pose in range(3)])].count("") >= 2
    maker.pool.shutdown()
    return maker.banks["train"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, BodyBank]:
    """Three drapes of a coarse dress."""
    out = tmp_path_factory.mktemp("garnet")
    return out, dresses(out)


@pytest.fixture(scope="module")
def scenes(made: tuple[Path, BodyBank]) -> tuple[Garment, Scenes]:
    return load("dress", SPLIT, made[1], made[0])


def test_no_body_is_in_two_sets() -> None:
    few = [Split(split.name, 4, 1, split.seed) for split in SPLITS]
    banks = {split.name: split.bank() for split in few}
    worn = {(d.split.name, d.body) for d in drapes(tuple(few))}
    shapes = [banks[name].entries[body].shape for name, body in sorted(worn)]
    assert len(shapes) == 4 + 3 + 3
    assert all((a - b).abs().max() > 1e-3 for i, a in enumerate(shapes) for b in shapes[:i])
    assert len({(d.garment, d.split.name, d.body, d.pose) for d in drapes()}) == len(list(drapes()))


def test_warped_cloth_is_near_its_drape(scenes: tuple[Garment, Scenes]) -> None:
    garment, s = scenes
    assert len(s) >= 2
    far = losses.vertices(s.warped, s.truth).item()
    assert 0.003 < far < 0.15
    assert s.nodes.mean((0, 1)).abs().max() < 1e-5
    read = (garment.support_weight[..., None] * s.nodes[:, garment.support, :3]).sum(2)
    assert (read - s.warped).norm(dim=-1).mean() < 0.01, "nodes lie among the vertices that read them"
    assert losses.interpenetration(s.truth, s.truth, s.body, s.body_normals, 0.0).item() < 1e-3


def test_a_mirrored_drape_is_as_good(scenes: tuple[Garment, Scenes]) -> None:
    garment, s = scenes
    torch.testing.assert_close(s.mirrored().mirrored().truth, s.truth)
    torch.testing.assert_close(s.mirrored().mirrored().turn, s.turn)
    torch.testing.assert_close(s.mirrored().turn.det(), torch.ones(s.turn.shape[:2]))
    for one, two in zip(*(physical(x.warped, garment, x).values() for x in (s, s.mirrored())), strict=True):
        torch.testing.assert_close(one, two)


@pytest.mark.parametrize("curved", ["", "rq", "mc"])
def test_training_comes_nearer(scenes: tuple[Garment, Scenes], curved: str) -> None:
    garment, s = scenes
    torch.manual_seed(0)
    net = GarNet(Sizes(variant="global", blocks=2))
    before = losses.vertices(s.warped, s.truth).item()
    learn(net, garment, s, Settings(minutes=10, batch=2, rate=2e-2, steps=25))
    with torch.no_grad():
        after = losses.vertices(draped(net, garment, s), s.truth).item()
        assert after < 0.8 * before
        statistic = sum(v.item() for v in curvature(draped(net, garment, s), garment, s, curved).values())
    if curved:
        learn(net, garment, s, Settings(minutes=10, batch=2, rate=2e-3, steps=40, curvature=curved))
        with torch.no_grad():
            x = draped(net, garment, s)
        assert sum(v.item() for v in curvature(x, garment, s, curved).values()) < statistic
        assert losses.vertices(x, s.truth).item() < before


def test_a_missing_set_says_what_to_run(made: tuple[Path, BodyBank]) -> None:
    with pytest.raises(FileNotFoundError, match=r"python -m garnet_data"):
        load("tee", SPLIT, made[1], made[0])


def test_drapes_of_equal_seeds_are_equal(made: tuple[Path, BodyBank], tmp_path: Path) -> None:
    dresses(tmp_path)
    for name in ("000_00.npz", "000_02.npz"):
        one, two = (np.load(out / "dress" / "train" / name)["x"] for out in (made[0], tmp_path))
        np.testing.assert_array_equal(one, two)


def test_what_is_missing_comes_by_garments_in_turn_and_once(tmp_path: Path) -> None:
    there = next(drapes()).path(tmp_path)
    there.parent.mkdir(parents=True)
    there.touch()
    batches = [b for part in range(3) for b in missing(tmp_path, part, 3, 50)]
    assert all(len({d.garment for d in batch}) == 1 and len(batch) <= 50 for batch in batches)
    assert len({d.garment for d in (b[0] for b in batches[:4])}) == 4
    every = [d.path(tmp_path) for batch in batches for d in batch]
    assert len(set(every)) == len(every) == len(list(drapes())) - 1


def test_the_table_tells_better_from_worse(scenes: tuple[Garment, Scenes]) -> None:
    garment, s = scenes
    halfway = list(measured(lambda _, one: (one.warped + one.truth) / 2, garment, s))
    warped, perfect = (list(measured(way, garment, s)) for way in (lambda _, one: one.warped, lambda _, one: one.truth))
    for far, near, none in zip(warped, halfway, perfect, strict=True):
        assert near.distance == pytest.approx(far.distance / 2, rel=1e-3)
        assert far.angle > near.angle > none.angle
        assert none.distance == none.rayleigh == none.mean_curvature == 0
        assert none.inside < 2
    assert row("truth", perfect).startswith("| truth | 0.00 ± 0.00 | 0.0 ± 0.0 |")


def test_captured_poses_are_relaxed_on_bodies_of_the_test(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pose = {"leftUpperArm": np.array([0, 0, 0.1, 0.995])}
    split = Captured("clip", 2, 1, SPLITS[-1].seed, rotations=(pose,))
    tested = Split("test", 2, 1, SPLITS[-1].seed).bank().entries[1]
    torch.testing.assert_close(split.bank().entries[1].shape, tested.shape)
    samples(tmp_path, density=600)
    relaxed(split, tmp_path, batch=4, steps=80)
    assert {p.name for p in tmp_path.glob("*/clip/*.npz")} == {"001_00.npz"}
    table(split, tmp_path)
    assert "| all, warped (DQS) |" in capsys.readouterr().out


@pytest.mark.parametrize(("turn", "left"), [(0.2, 0.2), (-0.29, -0.29), (1.6, 0.3), (-3.0, -0.3)])
def test_bodies_are_shown_facing_as_in_training(turn: float, left: float) -> None:
    hips = Rotation.from_euler("y", turn).as_matrix()
    ahead = shown(hips) @ hips @ np.array([0.0, 0.0, 1.0])
    assert np.arctan2(ahead[0], ahead[2]) == pytest.approx(left)
