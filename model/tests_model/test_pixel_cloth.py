"""Pixel cloth: frames, images and the network, and one short training run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.numpy import load_file
from torch import Tensor

import train_pixel
from export import ARTIFACTS
from nets.pixel_cloth import PixelCloth, Sizes, at_sites
from pixel_data import COUNT, Drapes, Maker, in_poses, necktie, shirt
from pixel_filter import Filter, offsets_of
from pixel_poses import POSE, pose_matrices, upper_body_poses
from pixel_scenes import PATCH_SIZE, Garment, Scenes, draped, pixels, scenes
from relax import skinned
from train_pixel import Run, Settings, garment_of
from training_data import BodyBank, Sample, ShapedPoses


@pytest.fixture(scope="module")
def tee(tmp_path_factory: pytest.TempPathFactory) -> Sample:
    return shirt(tmp_path_factory.mktemp("pixel"), 1400)


@pytest.fixture(scope="module")
def entry() -> ShapedPoses:
    return in_poses(BodyBank(0, 0, 0), upper_body_poses(3, 5))


@pytest.fixture(scope="module")
def drapes(tee: Sample, entry: ShapedPoses) -> Drapes:
    """Cloth as skinning leaves it, with folds."""
    x = skinned(tee, tee.vertices.expand(3, -1, -1), entry.transforms).posed
    return Drapes(x + 0.003 * torch.sin(80 * x), entry.transforms, torch.arange(3))


@pytest.fixture(scope="module", params=[False, True], ids=["whole", "patches"])
def garment(request: pytest.FixtureRequest, tee: Sample) -> Garment:
    return Garment.of(tee, request.param)


@pytest.fixture(scope="module")
def data(garment: Garment, drapes: Drapes) -> Scenes:
    return scenes(garment, drapes, "reference")


def as_images(values: Tensor, garment: Garment, side: int) -> Tensor:
    """Values of the mask's pixels (P, M, 3) as the network's images."""
    flat = torch.zeros(len(values), garment.images * side * side, 3)
    flat[:, garment.pixel] = values
    return flat.unflatten(1, (garment.images, side, side)).permute(0, 1, 4, 2, 3).flatten(1, 2)


def test_frames_are_right_handed_and_go_along_the_pattern_and_off_the_skin(garment: Garment, data: Scenes) -> None:
    turned = data.axes.transpose(-2, -1) @ data.axes
    assert torch.allclose(turned, torch.eye(3).expand_as(turned), atol=1e-4)
    assert torch.linalg.det(data.axes).min() > 0.999
    outward = data.places[0] - data.places[0].mean(0)
    assert ((data.axes[0, :, :, 2] * outward).sum(-1) > 0).float().mean() > 0.8


def test_offsets_in_frames_are_the_cloth(garment: Garment, data: Scenes) -> None:
    assert torch.allclose(draped(data.offsets, garment, data), data.truth, atol=1e-5)


def test_images_say_the_cloth(garment: Garment, data: Scenes) -> None:
    images = as_images(pixels(garment, data), garment, train_pixel.network(garment).sizes.side)
    x = draped(at_sites(images, garment.pixel_of_site, garment.pixel_weight), garment, data)
    off = (x - data.truth).norm(dim=-1)
    mean, most = (1e-3, 0.03) if garment.side == PATCH_SIZE else (5e-4, 0.02)  # pixels of 7 mm, and of 3
    assert off.mean() < mean
    assert off.max() < most
    losses = train_pixel.losses(images, garment, data, Settings(1))
    assert losses["pixels"] == 0
    assert losses["normals"] < 1e-4


def test_a_turned_body_turns_frames_and_leaves_offsets_and_pose(garment: Garment, data: Scenes, drapes: Drapes) -> None:
    cos, sin = np.cos(2.0), np.sin(2.0)
    turn = torch.tensor([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]], dtype=torch.float32)
    there = scenes(garment, Drapes(drapes.x @ turn.T, turn @ drapes.transforms, drapes.number), "reference")
    assert torch.allclose(there.pose, data.pose, atol=1e-5)
    assert torch.allclose(there.offsets, data.offsets, atol=1e-4)
    assert torch.allclose(there.axes, turn @ data.axes, atol=1e-3)


def test_poses_are_rotations_of_the_upper_body_and_seeded(entry: ShapedPoses) -> None:
    pose = pose_matrices(entry.transforms)
    assert pose.shape == (3, POSE)
    turns = pose.unflatten(1, (-1, 3, 3))
    assert torch.allclose(turns @ turns.mT, torch.eye(3).expand_as(turns), atol=1e-5)
    again = upper_body_poses(2, 5)
    assert all(np.array_equal(a[k], b[k]) for a, b in zip(again, upper_body_poses(3, 5), strict=False) for k in a)


def test_patches_are_networks_of_their_own() -> None:
    torch.manual_seed(0)
    net, pose = PixelCloth(Sizes(3, (8, 6, 4), 3)).eval(), torch.randn(1, POSE)
    with torch.no_grad():
        before = net(pose)
        assert before.shape == (1, 9, 32, 32)
        net.layers[0].weight[POSE : 2 * POSE] += 1.0
        changed = (net(pose) - before).abs().amax((0, 2, 3)).unflatten(0, (3, 3)).amax(1) > 0
    assert changed.tolist() == [False, True, False]


def test_a_wrong_body_gives_other_offsets_to_the_same_cloth(garment: Garment, data: Scenes, drapes: Drapes) -> None:
    for carrier in ("thin", "thick", "lagging", "rigid"):
        wrong = scenes(garment, drapes, carrier)
        assert (wrong.offsets - data.offsets).norm(dim=-1).mean() > 1e-3
        assert torch.allclose(draped(wrong.offsets, garment, wrong), data.truth, atol=1e-5)


def test_a_mirror_shows_the_cloth_on_the_mirrored_body(garment: Garment, tee: Sample, drapes: Drapes) -> None:
    both = drapes.with_mirrored(tee)
    assert both.x.shape == (6, *drapes.x.shape[1:])
    mirrored = Drapes(both.x[3:], both.transforms[3:], both.number[3:])
    assert (mirrored.with_mirrored(tee).x[3:] - drapes.x).norm(dim=-1).mean() < 2e-3
    one, other = (scenes(garment, d, "reference") for d in (drapes, mirrored))
    away = [(s.truth[:, garment.vertex] - s.places).norm(dim=-1).mean(1) for s in (one, other)]
    assert torch.allclose(*away, rtol=0.05), "the body does not stand where its cloth is"


def test_a_necktie_hangs_from_its_knot(tmp_path: Path) -> None:
    tie, bank = necktie(tmp_path), BodyBank(0, 0, 0)
    bowed = in_poses(bank, [{"spine": np.array([0.3, 0, 0, 0.954])}])
    x, _ = Maker(tie, steps=60).make(bowed, 1)
    worn = skinned(tie, tie.vertices[None], bowed.transforms).posed
    moved = (torch.as_tensor(x) - worn).norm(dim=-1)[0]
    assert moved[tie.held].max() < 0.01
    point = tie.vertices[:, 1].argmin()
    assert moved[point] > 0.05, "the point does not leave the belly of a body that bows"
    garment = garment_of(Run(garment="tie"), tie)
    assert (garment.images, len(garment.vertex)) == (1, len(tie.vertices))


def test_training_lowers_the_error(garment: Garment, data: Scenes) -> None:
    torch.manual_seed(0)
    net = train_pixel.network(garment)
    before = train_pixel.measures(train_pixel.answers(net, garment, data), garment, data)["error_cm"]
    train_pixel.learn(net.train(), garment, data, Settings(2, batch=3, steps=40))
    assert train_pixel.measures(train_pixel.answers(net, garment, data), garment, data)["error_cm"] < before


def test_every_tenth_drape_is_for_the_test() -> None:
    every = Drapes(torch.zeros(COUNT, 1, 3), torch.zeros(COUNT, 1, 3, 4), torch.arange(COUNT))
    counts = {split: len(every.of(split).x) for split in ("train", "validation", "test")}
    assert counts == {"train": 0.8 * COUNT, "validation": 0.1 * COUNT, "test": 0.1 * COUNT}


def test_the_filter_keeps_what_its_drapes_do_and_takes_away_noise(garment: Garment, data: Scenes) -> None:
    smooth = Filter.of(data)
    assert torch.allclose(smooth.apply(data.offsets), data.offsets, atol=1e-5)
    noise = 0.005 * torch.randn(data.offsets.shape, generator=torch.manual_seed(0))
    off = (smooth.apply(data.offsets + noise, 2) - data.offsets).norm(dim=-1).mean()
    assert off < 0.3 * noise.norm(dim=-1).mean()
    assert torch.allclose(offsets_of(data.truth, garment, data), data.offsets, atol=1e-5)


def test_the_shipped_filter_is_orthonormal() -> None:
    kept = load_file(ARTIFACTS / "pixel_cloth" / "tee.safetensors")
    components = kept["filter"]
    np.testing.assert_allclose(components @ components.T, np.eye(len(components)), atol=1e-4)
    assert kept["filter_mean"].size == components.shape[1] == 3 * len(kept["vertex"])
