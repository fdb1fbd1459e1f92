"""What GarNet promises by construction, for each variant, that it learns, and that its graph answers alike."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

import garnet_losses as losses
from export import export_method
from export_garnet import spec
from garment import garnet_tables as tables
from garment.graph import NEIGHBOURS, mesh_edges, nearest_linked
from nets.garnet import AVERAGED, POOLED, THINNED, GarNet, Neighbours, Sizes, Variant

VARIANTS: tuple[Variant, ...] = ("naive", "global", "local")


@pytest.fixture(scope="module")
def scene() -> tuple[torch.Tensor, torch.Tensor, torch.Tensor, np.ndarray]:
    """A tube of cloth as drawn (1, N, 6), its nodes' turns (1, N, 3, 3), a body of points (1, M, 3), and triangles."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 24, endpoint=False), np.linspace(-0.3, 0.3, 15))
    tube = np.stack([0.15 * np.cos(u), v, 0.15 * np.sin(u)], -1).reshape(-1, 3)
    corner = np.arange(14)[:, None] * 24 + np.arange(24)[None]
    right = np.arange(14)[:, None] * 24 + (np.arange(24)[None] + 1) % 24
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in
                                ((corner, right, right + 24), (corner, right + 24, corner + 24))])  # fmt: skip
    rng = np.random.default_rng(2)
    body = rng.normal(size=(600, 3)) * [0.05, 0.25, 0.05]
    turns = Rotation.random(len(tube), rng=rng).as_matrix()
    return (
        torch.as_tensor(np.concatenate([tube, tube], -1)[None]).float(),
        torch.as_tensor(turns[None]).float(),
        torch.as_tensor(body[None]).float(),
        triangles,
    )


def neighbours(garment: torch.Tensor, body: torch.Tensor, triangles: np.ndarray) -> Neighbours:
    points, edges = garment[0, :, :3].numpy(), mesh_edges(triangles)
    both = np.concatenate([edges, edges[:, ::-1]])
    ring, weight = tables.ring(*nearest_linked(points, both, points, NEIGHBOURS))
    thin = tables.thinned(body[0].numpy(), THINNED, AVERAGED)
    pooled = tables.nearest_thinned(points, body[0].numpy(), thin, POOLED)
    as_tensor = torch.as_tensor
    return Neighbours(as_tensor(ring), as_tensor(weight).float(), as_tensor(thin), as_tensor(pooled)[None])


def awake(variant: Variant) -> GarNet:
    """A network whose zeroed layers say something."""
    torch.manual_seed(1)
    net = GarNet(Sizes(variant=variant))
    for p in net.parameters():
        if not p.any():
            torch.nn.init.normal_(p, std=0.05)
    return net.eval()


@pytest.mark.parametrize("variant", VARIANTS)
@torch.no_grad()
def test_the_order_of_nodes_and_points_does_not_matter(scene: tuple, variant: Variant) -> None:
    garment, turn, body, triangles = scene
    net, rng = awake(variant), np.random.default_rng(0)
    plain = net(garment, turn, body, neighbours(garment, body, triangles))
    order, points = rng.permutation(garment.shape[1]), rng.permutation(body.shape[1])
    place = np.argsort(order)
    shuffled = garment[:, order], body[:, points], place[triangles]
    answer = net(shuffled[0], turn[:, order], shuffled[1], neighbours(*shuffled))
    assert plain.abs().max() > 1e-4
    torch.testing.assert_close(answer, plain[:, order], atol=1e-6, rtol=1e-4)


@pytest.mark.parametrize("variant", VARIANTS)
@torch.no_grad()
def test_it_begins_where_skinning_puts_the_cloth(scene: tuple, variant: Variant) -> None:
    garment, turn, body, triangles = scene
    assert not GarNet(Sizes(variant=variant))(garment, turn, body, neighbours(garment, body, triangles)).any()


