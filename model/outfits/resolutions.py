"""The same held-out outfits at a quarter of, once and four times the vertices, for `toile evaluate`.

    pip install pyvista
    python -m outfits.resolutions --count 5 --out data/resolutions

Writes quarter_*.obj (quadric decimation), once_*.obj and four_*.obj (every triangle cut in four).
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from .held_out import held_out, write_obj
from .mesh import GarmentMesh, OutfitMesh, edges_of


def coarser(garment: GarmentMesh, share: float) -> GarmentMesh:
    """About that share of the vertices, by quadric decimation."""
    faces = np.insert(garment.triangles, 0, 3, axis=1)
    # Only here: what else reads this module works without the simulator's tools.
    import pyvista

    coarse = pyvista.PolyData(garment.vertices, faces).decimate(1 - share).clean()
    return replace(garment, vertices=np.asarray(coarse.points, float), triangles=coarse.faces.reshape(-1, 4)[:, 1:])


def four_times(garment: GarmentMesh) -> GarmentMesh:
    """Every edge halved."""
    edges, side, _ = edges_of(garment.triangles)
    middle = garment.vertices[edges].mean(1)
    a, b, c = garment.triangles.T
    bc, ca, ab = (side + len(garment.vertices)).T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return replace(
        garment,
        vertices=np.concatenate([garment.vertices, middle]),
        triangles=np.concatenate([np.stack(t, 1) for t in corners]),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=5)
    parser.add_argument("--out", type=Path, default=Path("data/resolutions"))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    for i, outfit in held_out(args.count):
        for name, change in (("quarter", lambda g: coarser(g, 0.25)), ("once", lambda g: g), ("four", four_times)):
            changed = OutfitMesh(outfit.family, outfit.seed, [change(g) for g in outfit.garments])
            write_obj(changed, args.out / f"{name}_{i:02d}_{outfit.family}.obj")
            print(name, outfit.family, changed.vertex_count, flush=True)


if __name__ == "__main__":
    main()
