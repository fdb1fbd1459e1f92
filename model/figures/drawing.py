"""Meshes into cells of a picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyvista
import trimesh
from numpy.typing import NDArray
from PIL import Image, ImageDraw

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]

CELL = (240, 330)
SKIN, CLOTH = "#d9b59b", ("#4f7ca8", "#b6504c", "#4f8f67", "#c9974a", "#77808c")


@dataclass(frozen=True)
class Drawn:
    """A mesh and its look: one colour, or one for each vertex."""

    vertices: Floats  # (N, 3)
    triangles: Ints  # (T, 3)
    colour: str = SKIN
    vertex_colours: Floats | None = None  # (N, 3), 0 to 1
    edges: bool = False


def cell(meshes: list[Drawn], turn: float = 35.0) -> Image.Image:
    """Meshes from the front, turned by degrees about the vertical, framed on all of them."""
    plotter = pyvista.Plotter(off_screen=True, window_size=(CELL[0] * 2, CELL[1] * 2), border=False)
    for mesh in meshes:
        faces = np.hstack([np.full((len(mesh.triangles), 1), 3), mesh.triangles])
        surface = pyvista.PolyData(np.asarray(mesh.vertices, float), faces)
        look = {"smooth_shading": not mesh.edges, "specular": 0.1, "show_edges": mesh.edges, "edge_opacity": 0.35}
        if mesh.vertex_colours is None:
            plotter.add_mesh(surface, color=mesh.colour, **look)
        else:
            surface["colour"] = (255 * mesh.vertex_colours.clip(0, 1)).astype(np.uint8)
            plotter.add_mesh(surface, scalars="colour", rgb=True, **look)
    points = np.concatenate([m.vertices for m in meshes])
    low, high = points.min(0), points.max(0)
    centre, eye = (low + high) / 2, np.array([np.sin(np.radians(turn)), 0.2, np.cos(np.radians(turn))])
    distance = 1.2 * max(high[1] - low[1], 1.5 * (high[0] - low[0])) / 0.5
    plotter.camera_position = [tuple(centre + eye / np.linalg.norm(eye) * distance), tuple(centre), (0, 1, 0)]
    plotter.camera.view_angle = 28
    plotter.set_background("white")
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return Image.fromarray(image).resize(CELL, Image.Resampling.LANCZOS)


def grid(rows: list[list[Image.Image]], columns: tuple[str, ...] = (), names: tuple[str, ...] = ()) -> Image.Image:
    """Cells in rows, with titles over the columns and names in the rows' corners."""
    out = Image.new("RGB", (CELL[0] * max(map(len, rows)), CELL[1] * len(rows) + 24), "white")
    draw = ImageDraw.Draw(out)
    for r, row in enumerate(rows):
        for c, image in enumerate(row):
            out.paste(image, (CELL[0] * c, CELL[1] * r + 24))
    for c, title in enumerate(columns):
        draw.text((CELL[0] * c + 8, 6), title, fill="black", font_size=14)
    for r, name in enumerate(names):
        draw.text((8, CELL[1] * r + 28), name, fill="black", font_size=14)
    return out


def by_garment(vertices: Floats, triangles: Ints, garment: Ints, edges: bool = False) -> list[Drawn]:
    """Every garment in a colour of its own."""
    of = garment[triangles[:, 0]]
    return [Drawn(vertices, triangles[of == g], CLOTH[int(g) % len(CLOTH)], edges=edges) for g in np.unique(garment)]


def of_glb(path: Path, edges: bool = False) -> list[Drawn]:
    """The meshes of one of the service's GLBs: its body, and every garment in a colour of its own."""
    scene = trimesh.load(path, process=False)
    meshes, colours = [], iter(CLOTH * 9)
    for node in sorted(scene.graph.nodes_geometry):
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry].copy().apply_transform(transform)
        of_body = node == "body"
        colour = SKIN if of_body else next(colours)
        meshes.append(Drawn(np.asarray(mesh.vertices), mesh.faces, colour, edges=edges and not of_body))
    return meshes
