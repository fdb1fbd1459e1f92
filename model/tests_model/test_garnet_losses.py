"""GarNet's losses against slow float64 versions written from the equations, and their slopes by differences."""

import numpy as np
import pytest
import torch
from scipy.spatial import ConvexHull

import garnet_losses as losses


@pytest.fixture(scope="module")
def cloth() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A crumpled sheet of 30 vertices, where it should be, and its triangles."""
    rng = np.random.default_rng(3)
    u, v = np.meshgrid(np.arange(6.0), np.arange(5.0))
    flat = 0.03 * np.stack([u.ravel(), v.ravel(), 0 * u.ravel()], 1)
    cells = (np.arange(4)[:, None] * 6 + np.arange(5)[None]).ravel()
    triangles = np.concatenate([np.stack([cells, cells + 1, cells + 7], 1), np.stack([cells, cells + 7, cells + 6], 1)])
    truth = flat + rng.normal(0, 0.006, flat.shape)
    return truth + rng.normal(0, 0.006, flat.shape), truth, triangles


def tensors(*arrays: np.ndarray) -> list[torch.Tensor]:
    """Positions as one drape, tables as they are."""
    return [torch.as_tensor(a)[None] if a.dtype.kind == "f" else torch.as_tensor(a) for a in arrays]


def slopes_agree(function: object, x: np.ndarray) -> bool:
    """Whether autograd's slope is that of finite differences."""
    return torch.autograd.gradcheck(function, torch.as_tensor(x)[None].requires_grad_(), eps=1e-7, atol=1e-5, rtol=1e-3)


def test_distance_is_the_mean_over_vertices(cloth: tuple) -> None:
    x, truth, _ = cloth
    slow = sum(np.sqrt(((a - b) ** 2).sum()) for a, b in zip(x, truth, strict=True)) / len(x)
    assert losses.vertices(*tensors(x, truth)).item() == pytest.approx(slow)
    assert slopes_agree(lambda y: losses.vertices(y, torch.as_tensor(truth)[None]), x)


def test_only_cloth_near_its_place_and_behind_the_extended_body_counts(cloth: tuple) -> None:
    x, truth, _ = cloth
    truth = truth.copy()
    truth[3] += 0.2  # too far from its place to be asked
    rng = np.random.default_rng(5)
    body = x[::2] + rng.normal(0, 0.01, x[::2].shape)
    normals = rng.normal(size=body.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    slow = 0.0
    for place, true in zip(x, truth, strict=True):
        i = np.argmin(((body - place) ** 2).sum(1))
        point = body[i] + 0.2 * 0.03 * normals[i]
        slow += max(0.0, -normals[i] @ (place - point)) * (np.linalg.norm(place - true) < 0.05) / len(x)
    t_body, t_normals, t_truth = tensors(body, normals, truth)
    call = lambda y: losses.interpenetration(y, t_truth, t_body, t_normals, 0.03)  # noqa: E731
    assert slow > 0
    assert call(torch.as_tensor(x)[None]).item() == pytest.approx(slow)
    assert slopes_agree(call, x)


def test_facets_turn_towards_the_simulated_ones(cloth: tuple) -> None:
    x, truth, triangles = cloth
    cosines = []
    for a, b, c in triangles:
        one, two = np.cross(x[b] - x[a], x[c] - x[a]), np.cross(truth[b] - truth[a], truth[c] - truth[a])
        cosines.append(one @ two / np.linalg.norm(one) / np.linalg.norm(two))
    t = tensors(x, truth, triangles)
    assert losses.normals(*t).item() == pytest.approx(np.mean((1 - np.array(cosines)) ** 2))
    assert losses.normal_angle(*t).item() == pytest.approx(np.degrees(np.arccos(cosines)).mean())
    assert slopes_agree(lambda y: losses.normals(y, t[1], t[2]), x)


def test_bending_compares_vertices_two_edges_apart(cloth: tuple) -> None:
    x, truth, triangles = cloth
    linked = {frozenset(p) for t in triangles for p in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))}
    near = {v: {w for p in linked if v in p for w in p if w != v} for v in range(len(x))}
    expected = {frozenset((v, w)) for v in near for m in near[v] for w in near[m] if w != v and w not in near[v]}
    pairs = losses.two_edges_apart(triangles)
    assert {frozenset(p) for p in pairs.tolist()} == expected
    assert len(pairs) == len(expected)
    slow = np.mean(
        [abs(np.linalg.norm(x[i] - x[k]) - np.linalg.norm(truth[i] - truth[k])) for i, k in map(tuple, expected)]
    )
    assert losses.bending(*tensors(x, truth, pairs)).item() == pytest.approx(slow)
    assert slopes_agree(lambda y: losses.bending(y, *tensors(truth, pairs)), x)


