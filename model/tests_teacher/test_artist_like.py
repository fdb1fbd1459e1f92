"""Outfits with artists' faults have those faults."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from garment.binding import reference_surface
from outfits.artist_like import artist_like
from outfits.mesh import components

SEED, FAMILY = 9_000_000, "waistcoat_shirt_trousers"


@pytest.fixture(scope="module")
def rough() -> tuple[np.ndarray, np.ndarray]:
    return artist_like(SEED, FAMILY)


def welded(vertices: np.ndarray, triangles: np.ndarray) -> tuple[int, np.ndarray]:
    """Number of places, and triangles over them."""
    places, index = np.unique(vertices.round(6), axis=0, return_inverse=True)
    return len(places), index.ravel()[triangles]


def test_pieces_lie_apart_and_garments_are_split_along_seams(rough: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, triangles = rough
    places, joined = welded(vertices, triangles)
    assert places < 0.95 * len(vertices), "seams and a double side share places"
    pieces = components(joined, places).max() + 1
    assert 8 <= pieces <= 14, f"three garments, five buttons, pockets where there is cloth: {pieces}"


def test_one_garment_has_a_back_of_its_own(rough: tuple[np.ndarray, np.ndarray]) -> None:
    _, joined = welded(*rough)
    _, uses = np.unique(np.sort(joined, 1), axis=0, return_counts=True)
    assert (uses == 2).sum() > 20


def test_some_cloth_passes_through_the_skin(rough: tuple[np.ndarray, np.ndarray]) -> None:
    vertices, surface = rough[0], reference_surface()
    hit = cKDTree(surface.vertices).query(vertices)[1]
    inside = ((vertices - surface.vertices[hit]) * surface.normals[hit]).sum(1) < 0
    assert 0.005 < inside.mean() < 0.5


def test_the_same_seed_gives_the_same_outfit(rough: tuple[np.ndarray, np.ndarray]) -> None:
    again = artist_like(SEED, FAMILY)
    assert all(np.array_equal(a, b) for a, b in zip(rough, again, strict=True))
