"""Cloth laid flat keeps its lengths, and as an image its shape."""

from __future__ import annotations

import numpy as np
import pytest

from body.anny_body import AnnyBody
from garment.cloth_image import SIZE, ClothImages, Panel, cloth_images
from garment.flat import flattened, stretch
from outfits.body_fields import BodyFields, body_fields
from outfits.garnet_garments import garnet_garment
from outfits.mesh import GarmentMesh
from outfits.panels import front_and_back


def sheet(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """A grid of the unit square, (N, 2), and its triangles."""
    x, y = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    a, b, c, d = first, first + 1, first + columns, first + columns + 1
    return np.stack([x.ravel(), y.ravel()], 1), np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])


@pytest.fixture(scope="module")
def body() -> BodyFields:
    model = AnnyBody.load()
    return body_fields(model, model.shape())


@pytest.fixture(scope="module")
def tee(body: BodyFields) -> tuple[GarmentMesh, tuple[Panel, Panel]]:
    garment = garnet_garment("tee", 3000).garments[0]
    return garment, front_and_back(garment, body)


@pytest.fixture(scope="module")
def images(tee: tuple[GarmentMesh, tuple[Panel, Panel]]) -> ClothImages:
    garment, panels = tee
    return cloth_images(list(panels), len(garment.vertices))


def test_what_was_bent_only_lies_flat_without_stretch() -> None:
    uv, triangles = sheet(20, 12)
    bent = np.stack([0.3 * np.sin(3 * uv[:, 0]), uv[:, 1] * 0.8, 0.3 * np.cos(3 * uv[:, 0])], 1)
    found = stretch(bent, triangles, flattened(bent, triangles))
    np.testing.assert_allclose(found, 1, atol=2e-3)


def test_a_dome_stretches_and_is_not_turned_over() -> None:
    uv, triangles = sheet(15, 15)
    flat = 1.4 * (uv - 0.5)
    dome = np.stack([flat[:, 0], flat[:, 1], np.sqrt(1 - (flat**2).sum(1))], 1)
    found = stretch(dome, triangles, flattened(dome, triangles))
    assert found.min() > 0.6
    assert 0.02 < np.abs(found - 1).mean() < 0.15


def test_a_closed_piece_says_what_to_do() -> None:
    tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    with pytest.raises(ValueError, match="cut it open"):
        flattened(np.eye(4)[:, :3], tetrahedron)


def test_a_tee_lies_flat_as_front_and_back(tee: tuple[GarmentMesh, tuple[Panel, Panel]]) -> None:
    garment, panels = tee
    assert sum(len(p.triangles) for p in panels) == len(garment.triangles)
    for panel, facing in zip(panels, (1, -1), strict=True):
        rest = garment.vertices[panel.vertices]
        found = stretch(rest, panel.triangles, panel.places)
        assert np.abs(found - 1).mean() < 0.04
        assert np.percentile(np.abs(found - 1), 99) < 0.2
        assert found.min() > 0, "no triangle is turned over"
        assert np.corrcoef(rest[:, 1], panel.places[:, 1])[0, 1] > 0.98, "it is upright"
        assert np.corrcoef(facing * rest[:, 0], panel.places[:, 0])[0, 1] > 0.98, "it is seen from outside"


def test_images_are_on_the_cloth_and_a_little_around_it(images: ClothImages) -> None:
    assert images.mask.shape == (2, SIZE, SIZE)
    assert (images.mask | ~images.cloth).all()
    assert images.mask.sum() > images.cloth.sum() > 0.3 * images.mask.size
    assert not images.mask[:, [0, -1]].any()
    assert not images.mask[:, :, [0, -1]].any()


def test_what_changes_evenly_comes_back_exactly(tee: tuple[GarmentMesh, tuple[Panel, Panel]]) -> None:
    """Pixels beside the cloth go on as the cloth does, so that not even its edge is off."""
    for panel in tee[1]:
        own = cloth_images([Panel(np.arange(len(panel.vertices)), panel.triangles, panel.places)], len(panel.vertices))
        even = panel.places @ [[1.0, 0.2, -2.0], [0.3, -1.0, 0.5]] + 0.1
        np.testing.assert_allclose(own.values(own.images(even)), even, atol=1e-9)


def test_cloth_comes_back_from_its_images(tee: tuple[GarmentMesh, tuple[Panel, Panel]], images: ClothImages) -> None:
    """The method's floor: folds of 8 cm and 1 cm depth, and the rest pose itself."""
    garment, _ = tee
    v = garment.vertices
    folds = np.stack([0.005 * np.sin(2 * np.pi * v[:, k] / 0.08) for k in (0, 1, 2)], 1)
    for values in (v, folds):
        back = images.joined(images.values(images.images(values[images.vertex])))
        error = np.linalg.norm(back - values, axis=1)
        assert error.mean() < 3e-4
        assert np.percentile(error, 99) < 6e-4
        # Where sleeve and side meet, the cut is narrower than a pixel and a vertex reads across it.
        assert error.max() < 5e-3


def test_a_vertex_on_no_panel_is_told(tee: tuple[GarmentMesh, tuple[Panel, Panel]]) -> None:
    garment, (front, _) = tee
    with pytest.raises(ValueError, match="on no panel"):
        cloth_images([front], len(garment.vertices))
