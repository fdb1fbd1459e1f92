"""What DeePSD promises by construction: invariances, zero at rest, export parity, and that it learns."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import torch

from distill_concat import target
from export import ExportedStatic, export_all, run_onnx
from garment.binding import bind, reference_surface
from garment.features import node_features
from garment.graph import build
from garment.nearest import vertex_normals
from garment.refine import refined
from nets.deepsd import DISTANCE, ConcatenatedPsi, Graph, Sizes, StaticPass, gather_mean, pose_features, skin, top_four
from train_deepsd import Data, DeePSD, Settings, learn, run_one, validate
from training_data import BodyBank, OutfitPool, Sample, TargetPool, load_samples


def vertex_answers(net: StaticPass, v: np.ndarray, t: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
    """Weights and basis of every vertex of a mesh, from scratch."""
    fine = refined(v, t)
    garment = np.zeros(len(fine.vertices), dtype=np.int64)
    graph = build(fine.vertices, fine.triangles, garment).of_first(len(v))
    prior = bind(v, graph).prior
    normals = vertex_normals(torch.as_tensor(fine.vertices)[None], torch.as_tensor(fine.triangles))[0].numpy()
    features = node_features(graph, normals, prior, garment, reference_surface())
    tables = Graph(**{k: tensor(getattr(graph, k)) for k in Graph.__dataclass_fields__})
    with torch.no_grad():
        weights, basis, _ = net(tensor(features), tensor(prior), tables)
    support = tensor(graph.vertex_from_node), tensor(graph.vertex_from_node_weight)
    return gather_mean(weights, *support), gather_mean(basis, *support)


def tensor(a: np.ndarray) -> torch.Tensor:
    return torch.as_tensor(a.astype(np.float32) if a.dtype.kind == "f" else a.astype(np.int64))


def test_permuting_vertices_permutes_the_answers(sample: Sample, rng: np.random.Generator) -> None:
    torch.manual_seed(0)
    net = StaticPass(Sizes())
    torch.nn.init.normal_(net.omega[2].weight, std=0.1)
    v, t = sample.vertices.double().numpy(), sample.tables[2].numpy()
    order = rng.permutation(len(v))
    place = np.argsort(order)
    turned = np.stack([np.roll(row, rng.integers(3)) for row in place[t]])[rng.permutation(len(t))]
    weights, basis = vertex_answers(net, v, t)
    permuted_weights, permuted_basis = vertex_answers(net, v[order], turned)
    torch.testing.assert_close(permuted_weights, weights[order], atol=1e-4, rtol=1e-3)
    torch.testing.assert_close(permuted_basis, basis[order], atol=1e-5, rtol=1e-3)


def test_weighted_rows_in_training_are_those_that_are_exported(sample: Sample) -> None:
    g = sample.graph
    values = torch.randn(len(g.near), 7, requires_grad=True)
    with torch.no_grad():
        plain = gather_mean(values, g.near, g.near_weight)
    torch.testing.assert_close(gather_mean(values, g.near, g.near_weight), plain)
    slope = torch.randn_like(plain)
    (got,) = torch.autograd.grad(gather_mean(values, g.near, g.near_weight), values, slope)
    expected = torch.zeros(len(values), 7)
    expected.index_add_(0, g.near.reshape(-1), (slope[:, None] * g.near_weight[..., None]).reshape(-1, 7))
    torch.testing.assert_close(got, expected, atol=1e-5, rtol=1e-5)


def test_the_a_pose_has_no_offsets(sample: Sample, bank: BodyBank) -> None:
    net = DeePSD(Sizes())
    still = torch.eye(3, 4).expand(1, 36, 3, 4)
    pose = pose_features(still, bank.parents)
    assert pose.abs().max().item() == 0
    assert net.coefficients(pose, bank.entries[1].shape[None]).abs().max().item() == 0


def test_cloth_on_the_skin_moves_with_it(sample: Sample) -> None:
    features = sample.features.clone()
    features[:, DISTANCE] = 0.0
    weights, basis, _ = StaticPass(Sizes())(features, sample.prior, sample.graph)
    assert basis.abs().max() < 1e-7
    free = StaticPass(Sizes())(sample.features, sample.prior, sample.graph)[1]
    assert free[sample.features[:, DISTANCE] > 0.2].abs().max() > 1e-3
    assert torch.allclose(weights.sum(1), torch.ones(len(weights)))


def test_skinning_with_one_moved_joint_moves_its_vertices_alone() -> None:
    transforms = torch.eye(3, 4).repeat(1, 36, 1, 1)
    transforms[0, 5, :, 3] = torch.tensor([0.0, 1.0, 0.0])
    weight, joint = top_four(torch.eye(36)[[4, 5]])
    moved, up = skin(torch.zeros(1, 2, 3), weight, joint, transforms)
    torch.testing.assert_close(moved[0], torch.tensor([[0.0, 0, 0], [0, 1, 0]]))
    torch.testing.assert_close(up[0], torch.tensor([[0.0, 1, 0], [0, 1, 0]]))


def test_a_tiny_run_lowers_the_energy(outfits: Path, bank: BodyBank, tmp_path: Path) -> None:
    torch.manual_seed(0)
    net = DeePSD(Sizes())
    validation = load_samples(outfits / "validation")
    before = validate(net, validation, bank)
    settings = Settings(minutes=20, steps=12, poses=2, outfits_per_step=1, seed=1)
    pool = OutfitPool(outfits / "train")
    data = Data(pool, bank, TargetPool(tmp_path / "none", pool, bank), validation, bank)
    learn(net, data, settings, tmp_path / "run.pt")
    after = validate(net, validation, bank)
    assert after["penetration_percent"] < before["penetration_percent"] + 0.5
    assert after["edge_mm"] < before["edge_mm"]
    assert torch.load(tmp_path / "run.pt")["step"] == 12


def test_gradients_reach_every_parameter(sample: Sample, bank: BodyBank) -> None:
    net = DeePSD(Sizes())
    torch.nn.init.normal_(net.static.omega[2].weight, std=0.01)
    draped, _, contacts = run_one(net, sample, bank, bank.entries[1], torch.arange(2))
    (draped.posed.square().sum() + draped.node_weights.square().sum() + contacts.body.sum()).backward()
    idle = [name for name, p in net.named_parameters() if p.grad is None or p.grad.abs().max() == 0]
    # Coefficients are taken less those at rest, so their last bias cancels.
    assert idle == ["coefficients.net.4.bias"]


def test_exported_graphs_answer_as_pytorch_does(sample: Sample, bank: BodyBank, tmp_path: Path) -> None:
    torch.manual_seed(0)
    sizes = Sizes()
    net, concat = DeePSD(sizes), ConcatenatedPsi(sizes)
    export_all(net, concat, sizes, tmp_path)
    manifest = json.loads((tmp_path / "deepsd" / "manifest.json").read_text())
    assert [g["name"] for g in manifest["graphs"]] == ["static", "dynamic"]
    tables = {k: getattr(sample.graph, k) for k in Graph.__dataclass_fields__}
    with torch.no_grad():
        expected = ExportedStatic(net.static)(sample.features, sample.prior, *tables.values())
    inputs = {"features": sample.features, "prior": sample.prior} | tables
    got = run_onnx(tmp_path / "deepsd" / "static.onnx", {k: v.numpy() for k, v in inputs.items()})
    for a, b in zip(expected, got, strict=True):
        np.testing.assert_allclose(a.numpy(), b, rtol=1e-4, atol=1e-4 * np.abs(b).max())


def test_the_printed_form_is_distilled_from_the_same_offsets(sample: Sample, bank: BodyBank) -> None:
    net = DeePSD(Sizes())
    entry = bank.entries[1]
    descriptors, offsets = target(net, sample, pose_features(entry.transforms, bank.parents), entry.shape)
    assert descriptors.shape == (len(sample.vertices), Sizes().width)
    assert offsets.shape == (3, len(sample.vertices), 3)
