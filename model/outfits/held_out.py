"""Write outfits of the kinds that training never sees as OBJ, for `toile evaluate`.

python -m outfits.held_out --count 8 --out data/held_out
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from .dataset import VALIDATION_SEED
from .families import VALIDATION
from .generate import generate
from .mesh import OutfitMesh


def write_obj(outfit: OutfitMesh, path: Path) -> None:
    """One object a garment, metres; layers are found by measuring, as for any upload."""
    lines, first = [], 1
    for garment in outfit.garments:
        lines.append(f"o {garment.name}")
        lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in garment.vertices]
        lines += [f"f {a + first} {b + first} {c + first}" for a, b, c in garment.triangles]
        first += len(garment.vertices)
    path.write_text("\n".join(lines) + "\n")


def held_out(count: int, density: int | None = None) -> Iterator[tuple[int, OutfitMesh]]:
    """Outfits of the kinds never trained on, in turn, with their numbers; `density` as of `generate`."""
    families = list(VALIDATION)
    for i in range(count):
        yield i, generate(VALIDATION_SEED + i, families[i % len(families)], vertices=density)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--density", type=int, help="vertices a square metre, for all of them")
    parser.add_argument("--out", type=Path, default=Path("data/held_out"))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    for i, outfit in held_out(args.count, args.density):
        path = args.out / f"{i:02d}_{outfit.family}.obj"
        write_obj(outfit, path)
        print(path, flush=True)


if __name__ == "__main__":
    main()
