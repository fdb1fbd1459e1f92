"""A bake reads what the service says, brings it nearer to relaxed cloth, and writes what the service takes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from safetensors.numpy import save

import bake
import rig
from nets.deepsd import Sizes, gather_mean, pose_features, top_four
from rig import Scene
from train_deepsd import DeePSD, drape
from training_data import BodyBank, Sample, carry

BUTTON = np.array([[0.0, 1.2, 0.12], [0.01, 1.2, 0.12], [0.0, 1.21, 0.12]], np.float32)


@pytest.fixture(scope="module")
def net() -> DeePSD:
    torch.manual_seed(0)
    net = DeePSD(Sizes()).eval()
    torch.nn.init.normal_(net.static.omega[2].weight, std=0.1)
    return net


@pytest.fixture(scope="module")
@torch.no_grad()
def tensors(net: DeePSD, sample: Sample) -> dict[str, np.ndarray]:
    """What the service's `static.safetensors` of the sample holds."""
    weights, basis, _ = net.static(sample.features, sample.prior, sample.graph)
    support = sample.vertex_from_node, sample.vertex_from_node_weight
    weight, joint = top_four(gather_mean(weights, *support))
    rows = basis.reshape(len(basis), 3, -1).permute(2, 0, 1)  # as `toile-drape/src/methods/deepsd.rs` keeps it
    return {
        "rest": sample.vertices.numpy().ravel(),
        "triangles": sample.tables[2].numpy().astype(np.uint32).ravel(),
        "garment": np.zeros(len(sample.vertices), np.uint32),
        "vertex_from_node": support[0].numpy().astype(np.uint32).ravel(),
        "vertex_from_node_weight": support[1].numpy().ravel(),
        "joints": joint.numpy().astype(np.uint8).ravel(),
        "weights": weight.numpy().ravel(),
        "basis": rows.contiguous().numpy().ravel(),
    }


@torch.no_grad()
def scene(net: DeePSD, sample: Sample, bank: BodyBank, body: int) -> Scene:
    entry = bank.entries[body]
    c = net.coefficients(pose_features(entry.transforms, bank.parents), entry.shape.expand(len(entry.vertices), -1))
    rest, mesh = carry(sample, bank, entry)
    return Scene(entry, rest, mesh, c, torch.zeros(len(c), *rest.shape))


@pytest.fixture(scope="module")
def scenes(net: DeePSD, tensors: dict[str, np.ndarray], bank: BodyBank) -> list[Scene]:
    """Two bodies, on which cloth should lie as another basis would put it."""
    sample, of = bake.read(tensors)
    other = of.basis + 0.02 * torch.randn(of.basis.shape, generator=torch.Generator().manual_seed(1))
    known = torch.Generator().manual_seed(2)
    out = [scene(net, sample, bank, body) for body in range(2)]
    out = [replace(s, coefficients=2 * torch.randn(s.coefficients.shape, generator=known)) for s in out]
    return [replace(s, x=rig.drape(of, s, torch.arange(3), other, of.weight).posed) for s in out]


def test_what_the_service_says_drapes_as_in_training(
    net: DeePSD, tensors: dict[str, np.ndarray], sample: Sample, bank: BodyBank
) -> None:
    read, of = bake.read(tensors)
    s = scene(net, sample, bank, 1)
    with torch.no_grad():
        expected = drape(net, sample, s.rest, s.entry, s.relaxed, bank.parents)
    got = rig.drape(of, s, s.relaxed, of.basis, of.weight)
    torch.testing.assert_close(got.posed, expected.posed, atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(read.distance, sample.distance)


def test_least_squares_come_nearer_to_relaxed_cloth(tensors: dict[str, np.ndarray], scenes: list[Scene]) -> None:
    _, of = bake.read(tensors)

    def miss(basis: torch.Tensor) -> float:
        return sum(
            float((rig.drape(of, s, s.relaxed, basis, of.weight).posed - s.x).norm(dim=-1).mean()) for s in scenes
        )

    assert miss(bake.fitted(of, scenes)) < 0.5 * miss(of.basis)


def test_refining_lowers_the_losses_and_keeps_blend_weights(
    tensors: dict[str, np.ndarray], scenes: list[Scene], bank: BodyBank
) -> None:
    sample, of = bake.read(tensors)

    def loss(basis: torch.Tensor, weight: torch.Tensor) -> float:
        with torch.no_grad():
            terms = [bake.losses(of, bake.Drawn(s, s.relaxed, s.x), sample, bank, basis, weight) for s in scenes]
        return sum(float(term) for by_name in terms for term in by_name.values())

    basis, weight = bake.refine(of, scenes, sample, bank, of.basis, 20)
    assert loss(basis, weight) < 0.8 * loss(of.basis, of.weight)
    torch.testing.assert_close(weight.sum(1), torch.ones(len(weight)), atol=1e-4, rtol=0)
    assert (weight != of.weight).any()


def test_a_loose_button_says_what_its_carrier_does(tensors: dict[str, np.ndarray]) -> None:
    count, nodes = len(tensors["garment"]), len(tensors["basis"]) // 192
    whole = tensors["rest"].reshape(-1, 3)
    front = whole[whole[:, 2].argmax()]
    more = {
        "rest": (BUTTON - BUTTON[0] + front + np.float32([0, 0, 0.005])).ravel(),
        "triangles": np.uint32([count, count + 1, count + 2]),
        "garment": np.zeros(3, np.uint32),
        "vertex_from_node": np.full(24, nodes, np.uint32),
        "vertex_from_node_weight": np.tile(np.float32([1, 0, 0, 0, 0, 0, 0, 0]), 3),
        "joints": np.zeros(12, np.uint8),
        "weights": np.tile(np.float32([1, 0, 0, 0]), 3),
    }
    joined = {name: np.concatenate([tensors[name], more[name]]) for name in more}
    wider = np.concatenate([tensors["basis"].reshape(64, -1), np.zeros((64, 3), np.float32)], 1)
    _, of = bake.read(tensors | joined | {"basis": wider.ravel()})
    assert of.riding.tolist() == [count, count + 1, count + 2]
    basis = rig.with_riders(of, of.basis)
    assert (basis[:, -1] != 0).all()
    torch.testing.assert_close(basis[:, -1], rig.at_vertices(of, of.basis)[count])
    torch.testing.assert_close(basis[:, :-1], of.basis[:, :-1])


def test_the_metadata_of_a_file_is_read() -> None:
    assert bake.metadata(save({"a": np.zeros(2)}, {"static": "0123"})) == {"static": "0123"}
    assert bake.metadata(save({"a": np.zeros(2)})) == {}


def test_networks_are_told_apart_by_all_their_graphs() -> None:
    assert len(bake.networks_hash(bake.ARTIFACTS)) == 64
