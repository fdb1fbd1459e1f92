"""Bake the measurements into `artifacts/body.safetensors`: `python -m body.bake_measurements`.

Adds the surface points of every tape, and a coarse closed mesh whose volume stands for the body's: its
vertices are some of the body's own, and a line fitted over random adults corrects what it cuts off.
"""

from __future__ import annotations

import json

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from safetensors import safe_open
from safetensors.numpy import save_file
from scipy.spatial import cKDTree

from body.anny_body import ARTIFACT, AnnyBody
from body.measurements import KILOGRAMS_PER_M3, MEASUREMENTS, main_component, tapes
from body.measuring import Tape, volume

Array = NDArray[np.float64]
COARSE_SHARE = 0.12  # of the skin's triangles that the coarse mesh keeps
FITTED_BODIES, TAPED_BODIES = 400, 48


def random_adult(rng: np.random.Generator, body: AnnyBody, local: float = 0.4) -> tuple[dict, dict]:
    """Phenotypes and local changes of a random adult."""
    phenotypes = {p: float(rng.uniform(0.05, 0.95)) for p in body.phenotypes} | {"age": body.meta["reference_age"]}
    phenotypes["height"] = float(rng.uniform(0.25, 0.65))
    return phenotypes, {name: float(np.clip(rng.normal(0, local), -1, 1)) for name in body.local_changes}


def coarse_mesh(body: AnnyBody) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Vertices of the body (N,) and triangles among them (T, 3): the skin, decimated, corners snapped to
    the skin's own vertices. It stays closed, because a triangle that collapses takes its neighbours' sides along."""
    triangles = body.triangles[main_component(body)[body.triangles[:, 0]]]
    own, local = np.unique(triangles, return_inverse=True)
    faces = np.hstack([np.full((len(triangles), 1), 3), local.reshape(-1, 3)])
    positions = body.shape().rest_vertices[own]
    coarse = pv.PolyData(positions, faces).decimate(1 - COARSE_SHARE, volume_preservation=True)
    nearest = cKDTree(positions).query(coarse.points)[1]
    kept, corners = np.unique(nearest, return_inverse=True)
    corners = corners[coarse.regular_faces].reshape(-1, 3)
    proper = (corners != np.roll(corners, 1, 1)).all(1)
    return own[kept].astype(np.int32), corners[proper].astype(np.int32)


def fitted_volume(body: AnnyBody, vertices: NDArray, triangles: NDArray) -> tuple[float, float, float]:
    """Scale and offset from coarse to whole volume, and the largest relative error left, over random adults."""
    rng = np.random.default_rng(1)
    skin = body.triangles[main_component(body)[body.triangles[:, 0]]]
    whole, coarse = np.zeros(FITTED_BODIES), np.zeros(FITTED_BODIES)
    for k in range(FITTED_BODIES):
        rest = body.shape(*random_adult(rng, body)).rest_vertices
        whole[k], coarse[k] = volume(rest, skin), volume(rest[vertices], triangles)
    half = FITTED_BODIES // 2
    scale, offset = np.polyfit(coarse[:half], whole[:half], 1)
    error = np.abs(coarse * scale + offset - whole)[half:] / whole[half:]
    return float(scale), float(offset), float(error.max())


def bake() -> dict:
    """Add the tensors and the metadata to the body's file; the metadata that was written."""
    body = AnnyBody.load()
    with safe_open(ARTIFACT, "numpy") as f:
        data = {k: f.get_tensor(k) for k in f.keys()}  # noqa: SIM118
    rng = np.random.default_rng(2)
    points = tapes(body, [body.shape(*random_adult(rng, body)).rest_vertices for _ in range(TAPED_BODIES)])
    ends = np.cumsum([len(p.t) for p in points])
    data["measure_points"] = np.concatenate([p.vertices for p in points]).astype(np.int32)
    data["measure_t"] = np.concatenate([p.t for p in points]).astype(np.float32)
    data["measure_ranges"] = np.stack([np.append(0, ends[:-1]), ends], 1).astype(np.int32)
    data["volume_vertices"], data["volume_triangles"] = coarse_mesh(body)
    scale, offset, error = fitted_volume(body, data["volume_vertices"], data["volume_triangles"])
    meta = body.meta | {
        "measurements": [
            {"name": m.name, "label": m.label, "kind": m.kind, "unit": "kg" if m.kind == "weight" else "cm",
             "min": m.low, "max": m.high, "description": m.description}
            for m in MEASUREMENTS
        ],
        "volume": {"density": KILOGRAMS_PER_M3, "scale": scale, "offset": offset, "max_error": round(error, 5)},
    }  # fmt: skip
    defaults = Tape(AnnyBody(data, meta)).measure(body.coefficients())
    for entry, value in zip(meta["measurements"], defaults, strict=True):
        entry["default"] = round(float(value), 1)
    save_file(data, ARTIFACT, {"toile": json.dumps(meta)})
    AnnyBody.load.cache_clear()
    return meta


def main() -> None:
    meta = bake()
    print(json.dumps(meta["volume"]))
    for m in meta["measurements"]:
        print(f"{m['name']:16} {m['kind']:9} {m['min']:5} {m['max']:5} default {m['default']}")


if __name__ == "__main__":
    main()
