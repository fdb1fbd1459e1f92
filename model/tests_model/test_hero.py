"""Pixel cloth learns an outfit that the service describes, and writes what the service takes."""

from __future__ import annotations

import json

import numpy as np
import pytest
import torch
from safetensors.numpy import load

import hero
from bake import metadata
from export_pixel import Decoder
from garment.uv_panels import UnusableUVs
from nets.deepsd import Sizes, gather_mean, top_four
from outfits.dataset import save
from outfits.hero import hero_tee
from outfits.mesh import OutfitMesh
from pixel_data import Drapes, in_poses
from pixel_poses import JOINTS, WHOLE_BODY, upper_body_poses
from relax import skinned
from train_pixel import Settings
from training_data import BodyBank, load_sample

Tensors = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def tensors(tmp_path_factory: pytest.TempPathFactory) -> Tensors:
    """What the service's `static.safetensors` of a T-shirt holds, its basis 0."""
    tee, path = hero_tee(1000), tmp_path_factory.mktemp("hero") / "tee.npz"
    save(OutfitMesh("tee", 0, [tee]), path)
    sample = load_sample(path)
    support = sample.vertex_from_node, sample.vertex_from_node_weight
    weight, joint = top_four(gather_mean(sample.prior, *support))
    drawn = np.zeros(len(tee.uv), np.uint32)
    drawn[tee.uv_triangles] = tee.triangles
    return {
        "rest": sample.vertices.numpy().ravel(),
        "positions": sample.vertices.numpy().ravel() + np.float32(0.001),
        "triangles": sample.tables[2].numpy().astype(np.uint32).ravel(),
        "garment": np.zeros(len(sample.vertices), np.uint32),
        "vertex_from_node": support[0].numpy().astype(np.uint32).ravel(),
        "vertex_from_node_weight": support[1].numpy().ravel(),
        "joints": joint.numpy().astype(np.uint8).ravel(),
        "weights": weight.numpy().ravel(),
        "basis": np.zeros(Sizes.basis * 3 * len(sample.prior), np.float32),
        "drawn_vertices": drawn,
        "drawn_triangles": tee.uv_triangles.astype(np.uint32).ravel(),
        "uvs": tee.uv.astype(np.float32).ravel(),
    }


def test_drapes_of_an_outfit_are_learned_and_written(tensors: Tensors) -> None:
    torch.manual_seed(0)
    it = hero.task("0123", tensors)
    assert it.garment.images == 2
    assert it.garment.joints == JOINTS
    transforms = in_poses(BodyBank(0, 0, 0), upper_body_poses(10, 5)).transforms
    x = skinned(it.sample, it.sample.vertices.expand(10, -1, -1), transforms).posed
    drapes = Drapes(x + 0.003 * torch.sin(80 * x), transforms, torch.arange(10))
    file = hero.hero(it, drapes, 0.0, Settings(5, batch=2, steps=6))
    report, said = json.loads(metadata(file)["report"]), load(file)
    assert report["drapes"] == 8
    assert report["skinning_cm"] == pytest.approx(report["deepsd_cm"], rel=0.2), "a basis of 0 is skinning"
    assert 0 < report["pixel_cloth_cm"] < 10
    np.testing.assert_array_equal(said["rest"].ravel(), tensors["positions"])
    weights = [torch.as_tensor(said[f"{name}{k}"]) for k in range(7) for name in ("weight", "bias")]
    assert Decoder()(torch.zeros(1, 90), *weights).shape == (1, 6, 256, 256)
    assert said["legs"] == [0]


def test_what_reaches_the_legs_sees_them(tensors: Tensors) -> None:
    lower = tensors["rest"].reshape(-1, 3) - np.float32([0, 0.2, 0])
    assert hero.task("0123", tensors | {"rest": lower.ravel()}).garment.joints == WHOLE_BODY


def test_what_cannot_be_learned_says_why(tensors: Tensors) -> None:
    with pytest.raises(UnusableUVs, match="no UVs"):
        hero.task("0123", tensors | {"uvs": tensors["uvs"][:0]})
    two = tensors["garment"].copy()
    two[-1] = 1
    with pytest.raises(ValueError, match="several garments"):
        hero.task("0123", tensors | {"garment": two})