@pytest.mark.parametrize("count", [8, 16])
def test_rayleigh_quotients_lie_between_the_eigenvalues(cloth: tuple, count: int) -> None:
    x, truth, _ = cloth
    near = losses.neighbourhoods(truth, count)
    slow = []
    for row in near:
        around = x[row] - x[row].mean(0)
        covariance = around.T @ around / count
        quotients = [g @ covariance @ g / (g @ g) for g in around]
        slow.append((min(quotients), max(quotients)))
        low, *_, high = np.linalg.eigvalsh(covariance)
        assert low <= slow[-1][0] <= slow[-1][1] <= high * (1 + 1e-9)
    least, greatest = losses.rayleigh(*tensors(x, near))
    np.testing.assert_allclose(np.stack([least[0], greatest[0]], 1), slow)
    t_truth, t_near = tensors(100 * truth, near)  # in centimetres, so that finite differences see the fourth powers
    assert slopes_agree(lambda y: losses.rayleigh_curvature(100 * y, t_truth, t_near), x)


def test_mean_curvature_normals_are_those_of_a_ball() -> None:
    t = (1 + 5**0.5) / 2
    corners = np.array([(0, a, b * t) for a in (-1, 1) for b in (-1, 1)], float)
    ball = np.concatenate([np.roll(corners, k, 1) for k in range(3)])
    ball *= 0.1 / np.linalg.norm(ball, axis=1, keepdims=True)
    triangles = ConvexHull(ball).simplices.astype(np.int64)
    inward = losses.mean_curvature_normal(*tensors(ball, triangles))[0].numpy()
    # Equation 9 is four times the mean curvature of 10 per metre, towards the centre.
    np.testing.assert_allclose(np.linalg.norm(inward, axis=1), 4 * 10, rtol=0.02)
    np.testing.assert_array_less((inward * ball).sum(1), 0)


def test_mean_curvature_agrees_with_the_equation(cloth: tuple) -> None:
    x, truth, triangles = cloth
    slow = [_mean_curvature_normal(y, triangles) for y in (x, truth)]
    expected = np.mean(((slow[0] - slow[1]) ** 2).sum(1))
    assert losses.mean_curvature(*tensors(x, truth, triangles)).item() == pytest.approx(expected)
    small = lambda y: 1e-4 * losses.mean_curvature(y, *tensors(truth, triangles))  # noqa: E731
    assert torch.autograd.gradcheck(small, torch.as_tensor(x)[None].requires_grad_(), eps=1e-8, atol=1e-3, rtol=1e-2)


def _mean_curvature_normal(x: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    total, area = np.zeros_like(x), np.zeros(len(x))
    for triangle in triangles:
        angles = []
        for k in range(3):
            here, left, right = (x[triangle[(k + m) % 3]] for m in range(3))
            cosine = (left - here) @ (right - here) / np.linalg.norm(left - here) / np.linalg.norm(right - here)
            angles.append(np.arccos(cosine))
        a, b, c = x[triangle]
        flat = np.linalg.norm(np.cross(b - a, c - a)) / 2
        for k in range(3):
            i, j = triangle[(k + 1) % 3], triangle[(k + 2) % 3]
            cotangent = np.clip(1 / np.tan(angles[k]), -losses.STEEPEST, losses.STEEPEST)
            total[i] += cotangent * (x[j] - x[i])
            total[j] += cotangent * (x[i] - x[j])
            if max(angles) <= np.pi / 2:
                area[[i, j]] += cotangent * ((x[i] - x[j]) @ (x[i] - x[j])) / 8
            else:
                area[triangle[k]] += flat / (2 if angles[k] > np.pi / 2 else 4)
    return total / area[:, None]
