"""A scan, the body of its parameters, its own surface, and what is draped on that: `python -m figures.scans`.

Needs a running server with the demo outfits (`make run`). Into docs/pictures/scan.jpg.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from PIL import Image

from body.anny_body import AnnyBody
from evaluate_scans import NOISE, Service, obj

from .drawing import Drawn, cell, grid, of_glb

OUT = Path(__file__).parents[2] / "docs" / "pictures" / "scan.jpg"
PERSON = {"gender": 0.1, "weight": 0.6, "height": 0.45}
#: A belly that no parameter has: where, how deep and how wide, metres.
BELLY, DEEP, WIDE = (0.0, 1.10, 0.14), 0.06, 0.11


def scan(body: AnnyBody) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of a person with a belly: a twelfth of the triangles missing, 2 mm of noise."""
    rng = np.random.default_rng(4)
    v = body.shape(PERSON).apose_vertices
    out = np.exp(-((v - BELLY) ** 2).sum(1) / WIDE**2) * DEEP
    v = v + out[:, None] * [0, 0, 1] + rng.normal(0, NOISE, v.shape)
    return v, body.triangles[rng.random(len(body.triangles)) > 1 / 12]


def draped(service: Service, outfit: str, body: dict, include: list[str], folder: Path) -> Image.Image:
    request = {"outfit": outfit, "body": body, "output": {"include": include}}
    path = folder / "scan.glb"
    path.write_bytes(service.post("/v1/drapes", json.dumps(request).encode(), "application/json"))
    return cell(of_glb(path), turn=80)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--server", default="http://127.0.0.1:8080")
    p.add_argument("--outfit", required=True, help="id of an outfit of the server")
    p.add_argument("--out", type=Path, default=OUT)
    a = p.parse_args()
    service, (vertices, triangles) = Service(a.server, "deepsd"), scan(AnnyBody.load())
    found = service.upload("/v1/bodies", obj(vertices, triangles, "scan"), {})
    print({name: round(m["achieved"], 1) for name, m in found["measurements"].items()}, found["scan"])
    parameters = {"kind": "phenotypes", "values": found["phenotypes"] | found["local_changes"]}
    folder = a.out.parent
    pictures = [
        cell([Drawn(vertices, triangles, edges=False)], turn=80),
        draped(service, a.outfit, parameters, ["body"], folder),
        draped(service, a.outfit, found["shape"], ["body"], folder),
        draped(service, a.outfit, found["shape"], ["body", "outfit"], folder),
    ]
    (folder / "scan.glb").unlink()
    grid([pictures], ("scan", "by its parameters", "with its surface", "dressed")).save(a.out, quality=88)


if __name__ == "__main__":
    main()
