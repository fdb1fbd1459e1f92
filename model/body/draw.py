"""Draw the presets, the walk and the tapes to check by eye: `python -m body.draw` (needs pyvista).

Writes `docs/pictures/{poses,walk,measurements}.png`.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image

from body.anny_body import AnnyBody, ShapedBody
from body.humanoid import posed_world
from body.measuring import Tape
from body.poses import OUT as POSES

Array = NDArray[np.float64]
PICTURES = Path(__file__).parents[2] / "docs" / "pictures"
SKIN, RING, LINE, PAPER = "#d8b59c", "#c0223b", "#1f3f8f", "#f7f5f2"
BODIES = ({"weight": 0.1, "gender": 0.9}, {}, {"weight": 1.0, "muscle": 0.15, "gender": 0.7})
FRONT, SIDE, BACK = np.array([0.25, 0.1, 1.0]), np.array([1.0, 0.1, 0.2]), np.array([-0.35, 0.12, -1.0])
CELL = 190, 300


def surface(body: AnnyBody, vertices: Array) -> pv.PolyData:
    return pv.PolyData(vertices, np.hstack([np.full((len(body.triangles), 1), 3), body.triangles]))


def plotter(rows: int, columns: int, cell: tuple[int, int] = CELL) -> pv.Plotter:
    size = (columns * cell[0], rows * cell[1])
    plot = pv.Plotter(off_screen=True, window_size=size, shape=(rows, columns), border=False)
    plot.set_background(PAPER)
    return plot


def save(plot: pv.Plotter, name: str) -> None:
    """Write the picture with 96 colours, which is plenty for one skin and keeps it small."""
    picture = Image.fromarray(plot.screenshot(return_img=True))
    picture.quantize(96, dither=Image.Dither.NONE).save(PICTURES / f"{name}.png", optimize=True)


def look(plot: pv.Plotter, towards: Array, middle: float, half_height: float) -> None:
    centre = np.array([0.0, middle, 0.0])
    plot.camera_position = [centre + towards * 4, centre, (0, 1, 0)]
    plot.camera.parallel_projection = True
    plot.camera.parallel_scale = half_height


def draw_posed(plot: pv.Plotter, body: AnnyBody, shaped: ShapedBody, pose: dict) -> None:
    """One posed body on its floor, in the current cell."""
    world = posed_world(body, shaped, pose["rotations"], pose["root_translation"])
    plot.add_mesh(surface(body, body.pose(shaped, world)), color=SKIN, smooth_shading=True)
    plot.add_mesh(pv.Disc(center=(0, 0, 0), inner=0.0, outer=0.62, normal=(0, 1, 0), c_res=48), color="#e4dfd8")


def draw_poses(body: AnnyBody, poses: list[dict]) -> None:
    """A row for two presets: three bodies each, front and side."""
    shapes = [body.shape(values) for values in BODIES]
    plot = plotter((len(poses) + 1) // 2, 12)
    for k, pose in enumerate(poses):
        for column, shaped in enumerate(shapes):
            for half, towards in enumerate((FRONT, SIDE)):
                plot.subplot(k // 2, (k % 2) * 6 + column * 2 + half)
                draw_posed(plot, body, shaped, pose)
                look(plot, towards, 1.0, 1.2)
                if column == half == 0:
                    plot.add_text(pose["id"], font_size=9, color="black")
    save(plot, "poses")


def draw_walk(body: AnnyBody, frames: list[dict]) -> None:
    """Every second frame of the walk, from the side and the front."""
    shaped, shown = body.shape(), frames[::2]
    plot = plotter(2, len(shown), (110, 260))
    for column, frame in enumerate(shown):
        for row, towards in enumerate((np.array([1.0, 0.05, 0]), np.array([0.0, 0.05, 1]))):
            plot.subplot(row, column)
            draw_posed(plot, body, shaped, frame)
            look(plot, towards, 0.95, 1.1)
    save(plot, "walk")


def draw_measurements(body: AnnyBody) -> None:
    """The tapes on the reference body at rest, from the front, the side and the back."""
    tape, rest = Tape(body), body.shape().rest_vertices
    points = tape.points + np.tensordot(body.coefficients(), tape.point_basis, 1)
    plot = plotter(1, 3, (680, 860))
    for column, towards in enumerate((np.array([0.0, 0.02, 1]), SIDE, BACK)):
        plot.subplot(0, column)
        plot.add_mesh(surface(body, rest), color=SKIN, smooth_shading=True)
        labels = [
            draw_tape(plot, entry, points[start:end])
            for entry, (start, end) in zip(tape.entries, tape.ranges, strict=True)
        ]
        if column == 0:
            shown = [(at, text) for at, text in labels if text]
            plot.add_point_labels(
                np.array([at for at, _ in shown]), [text for _, text in shown], font_size=15, text_color="black",
                shape_opacity=0.75, shape_color="white", show_points=False, always_visible=True,
            )  # fmt: skip
        look(plot, towards, 0.1, 1.02)
    save(plot, "measurements")


def draw_tape(plot: pv.Plotter, entry: dict, points: Array) -> tuple[Array, str]:
    """A tape as a tube; where its label goes, and the label."""
    if entry["kind"] == "weight":
        return np.array([-0.62, 0.92, 0.3]), f"{entry['label']} {entry['default']} kg"
    text = f"{entry['label']} {entry['default']} cm"
    if entry["kind"] == "height":
        x = 0.62 if entry["name"] == "height" else 0.0
        line = np.array([[x, points[0, 1], points[0, 2]], [x, points[1:, 1].mean(), points[0, 2]]])
        plot.add_mesh(pv.lines_from_points(line).tube(radius=0.004), color=LINE)
        return line.mean(0) + np.array([-0.3 if x else 0.0, -0.1, 0.1]), text
    if entry["name"] == "shoulder_width":
        points = points + np.array([0, 0, 0.12])  # drawn in front of the neck that it runs through
    closed = np.vstack([points, points[:1]]) if entry["kind"] == "ring" else points
    plot.add_mesh(pv.lines_from_points(closed).tube(radius=0.004), color=RING if entry["kind"] == "ring" else LINE)
    at = points[np.argmax(points[:, 0])] if entry["name"] != "arm_length" else points[1]
    return at + np.array([0.0, 0.012, 0.1]), text


def main() -> None:
    PICTURES.mkdir(parents=True, exist_ok=True)
    body, data = AnnyBody.load(), json.loads(POSES.read_text())
    draw_poses(body, data["poses"])
    draw_walk(body, data["motions"][0]["frames"])
    draw_measurements(body)


if __name__ == "__main__":
    main()
