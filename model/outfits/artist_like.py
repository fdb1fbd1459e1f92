"""Outfits with the faults that artists' files have, to try the service on: `toile evaluate data/artist_like/*.obj`.

    python -m outfits.artist_like --count 10 --out data/artist_like

Seeded. One mesh for everything, outer garments first, cloth that passes through the body and through the layer
below, patch pockets and buttons as pieces of their own, a double-sided garment, vertices split along seams, uneven
triangles. From kinds never trained on, and from unseen outfits with jackets, collars, lapels and ties.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from .dataset import VALIDATION_SEED
from .families import VALIDATION
from .generate import generate
from .mesh import Array, GarmentMesh, Index, compact, vertex_normals
from .resolutions import coarser

#: In turn: every kind never trained on, and what has open fronts and small pieces.
FAMILIES = [*VALIDATION, "lapelled_jacket", "shirt_tie_trousers", "jacket_shirt_trousers", "collared_shirt_trousers"]
#: m, how deep cloth is sunk at most, and how much deeper each next layer.
SUNK, DEEPER = 0.030, 0.006
#: m, pockets and buttons over the cloth that carries them.
LIFT = 0.0025
#: Shares of the vertices that are left, from garment to garment.
KEPT = (0.3, 1.0)

Rng = np.random.Generator


def artist_like(seed: int, family: str) -> tuple[Array, Index]:
    """One mesh (N, 3), (T, 3), rest space, metres."""
    rng = np.random.default_rng([seed, 11])
    garments = [uneven(g, rng) for g in generate(seed, family).garments]
    garments = [sunk(g, rng, SUNK + DEEPER * g.layer) for g in garments]
    outer = max((g for g in garments if g.kind not in ("tie", "bow")), key=lambda g: g.layer)
    pieces = [(g.vertices, g.triangles) for g in reversed(garments)]
    low, high = outer.vertices[:, 1].min(), outer.vertices[:, 1].max()
    pocketed = low + rng.uniform(0.25, 0.6) * (high - low)
    pieces += [pocket(outer, np.array([x, pocketed])) for x in (-0.08, 0.08)]
    pieces += [button(outer, height) for height in np.linspace(low, high, 7)[1:-1]]
    twice = int(rng.integers(len(garments)))
    pieces[twice] = double_sided(*pieces[twice])
    return one_mesh([split_along_seams(v, t) for v, t in pieces if len(t)])


def uneven(garment: GarmentMesh, rng: Rng) -> GarmentMesh:
    """Decimated: large triangles where it is flat."""
    share = float(rng.uniform(*KEPT))
    return garment if len(garment.vertices) < 400 else coarser(garment, share)


def sunk(garment: GarmentMesh, rng: Rng, depth: float) -> GarmentMesh:
    """Pushed inwards by a smooth random field, up to `depth` m."""
    wave = rng.normal(0, 12, (3, 3))
    height = np.sin(garment.vertices @ wave.T + rng.uniform(0, 6.28, 3)).mean(1).clip(min=0)
    normals = vertex_normals(garment.vertices, garment.triangles)
    return replace(garment, vertices=garment.vertices - depth * height[:, None] * normals)


def pocket(garment: GarmentMesh, centre: Array) -> tuple[Array, Index]:
    """A patch of the cloth in front, over it. centre (2,): x and y."""
    size = np.array([0.05, 0.06])
    middle = garment.vertices[garment.triangles].mean(1)
    inside = (np.abs(middle[:, :2] - centre) < size).all(1) & (middle[:, 2] > 0)
    normals = vertex_normals(garment.vertices, garment.triangles)
    return compact(garment.vertices + LIFT * normals, garment.triangles[inside])


def button(garment: GarmentMesh, height: float) -> tuple[Array, Index]:
    """A disc of 12 mm on the cloth in front."""
    front = np.flatnonzero(garment.vertices[:, 2] > 0)
    distance = np.hypot(garment.vertices[front, 0], garment.vertices[front, 1] - height)
    at = front[distance.argmin()]
    normal = vertex_normals(garment.vertices, garment.triangles)[at]
    across = np.cross(normal, [0.0, 1.0, 0.0])
    across /= max(np.linalg.norm(across), 1e-6)
    angle = 2 * np.pi * np.arange(8) / 8
    rim = np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * np.cross(normal, across)
    centre = garment.vertices[at] + LIFT * normal
    fan = [(8, k, (k + 1) % 8) for k in range(8)]
    return np.concatenate([centre + 0.006 * rim, centre[None]]), np.array(fan)


def double_sided(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """With a back of its own at the same place, as some exporters write two-sided cloth."""
    back = triangles[:, ::-1] + len(vertices)
    return np.concatenate([vertices, vertices]), np.concatenate([triangles, back])


def split_along_seams(vertices: Array, triangles: Index) -> tuple[Array, Index]:
    """A vertex of its own for each of the four panels that meet at the sides and the middle."""
    middle = vertices[triangles].mean(1)
    panel = (middle[:, 0] > 0) + 2 * (middle[:, 2] > 0)
    parts = [compact(vertices, triangles[panel == k]) for k in range(4) if (panel == k).any()]
    return one_mesh(parts)


def one_mesh(parts: list[tuple[Array, Index]]) -> tuple[Array, Index]:
    """Parts one after the other."""
    first = np.cumsum([0, *(len(v) for v, _ in parts)])
    return np.concatenate([v for v, _ in parts]), np.concatenate(
        [t + n for (_, t), n in zip(parts, first, strict=False)]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=len(FAMILIES))
    parser.add_argument("--out", type=Path, default=Path("data/artist_like"))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    for i in range(args.count):
        family = FAMILIES[i % len(FAMILIES)]
        vertices, triangles = artist_like(VALIDATION_SEED + 500 + i, family)
        lines = ["o outfit", *(f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in vertices)]
        lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
        path = args.out / f"{i:02d}_{family}.obj"
        path.write_text("\n".join(lines) + "\n")
        print(path, len(vertices), flush=True)


if __name__ == "__main__":
    main()
