"""Energies against slow references in float64, and their gradients against finite differences."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from torch import Tensor

import energies
from energies import RestMesh
from fabric import Fabric
from garment.rest_mesh import rest_mesh, topology
from teacher.weight import pull, turns

FABRIC = Fabric()
OF_A_BODY = ("length", "edge_area", "angle", "hinge_weight", "area")


@pytest.fixture
def cloth(rng: np.random.Generator) -> tuple[RestMesh, Tensor, np.ndarray]:
    """A crumpled 3 x 3 grid: rest tables, two deformed poses, triangles; float64."""
    torch.set_default_dtype(torch.float64)
    grid = np.array([[i * 0.02, j * 0.02, 0.0] for j in range(3) for i in range(3)])
    quads = [(r * 3 + c, r * 3 + c + 1, r * 3 + c + 4, r * 3 + c + 3) for r in range(2) for c in range(2)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    rest = torch.as_tensor(grid + rng.normal(0, 0.002, grid.shape))
    posed = rest[None] + torch.as_tensor(rng.normal(0, 0.004, (2, 9, 3)))
    yield rest_mesh(rest, topology(triangles)), posed, triangles
    torch.set_default_dtype(torch.float32)


def slow_spring(strain: float, distance: float) -> float:
    if strain >= 0:
        return 0.5 * (strain**2 + FABRIC.stiffening * max(strain - FABRIC.limit, 0) ** 2)
    buckling = FABRIC.buckling + (FABRIC.confined - FABRIC.buckling) * math.exp(-distance / FABRIC.room)
    bent, folded = min(-strain, buckling), max(-strain - FABRIC.crumple, 0)
    return FABRIC.compression * (0.5 * bent**2 + bent * (-strain - bent)) + 0.5 * folded**2


def slow_stretch(mesh: RestMesh, posed: Tensor, distance: Tensor) -> list[float]:
    out = []
    for pose in posed.numpy():
        total = 0.0
        for (a, b), rest, area in zip(mesh.edges.numpy(), mesh.length.numpy(), mesh.edge_area.numpy(), strict=True):
            strain = float(np.linalg.norm(pose[a] - pose[b])) / rest - 1
            total += FABRIC.stretch * slow_spring(strain, float(distance[[a, b]].mean())) * area
        out.append(total / float(mesh.area.sum()))
    return out


def slow_dihedral(p: np.ndarray, hinge: np.ndarray) -> float:
    a, b, c, d = (p[i] for i in hinge)
    left, right = np.cross(b - a, c - a), np.cross(d - a, b - a)
    cosine = left @ right / np.linalg.norm(left) / np.linalg.norm(right)
    return math.copysign(math.acos(np.clip(cosine, -1, 1)), np.cross(left, right) @ (b - a))


def test_stretch_is_the_sum_over_edges(cloth: tuple[RestMesh, Tensor, np.ndarray]) -> None:
    mesh, posed, _ = cloth
    distance = torch.linspace(0, 0.06, len(mesh.area), dtype=posed.dtype)
    slow = slow_stretch(mesh, posed, distance)
    assert energies.stretch(posed, mesh, distance, FABRIC).tolist() == pytest.approx(slow, rel=1e-6)


def test_cloth_buckles_at_a_constant_load(cloth: tuple[RestMesh, Tensor, np.ndarray]) -> None:
    mesh, posed, _ = cloth
    rest = posed[:1] - posed[:1].mean(1, keepdim=True)
    own = replace(mesh, length=energies.edge_lengths(rest, mesh.edges)[0])
    near, far = torch.zeros(len(mesh.area)), torch.full((len(mesh.area),), 0.3)
    tenth, fifth, two_fifths = (energies.stretch(rest * (1 - s), own, near, FABRIC).item() for s in (0.1, 0.2, 0.4))
    assert (two_fifths - fifth) / (fifth - tenth) == pytest.approx(2, rel=1e-6)
    assert energies.stretch(rest * 1.2, own, near, FABRIC).item() > 2 * fifth
    assert energies.stretch(rest * 0.8, own, far, FABRIC).item() < 0.1 * fifth


def test_dihedral_agrees_with_the_angle_between_face_normals(cloth: tuple[RestMesh, Tensor, np.ndarray]) -> None:
    mesh, posed, _ = cloth
    expected = [[slow_dihedral(p, h) for h in mesh.hinges.numpy()] for p in posed.numpy()]
    np.testing.assert_allclose(energies.dihedral(posed, mesh.hinges).numpy(), expected, atol=2e-5)


def test_a_rest_pose_costs_nothing(cloth: tuple[RestMesh, Tensor, np.ndarray]) -> None:
    _, posed, triangles = cloth
    rest = posed[:1]
    own = rest_mesh(rest[0], topology(triangles))
    assert energies.stretch(rest, own, torch.zeros(len(own.area)), FABRIC).item() < 1e-9
    assert energies.bending(rest, own, FABRIC).item() < 1e-12


def test_contact_is_quadratic_near_and_linear_deep() -> None:
    area, margin = torch.ones(1), torch.tensor([0.004])
    cost = lambda d: energies.contact(torch.tensor([[d]]), margin, area, FABRIC).item()  # noqa: E731
    assert cost(0.005) == 0
    assert cost(0.002) == pytest.approx(FABRIC.contact * 0.002**2, rel=1e-4)
    deep = [cost(-0.03), cost(-0.04), cost(-0.05)]
    assert deep[2] - deep[1] == pytest.approx(deep[1] - deep[0], rel=1e-3)


def test_gravity_acts_on_hanging_cloth_and_not_on_cloth_that_lies_as_drawn() -> None:
    x, area = torch.randn(2, 5, 3), torch.ones(5)
    up = torch.tensor([0.0, 1.0, 0.0]).expand(2, 5, 3)
    assert energies.weight_change(x, up, torch.ones(5), area, FABRIC).abs().max() < 1e-9
    falling = energies.weight_change(x - torch.tensor([0.0, 0.1, 0.0]), up, torch.zeros(5), area, FABRIC)
    still = energies.weight_change(x, up, torch.zeros(5), area, FABRIC)
    lying = torch.tensor([0.0, 0.0, -1.0]).expand(2, 5, 3)
    turned = energies.weight_change(x, lying, torch.ones(5), area, FABRIC)
    assert turned.tolist() == pytest.approx(still.tolist(), rel=1e-5), "a support that points sideways bears nothing"
    assert (still - falling).tolist() == pytest.approx([0.1 * FABRIC.density * FABRIC.gravity] * 2, rel=1e-3)


def test_the_simulators_weight_is_the_slope_of_the_losses(cloth: tuple[RestMesh, Tensor, np.ndarray]) -> None:
    mesh, posed, triangles = cloth
    rest, distance = posed[0].numpy(), np.linspace(0, 0.1, 9)
    skinned = rest @ np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]).T
    skinned[4] += [0.0, 0.01, 0.0]
    pulled = pull(rest, skinned, triangles, distance)
    x = torch.as_tensor(skinned)[None].requires_grad_()
    up = torch.as_tensor(turns(rest, skinned, triangles)[:, :, 1])[None]
    borne = torch.exp(-torch.as_tensor(distance) / FABRIC.hang)
    (slope,) = torch.autograd.grad(energies.weight_change(x, up, borne, mesh.area, FABRIC).sum(), x)
    mass = FABRIC.density * mesh.area / mesh.area.sum()
    assert torch.allclose(slope[0], -mass[:, None] * torch.as_tensor(pulled))


def test_friction_holds_cloth_on_a_lap_and_lets_it_fall_elsewhere() -> None:
    area, near = torch.ones(1), torch.zeros(1, 1)
    up, down = torch.tensor([[[0.0, 1.0, 0.0]]]), torch.tensor([[[0.0, -1.0, 0.0]]])
    slip, fall = torch.tensor([[[0.1, 0.0, 0.0]]]), torch.tensor([[[0.0, -0.1, 0.0]]])
    assert energies.friction(slip, up, near, area, FABRIC).item() == pytest.approx(0.01 * FABRIC.friction, rel=1e-5)
    assert energies.friction(fall, up, near, area, FABRIC).item() == 0
    assert energies.friction(slip, down, near, area, FABRIC).item() == 0
    assert energies.friction(slip, up, near + 1, area, FABRIC).item() < 1e-6


def test_tables_of_several_bodies_give_what_each_gives_alone(cloth: tuple[RestMesh, Tensor, np.ndarray]) -> None:
    mesh, posed, triangles = cloth
    other = rest_mesh(1.1 * posed[1], topology(triangles))
    both = replace(mesh, **{k: torch.stack([getattr(mesh, k), getattr(other, k)]) for k in OF_A_BODY})
    distance = torch.full((len(mesh.area),), 0.02)
    for energy in (lambda x, m: energies.stretch(x, m, distance, FABRIC), lambda x, m: energies.bending(x, m, FABRIC)):
        alone = [energy(posed[k : k + 1], m).item() for k, m in enumerate((mesh, other))]
        assert energy(posed, both).tolist() == pytest.approx(alone, rel=1e-5)


@pytest.mark.parametrize("name", ["stretch", "bending"])
def test_gradients_agree_with_finite_differences(name: str, cloth: tuple[RestMesh, Tensor, np.ndarray]) -> None:
    mesh, posed, _ = cloth
    x = posed.clone().requires_grad_()
    distance = (torch.full((len(mesh.area),), 0.02),) if name == "stretch" else ()
    energy = lambda v: getattr(energies, name)(v, mesh, *distance, FABRIC)  # noqa: E731
    assert torch.autograd.gradcheck(energy, x, eps=1e-7, atol=1e-3, rtol=1e-3)


def test_contact_gradient_agrees_with_finite_differences(cloth: tuple[RestMesh, Tensor, np.ndarray]) -> None:
    mesh, _, _ = cloth
    distance = torch.linspace(-0.05, 0.0037, 9)[None].requires_grad_()
    energy = lambda d: energies.contact(d, torch.full((9,), 0.004), mesh.area, FABRIC)  # noqa: E731
    assert torch.autograd.gradcheck(energy, distance, eps=1e-8, atol=1e-2, rtol=1e-3)
