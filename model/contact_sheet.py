"""Draw every outfit of a running server in every preset pose on three bodies, to judge by eye.

    pip install pyvista trimesh
    xvfb-run -a python -m contact_sheet --server http://127.0.0.1:8080 --out ../docs/pictures

xvfb-run (Debian's xvfb) is for machines without a display.

Writes contact-sheet-{slim,average,heavy}.jpg: a row an outfit, a column a pose. Only what the service
answers is drawn: the GLBs of POST /v1/drapes.
"""

from __future__ import annotations

import argparse
import io
import json
from pathlib import Path
from urllib.request import Request, urlopen

import numpy as np
import pyvista
import trimesh
from PIL import Image

#: Bodies of POST /v1/drapes.
BODIES: dict[str, dict] = {
    "slim": {"kind": "phenotypes", "values": {"gender": 1.0, "weight": 0.15, "height": 0.4}},
    "average": {"kind": "phenotypes", "values": {}},
    "heavy": {"kind": "measurements", "values": {"height": 170, "weight": 105}},
}
CELL = (200, 300)
#: Of the camera, upright, degrees; share of the picture around the body that stays free.
VIEW_ANGLE, MARGIN = 28, 0.04
SKIN, CLOTH = "#d9b59b", ("#4f7ca8", "#b6504c", "#4f8f67", "#c9974a", "#77808c")


def get(server: str, path: str) -> dict:
    with urlopen(server + path) as answer:
        return json.load(answer)


def drape(server: str, outfit: str, body: dict, pose: str, method: str) -> trimesh.Scene:
    """The scene of one drape with its body."""
    request = {
        "outfit": outfit,
        "body": body,
        "pose": {"kind": "preset", "id": pose},
        "output": {"include": ["outfit", "body"], "method": method, "textures": False},
    }
    data = json.dumps(request).encode()
    with urlopen(Request(f"{server}/v1/drapes", data, {"content-type": "application/json"})) as answer:
        return trimesh.load(io.BytesIO(answer.read()), file_type="glb", process=False)


def picture(scene: trimesh.Scene, eye: tuple[float, float, float]) -> Image.Image:
    """One cell: the scene from `eye` (a direction), framed on the body."""
    plotter = pyvista.Plotter(off_screen=True, window_size=(CELL[0] * 2, CELL[1] * 2), border=False)
    colours = iter(CLOTH * 9)
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name].copy().apply_transform(transform)
        faces = np.hstack([np.full((len(mesh.faces), 1), 3), mesh.faces])
        colour = SKIN if node == "body" else next(colours)
        plotter.add_mesh(
            pyvista.PolyData(np.asarray(mesh.vertices), faces), color=colour, smooth_shading=True, specular=0.1
        )
    plotter.camera_position = framed(scene.to_geometry().vertices, np.array(eye))
    plotter.camera.view_angle = VIEW_ANGLE
    plotter.set_background("white")
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return Image.fromarray(image).resize(CELL, Image.Resampling.LANCZOS)


def framed(points: np.ndarray, eye: np.ndarray) -> list[tuple[float, ...]]:
    """Camera, focus and up from which all points (N, 3) are just in the picture, seen from `eye` (a direction)."""
    towards = eye / np.linalg.norm(eye)
    right = np.cross((0, 1, 0), towards) / np.linalg.norm(np.cross((0, 1, 0), towards))
    centre = (points.min(0) + points.max(0)) / 2
    across, along, depth = ((points - centre) @ np.stack([right, np.cross(towards, right), towards], 1)).T
    tall = np.tan(np.radians(VIEW_ANGLE / 2)) * (1 - MARGIN)
    wide = tall * CELL[0] / CELL[1]
    distance = (np.maximum(abs(along) / tall, abs(across) / wide) + depth).max()
    return [tuple(centre + towards * distance), tuple(centre), (0, 1, 0)]


def sheet(server: str, outfits: list[str], poses: list[str], body: dict, method: str) -> Image.Image:
    out = Image.new("RGB", (CELL[0] * len(poses), CELL[1] * len(outfits)), "white")
    for row, outfit in enumerate(outfits):
        for column, pose in enumerate(poses):
            cell = picture(drape(server, outfit, body, pose, method), (0.75, 0.25, 1.0))
            out.paste(cell, (CELL[0] * column, CELL[1] * row))
        print(f"{row + 1}/{len(outfits)} {outfit}", flush=True)
    return out


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--server", default="http://127.0.0.1:8080")
    p.add_argument("--out", type=Path, default=Path("../docs/pictures"))
    p.add_argument("--bodies", nargs="*", default=list(BODIES))
    p.add_argument("--poses", nargs="*")
    p.add_argument("--outfits", nargs="*")
    p.add_argument("--method", default="deepsd")
    a = p.parse_args()
    poses = a.poses or [pose["id"] for pose in get(a.server, "/v1/poses")["data"]]
    outfits = a.outfits or [outfit["id"] for outfit in get(a.server, "/v1/outfits?limit=100")["data"]]
    a.out.mkdir(parents=True, exist_ok=True)
    for name in a.bodies:
        sheet(a.server, outfits, poses, BODIES[name], a.method).save(a.out / f"contact-sheet-{name}.jpg", quality=82)


if __name__ == "__main__":
    main()
