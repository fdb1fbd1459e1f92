"""Generated outfits: same seed, same cloth; clear of the body; layers in order; sound meshes; a gallery that parses."""

from __future__ import annotations

import json
import struct
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody
from outfits.body_fields import body_fields
from outfits.dataset import jobs, save
from outfits.families import ORNAMENTED, TRAIN, TRAIN_ORDER, VALIDATION
from outfits.generate import generate
from outfits.mesh import OutfitMesh, components, corner_angles, edges_of, face_normals
from outfits.snug import REACH, snug

GALLERY = Path(__file__).parents[1] / "artifacts" / "gallery"
CASES = (("tee_shorts", 3), ("shirt_tie_trousers", 5), ("jacket_tank_skirt", 8), ("halter_culottes", 1_000_003))
LOOSE_PIECES = ("tie", "bow")


@lru_cache(8)
def outfit(family: str, seed: int) -> OutfitMesh:
    return generate(seed, family, vertices=450)


@lru_cache(1)
def skin() -> tuple[np.ndarray, np.ndarray]:
    model = AnnyBody.load()
    return model.shape().apose_vertices, model.triangles


def signed_distance(p: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Exact signed distance to the nearest of 24 candidate triangles, and whether its foot lies inside one."""
    corners = vertices[triangles]
    _, near = cKDTree(corners.mean(1)).query(p, k=min(24, len(triangles)))
    a, b, c = (corners[near][:, :, k] for k in range(3))
    q = p[:, None]
    foot, inside = _closest(q, a, b, c)
    normal = np.cross(b - a, c - a)
    offset = q - foot
    far = np.linalg.norm(offset, axis=2)
    # Where several triangles tie (edges, corners), the one that the point faces most decides the side.
    facing = (offset * normal).sum(2) / np.maximum(np.linalg.norm(normal, axis=2) * far, 1e-15)
    tie = far <= far.min(1, keepdims=True) + 1e-9
    best = np.where(tie, np.abs(facing), -1).argmax(1)
    rows = np.arange(len(p))
    return np.copysign(far[rows, best], facing[rows, best]), inside[rows, best]


def _closest(q: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    n = np.cross(b - a, c - a)
    area = np.maximum((n * n).sum(-1), 1e-20)
    weights = np.stack([(np.cross(v - u, q - u) * n).sum(-1) / area for u, v in ((b, c), (c, a), (a, b))], -1)
    inside = (weights >= 0).all(-1)
    flat = weights[..., :1] * a + weights[..., 1:2] * b + weights[..., 2:] * c
    best = np.where(inside[..., None], flat, a)
    distance = np.where(inside, np.linalg.norm(q - flat, axis=-1), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        t = np.clip(((q - u) * (v - u)).sum(-1) / np.maximum(((v - u) ** 2).sum(-1), 1e-20), 0, 1)
        on_edge = u + t[..., None] * (v - u)
        d = np.linalg.norm(q - on_edge, axis=-1)
        closer = d < distance
        best, distance = np.where(closer[..., None], on_edge, best), np.where(closer, d, distance)
    return best, inside


def probes(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    return np.concatenate([vertices, vertices[triangles].mean(1)])


def test_same_seed_gives_the_same_outfit_and_another_seed_another() -> None:
    first, again, other = (generate(s, "tank", vertices=300) for s in (11, 11, 12))
    np.testing.assert_array_equal(first.garments[0].vertices, again.garments[0].vertices)
    np.testing.assert_array_equal(first.garments[0].triangles, again.garments[0].triangles)
    assert first.garments[0].vertices.shape != other.garments[0].vertices.shape


def test_a_tight_variant_lies_nearer_and_never_in_the_skin() -> None:
    model = AnnyBody.load()
    fields = body_fields(model, model.shape())
    loose = generate(11, "tank", vertices=300)
    tight = snug(loose, fields)
    before, after = (fields.clearance(o.garments[0].vertices)[0] for o in (loose, tight))
    near = before < 0.5 * REACH
    assert near.any()
    assert (after > 0).all()
    assert after[near].mean() < 0.8 * before[near].mean()
    np.testing.assert_array_equal(before[before > REACH], after[before > REACH])


def test_unknown_family_is_refused() -> None:
    with pytest.raises(KeyError):
        generate(0, "toga")


def test_validation_families_are_not_trained_on() -> None:
    assert len(VALIDATION) >= 4
    assert not set(VALIDATION) & set(TRAIN)
    planned = jobs(120, 24, Path("x"))
    trained = {f for _, f, path in planned if "train" in path}
    assert trained == set(TRAIN_ORDER) | set(ORNAMENTED)
    assert {f for _, f, path in planned if "validation" in path} == set(VALIDATION)


@pytest.mark.parametrize(("family", "seed"), CASES)
def test_cloth_keeps_clear_of_the_skin(family: str, seed: int) -> None:
    for garment in outfit(family, seed).garments:
        distance, _ = signed_distance(probes(garment.vertices, garment.triangles), *skin())
        assert distance.min() > 0.002, garment.name
        assert np.percentile(distance, 1) > 0.0035, garment.name


@pytest.mark.parametrize(("family", "seed"), CASES)
def test_layers_lie_in_order(family: str, seed: int) -> None:
    garments = outfit(family, seed).garments
    assert [g.layer for g in garments] == list(range(len(garments)))
    compared = 0
    for k, outer in enumerate(garments):
        for inner in garments[:k]:
            distance, above = signed_distance(probes(outer.vertices, outer.triangles), inner.vertices, inner.triangles)
            covered = above & (np.abs(distance) < 0.02)
            compared += int(covered.sum())
            assert (distance[covered] > 0.0025).all(), f"{outer.name} over {inner.name}"
    assert compared > 50


@pytest.mark.parametrize(("family", "seed"), CASES)
def test_meshes_are_oriented_manifolds_without_slivers(family: str, seed: int) -> None:
    for garment in outfit(family, seed).garments:
        v, t = garment.vertices, garment.triangles
        assert np.isfinite(v).all()
        assert len(np.unique(t)) == len(v)
        assert np.linalg.norm(face_normals(v, t), axis=1).min() > 1e-7
        assert edges_of(t)[2].max() <= 2
        directed = t[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        assert len(np.unique(directed, axis=0)) == len(directed)
        if garment.kind not in LOOSE_PIECES:
            assert components(t, len(v)).max() == 0
            assert (corner_angles(v, t).min(1) > 15).mean() >= 0.995, garment.name


@pytest.mark.parametrize(("family", "seed"), CASES)
def test_texture_coordinates_follow_the_triangles(family: str, seed: int) -> None:
    for garment in outfit(family, seed).garments:
        corner = np.full(len(garment.uv), -1)
        corner[garment.uv_triangles.ravel()] = garment.triangles.ravel()
        np.testing.assert_array_equal(corner[garment.uv_triangles], garment.triangles)
        a, b, c = (garment.uv[garment.uv_triangles[:, k]] for k in range(3))
        flat = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        stretch = flat / np.linalg.norm(face_normals(garment.vertices, garment.triangles), axis=1)
        assert 0.5 < np.median(stretch) < 1.6, garment.name


def test_a_saved_outfit_reads_back(tmp_path: Path) -> None:
    made = outfit(*CASES[0])
    save(made, tmp_path / "one.npz")
    data = np.load(tmp_path / "one.npz")
    assert len(data["vertices"]) == len(data["garment"]) == made.vertex_count
    assert list(data["garment_names"]) == [g.name for g in made.garments]
    for k, garment in enumerate(made.garments):
        mine = data["garment"][data["triangles"]] == k
        assert mine.all(1).sum() == mine.any(1).sum() == len(garment.triangles)
    assert not list(tmp_path.glob("*.partial*"))


def read_glb(path: Path) -> tuple[dict, bytes]:
    data = path.read_bytes()
    magic, version, size = struct.unpack_from("<4sII", data)
    assert (magic, version, size) == (b"glTF", 2, len(data))
    length, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    rest, kind = struct.unpack_from("<I4s", data, 20 + length)
    assert kind == b"BIN\0"
    assert 28 + length + rest == size
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def accessor(document: dict, blob: bytes, index: int) -> np.ndarray:
    a = document["accessors"][index]
    view = document["bufferViews"][a["bufferView"]]
    dtype = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[a["componentType"]]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[a["type"]]
    values = np.frombuffer(blob[view["byteOffset"] : view["byteOffset"] + view["byteLength"]], dtype)
    assert len(values) == a["count"] * width
    return values.reshape(-1, width)


def test_gallery_files_parse_and_match_their_index() -> None:
    entries = json.loads((GALLERY / "gallery.json").read_text())
    assert len(entries) >= 12
    assert {e["file"] for e in entries} == {p.name for p in GALLERY.glob("*.glb")}
    for entry in entries:
        with Image.open((GALLERY / entry["file"]).with_suffix(".png")) as picture:
            assert picture.size == (384, 480)
        document, blob = read_glb(GALLERY / entry["file"])
        assert [n["name"] for n in document["nodes"]] == entry["layers"]
        triangles = 0
        for mesh in document["meshes"]:
            primitive = mesh["primitives"][0]
            p, n, uv = (
                accessor(document, blob, primitive["attributes"][k]) for k in ("POSITION", "NORMAL", "TEXCOORD_0")
            )
            indices = accessor(document, blob, primitive["indices"])
            assert indices.max() < len(p) == len(n) == len(uv)
            assert np.isfinite(uv).all()
            np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1, atol=1e-3)
            triangles += len(indices) // 3
        assert triangles == entry["triangles"]
        for material in document["materials"]:
            assert material["doubleSided"] and "KHR_materials_sheen" in material["extensions"]
        for image in document["images"]:
            start = document["bufferViews"][image["bufferView"]]["byteOffset"]
            assert blob[start : start + 2] == b"\xff\xd8"


def test_gallery_shows_what_it_must() -> None:
    entries = json.loads((GALLERY / "gallery.json").read_text())
    layers = [set(e["layers"]) for e in entries]
    assert any(len(e["layers"]) >= 3 for e in entries)
    for needed in ("flared skirt", "dress", "jumpsuit", "jacket", "tie", "bow", "belt", "collar"):
        assert any(needed in names for names in layers), needed
    benchmark = [e for e in entries if e.get("benchmark")]
    assert len(benchmark) == 1 and 13_000 <= benchmark[0]["vertices"] <= 15_500
    assert all(2_000 <= e["vertices"] <= 15_500 for e in entries)
    assert sum((GALLERY / e["file"]).stat().st_size for e in entries) < 6_000_000
