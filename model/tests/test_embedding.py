"""Cloth wrapped on a body lies on it, evenly, and goes where it goes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from garment.binding import reference_surface
from garment.embedding import Embedding, closest, hips, worn_tight
from garment.graph import mesh_edges
from outfits.garnet_garments import garnet_garment
from outfits.generate import generate
from outfits.mesh import GarmentMesh


@pytest.fixture(scope="module")
def worn() -> tuple[GarmentMesh, Embedding]:
    """A coarse T-shirt on the reference body."""
    garment = garnet_garment("tee", 1400).garments[0]
    return garment, worn_tight(garment.vertices, garment.triangles)


def test_the_nearest_point_of_a_triangle_is_as_near_as_a_search_says() -> None:
    rng = np.random.default_rng(0)
    corners, points = rng.normal(size=(200, 3, 3)), rng.normal(size=(200, 3))
    u, v = np.meshgrid(np.linspace(0, 1, 120), np.linspace(0, 1, 120))
    grid = np.stack([u, v, 1 - u - v], -1)[u + v <= 1 + 1e-9]
    searched = np.linalg.norm(np.einsum("gk,mkd->mgd", grid, corners) - points[:, None], axis=2).min(1)
    weight = closest(points, corners)
    found = np.linalg.norm((weight[..., None] * corners).sum(1) - points, axis=1)
    np.testing.assert_allclose(weight.sum(1), 1, atol=1e-9)
    assert weight.min() > -1e-9
    assert (found < searched + 1e-9).all()
    np.testing.assert_allclose(found, searched, atol=0.03)


def test_a_tee_lies_evenly_on_the_skin(worn: tuple[GarmentMesh, Embedding]) -> None:
    garment, embedding = worn
    surface = reference_surface()
    places = embedding.places(surface.vertices)
    moved = np.linalg.norm(places - garment.vertices, axis=1)
    assert 0.005 < moved.mean() < 0.05
    edges = mesh_edges(garment.triangles)
    ratio, rest = (np.linalg.norm(x[edges[:, 0]] - x[edges[:, 1]], axis=1) for x in (places, garment.vertices))
    low, high = np.percentile(ratio / rest, [1, 99])
    assert low > 0.5
    assert high < 1.7
    a, b, c = (places[garment.triangles[:, k]] for k in range(3))
    outward = embedding.normals(surface.normals)[garment.triangles].sum(1)
    assert ((np.cross(b - a, c - a) * outward).sum(1) > 0).all(), "no triangle is turned over"


def test_cloth_of_the_trunk_is_not_held_by_an_arm(worn: tuple[GarmentMesh, Embedding]) -> None:
    garment, embedding = worn
    side = np.abs(garment.vertices[:, 0])
    hem = (garment.vertices[:, 1] < 1.0) & (side < 0.3)
    held = reference_surface().arm[embedding.corners[hem]].sum(-1)
    assert hem.sum() > 50
    assert held.max() < 0.6


def test_a_skirt_lies_over_both_legs_and_does_not_part_between_them() -> None:
    skirt, surface = generate(1, "straight_skirt").garments[0], reference_surface()
    embedding = worn_tight(skirt.vertices, skirt.triangles)
    assert embedding.corners.shape == (len(skirt.vertices), 6)
    np.testing.assert_allclose(embedding.weight.sum(1), 1)
    step = surface.vertices + 0.15 * (surface.leg[:, :1] - surface.leg[:, 1:]) * [0, 0, 1]
    moved = embedding.places(step) - embedding.places(surface.vertices)
    side, front = skirt.vertices[:, 0], skirt.vertices[:, 2] > 0
    low = front & (skirt.vertices[:, 1] < hips() - 0.2)
    assert np.abs(moved[low & (np.abs(side) < 0.01), 2]).max() < 0.04, "the middle goes with both"
    assert moved[low & (side > 0.1), 2].min() > 0.1, "the left with the left leg"
    assert moved[low & (side < -0.1), 2].max() < -0.1
    edges = mesh_edges(skirt.triangles)
    assert np.linalg.norm(moved[edges[:, 0]] - moved[edges[:, 1]], axis=1).max() < 0.1


def test_places_go_where_the_body_goes(worn: tuple[GarmentMesh, Embedding]) -> None:
    embedding, surface = worn[1], reference_surface()
    turn = Rotation.from_euler("xyz", [0.3, 1.1, -0.4])
    np.testing.assert_allclose(
        embedding.places(turn.apply(surface.vertices) + 0.2),
        turn.apply(embedding.places(surface.vertices)) + 0.2, atol=1e-9,
    )  # fmt: skip
    np.testing.assert_allclose(
        embedding.normals(turn.apply(surface.normals)), turn.apply(embedding.normals(surface.normals)), atol=1e-9
    )