@torch.no_grad()
def test_cloth_is_told_and_answers_in_the_frame_that_turns_with_it(scene: tuple) -> None:
    """The frames of the nodes turn about the world's up and nothing else changes: so does what they answer."""
    garment, turn, body, triangles = scene
    net, near = awake("global"), neighbours(garment, body, triangles)
    about = torch.as_tensor(Rotation.from_rotvec([0, 0.7, 0]).as_matrix()).float()
    torch.testing.assert_close(
        net(garment, about @ turn, body, near), net(garment, turn, body, near) @ about.T, atol=1e-6, rtol=1e-4
    )


@torch.no_grad()
def test_what_each_variant_sees(scene: tuple) -> None:
    """Body points move: all variants notice. Links of the mesh change: `naive` does not, nor is it pooled from."""
    garment, turn, body, triangles = scene
    near = neighbours(garment, body, triangles)
    other_links = replace(near, ring=near.ring.roll(1, 0))
    other_pool = replace(near, pooled=near.pooled.flip(1))
    for variant, sees_links, pools in (("naive", False, False), ("global", True, False), ("local", True, True)):
        net = awake(variant)
        plain = net(garment, turn, body, near)
        assert not torch.equal(plain, net(garment, turn, 1.2 * body, near))
        assert torch.equal(plain, net(garment, turn, body, other_links)) != sees_links
        assert torch.equal(plain, net(garment, turn, body, other_pool)) != pools


def test_thinned_points_cover_the_body(scene: tuple) -> None:
    body = scene[2][0].numpy()
    thin = tables.thinned(body, THINNED, AVERAGED)
    assert 0.8 * len(body) / THINNED < len(thin) < 1.25 * len(body) / THINNED
    assert len(np.unique(thin)) > 0.8 * len(body)


def test_nodes_follow_the_vertices_around_them() -> None:
    rng = np.random.default_rng(3)
    rest, nodes = rng.normal(size=(40, 3)), rng.normal(size=(11, 3))
    support = rng.integers(10, size=(40, 8))
    weight = rng.random((40, 8))
    away = np.array([0.1, 0, -0.2])
    moved = tables.nodes_on_body(nodes, rest, rest + away, support, weight)
    read = np.unique(support)
    np.testing.assert_allclose(moved[read], nodes[read] + away)
    np.testing.assert_array_equal(moved[10], nodes[10], "no vertex reads it")


def test_a_few_points_are_enough(scene: tuple) -> None:
    garment, turn, body, triangles = scene
    few = body[:, :12]
    assert torch.isfinite(GarNet(Sizes())(garment, turn, few, neighbours(garment, few, triangles))).all()


@pytest.mark.parametrize("variant", VARIANTS)
def test_it_learns_a_drape(scene: tuple, variant: Variant) -> None:
    garment, turn, body, triangles = scene
    near = neighbours(garment, body, triangles)
    cloth = garment[..., :3]
    truth = cloth + 0.02 * torch.sin(10 * cloth[..., 1:2]) * cloth / 0.15
    torch.manual_seed(0)
    net = GarNet(Sizes(variant=variant, blocks=2))
    tools = torch.optim.Adam(net.parameters(), 5e-3)
    faces, pairs = torch.as_tensor(triangles), torch.as_tensor(losses.two_edges_apart(triangles))
    first = last = losses.vertices(cloth, truth).item()
    for _ in range(150):
        x = cloth + net(garment, turn, body, near)
        loss = losses.vertices(x, truth) + 0.03 * losses.normals(x, truth, faces) + losses.bending(x, truth, pairs)
        tools.zero_grad()
        loss.backward()
        tools.step()
        last = losses.vertices(x, truth).item()
    assert last < 0.5 * first


def test_its_graph_takes_any_garment_and_body(tmp_path: Path) -> None:
    """`export_graph` compares it with PyTorch on inputs of two sizes, neither that of the trace."""
    export_method("garnet", [spec("tee", awake("local"))], tmp_path)
    written = json.loads((tmp_path / "garnet" / "manifest.json").read_text())
    assert [g["name"] for g in written["graphs"]] == ["tee"]
    assert (tmp_path / "garnet" / "tee.onnx").stat().st_size < 2_000_000
