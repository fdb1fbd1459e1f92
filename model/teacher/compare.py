"""The judge's table: how far the service's drapes are from simulated ones, as DeePSD's Tables 1 and 3.

    python -m teacher.compare

On every good drape of `teacher.drapes`. Error: mean distance of the vertices to the teacher's, mm. Edge: mean
|length - rest length|, mm and percent. Bend: mean 1 - cosine of neighbouring normals. Inside: vertices behind the
plane of the nearest body vertex, percent. Means over each outfit's drapes, then over outfits; error with its 95th
percentile over drapes.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import astuple, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody, vertex_normals
from garment.graph import mesh_edges
from garment.rest_mesh import hinges

from .checks import good, lengths
from .drapes import TEACHER, Size, draped, faults, folders_in, runs

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]


@dataclass(frozen=True)
class Figures:
    """Of one drape."""

    error: float  # mm
    edge: float  # mm
    edge_percent: float
    bend: float
    inside: float  # percent


@dataclass(frozen=True)
class Scene:
    """What a drape is measured against."""

    rest: Floats  # (N, 3) A-pose
    triangles: Ints  # (T, 3)
    skin: Floats  # (V, 3) posed
    skin_triangles: Ints

    def figures(self, x: Floats, teacher: Floats) -> Figures:
        """Figures of cloth x (N, 3)."""
        edges, pairs = mesh_edges(self.triangles), hinges(self.triangles)
        rest, now = lengths(self.rest, edges), lengths(x, edges)
        a, b = (unit_normals(x[pairs[:, 0]], x[pairs[:, 1]], x[pairs[:, k]]) for k in (2, 3))
        hit = cKDTree(self.skin).query(x)[1]
        normals = vertex_normals(self.skin, self.skin_triangles)[hit]
        return Figures(
            error=1e3 * float(np.linalg.norm(x - teacher, axis=1).mean()),
            edge=1e3 * float(np.abs(now - rest).mean()),
            edge_percent=100 * float(np.abs(now / np.maximum(rest, 1e-5) - 1).mean()),
            bend=float((1 + (a * b).sum(1)).mean()),
            inside=100 * float((((x - self.skin[hit]) * normals).sum(1) < 0).mean()),
        )


def unit_normals(a: Floats, b: Floats, c: Floats) -> Floats:
    """Of triangles, (K, 3)."""
    normal = np.cross(b - a, c - a)
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)


METHODS = ("skinning", "deepsd", "deepsd-concat")


def compare(folder: Path, methods: tuple[str, ...] = METHODS) -> Iterator[tuple[str, int, Figures]]:
    """Every way to drape, body, and figures, for every good drape of a folder."""
    skin_triangles = AnnyBody.load().triangles
    ways = {m: draped(folder, m) for m in methods}
    first = ways[methods[0]]
    triangles = first["triangles"].astype(np.int64)
    bodies, poses = first["draped"].shape[:2]
    for run in runs([folder], Size(1, bodies, poses)):
        teacher, b, p = good(replace(run, perturbed=False).path), run.body, run.pose
        if teacher is None:
            continue
        scene = Scene(first["rest"][b], triangles, first["body"][b, p], skin_triangles)
        if run.perturbed:
            again = good(run.path)
            if again is not None:
                yield "teacher again, from a start moved by 2 mm", b, scene.figures(again, teacher)
            continue
        for name, way in ways.items():
            yield f"{name}, before the resolve", b, scene.figures(way["draped"][b, p], teacher)
        if "deepsd" in ways:
            yield "deepsd, after the resolve", b, scene.figures(ways["deepsd"]["resolved"][b, p], teacher)
        yield "teacher", b, scene.figures(teacher, teacher)


def table(found: dict[str, dict[str, list[Figures]]]) -> Iterator[str]:
    """Markdown rows of figures by way and outfit."""
    yield "| | error mm | p95 | edge mm | edge % | bend | inside % | drapes |"
    yield "|---|---:|---:|---:|---:|---:|---:|---:|"
    for way, outfits in found.items():
        means = np.mean([np.mean([astuple(f) for f in drapes], 0) for drapes in outfits.values()], 0)
        all_errors = [f.error for drapes in outfits.values() for f in drapes]
        error, edge, percent, bend, inside = means
        p95 = np.quantile(all_errors, 0.95)
        yield (
            f"| {way} | {error:.1f} | {p95:.1f} | {edge:.2f} | {percent:.1f} | {bend:.4f} | {inside:.2f} "
            f"| {len(all_errors)} |"
        )


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--drapes", type=Path, default=TEACHER)
    a = p.parse_args()
    found: dict[str, dict[str, list[Figures]]] = {}
    folders = folders_in(a.drapes)
    for folder in folders:
        for way, _, figures in compare(folder):
            found.setdefault(way, {}).setdefault(folder.name, []).append(figures)
    for row in table(found):
        print(row)
    counts = faults(folders)
    print(f"\n{counts.pop('', 0)} good drapes; left out by fault: {dict(counts) or 'none'}")


if __name__ == "__main__":
    main()
