"""Cutting coarse outfits finer, and what small loose pieces ride on; the Rust tests of both say the same."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from garment.graph import build, mesh_edges
from garment.ornaments import carriers, ride
from garment.refine import LONGEST, refined

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]


def strip(squares: int, at: tuple[float, float, float], first: int = 0) -> Mesh:
    """A strip of squares of 5 cm along x, its vertices numbered from `first`."""
    vertices = np.array([(0.05 * i, 0.05 * j, 0.0) for i in range(squares + 1) for j in (0, 1)]) + at
    corner = first + 2 * np.arange(squares)[:, None]
    return vertices, (corner + np.array([[0, 2, 1], [1, 2, 3]])[:, None]).reshape(-1, 3)


def joined(*meshes: Mesh) -> Mesh:
    return np.concatenate([v for v, _ in meshes]), np.concatenate([t for _, t in meshes])


def signed_area(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    return np.cross(b - a, c - a).sum(0) / 2


def test_long_edges_are_halved_until_none_is_left_and_the_surface_stays() -> None:
    corners = np.array([[0, 0, 0], [0.2, 0, 0], [0.05, 0.09, 0], [0.21, 0.05, 0]])
    coarse = np.array([[0, 1, 2], [1, 3, 2]])
    mesh = refined(corners, coarse)
    assert (mesh.vertices[:4] == corners).all()
    np.testing.assert_allclose(signed_area(mesh.vertices, mesh.triangles), signed_area(corners, coarse), atol=1e-9)
    ends = mesh.vertices[mesh_edges(mesh.triangles)]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).max() <= LONGEST
    assert (mesh.origin < 4).all()


def test_fine_meshes_stay_as_they_are() -> None:
    mesh = refined(np.array([[0, 0, 0], [0.02, 0, 0], [0, 0.02, 0]]), np.array([[0, 1, 2]]))
    assert mesh.triangles.tolist() == [[0, 1, 2]]
    assert mesh.origin.tolist() == [0, 1, 2]


@pytest.mark.parametrize(("distance", "carried"), [(0.01, True), (0.1, False)])
def test_a_small_piece_rides_where_it_touches(distance: float, carried: bool) -> None:
    vertices, triangles = joined(strip(12, (0, 0, 0)), strip(2, (0, 0, distance), first=26))
    found = carriers(vertices, triangles, np.zeros(len(vertices), dtype=np.int64))
    assert (found[:26] == np.arange(26)).all()
    assert (found[26:] == (1 if carried else np.arange(26, 32))).all()


def test_the_pieces_of_a_small_garment_ride_on_one_vertex() -> None:
    vertices, triangles = joined(strip(12, (0, 0, 0)), strip(2, (0, 0, 0.01), 26), strip(2, (0.12, -0.06, 0.01), 32))
    garment = (np.arange(len(vertices)) >= 26).astype(np.int64)
    found = carriers(vertices, triangles, garment)
    assert set(found[26:].tolist()) == {1}


def test_a_riding_piece_is_read_where_its_carrier_is() -> None:
    vertices, triangles = joined(strip(12, (0, 0, 0)), strip(2, (0, 0, 0.01), first=26))
    garment = np.zeros(len(vertices), dtype=np.int64)
    graph = ride(build(vertices, triangles, garment), vertices, triangles, garment)
    assert (graph.vertex_from_node[26:] == graph.vertex_from_node[1]).all()
    assert (graph.vertex_from_node_weight[26:] == graph.vertex_from_node_weight[1]).all()
