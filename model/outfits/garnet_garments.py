"""The four garments that GarNet drapes: T-shirt, sweater, dress and jeans (Gundogdu et al. 2020, section 4.2).

`python -m outfits.garnet_garments` writes them as OBJ, for `toile evaluate --method garnet --kind KIND`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from body.anny_body import AnnyBody

from .body_fields import body_fields
from .generate import assemble
from .held_out import write_obj
from .mesh import OutfitMesh
from .pattern import Pattern

PATTERNS: dict[str, Pattern] = {
    "tee": Pattern(
        "T-shirt", "tee", hem=0.86, chest=0.022, waist=0.026, hip=0.028, looseness=0.6, sleeve=0.20,
        sleeve_ease=0.018, cuff_ease=0.024,
    ),
    "sweater": Pattern(
        "sweater", "shirt", hem=0.84, chest=0.036, waist=0.040, hip=0.036, looseness=0.75, sleeve=0.53,
        sleeve_ease=0.026, cuff_ease=0.012,
    ),
    "dress": Pattern(
        "dress", "dress", hem=0.58, chest=0.014, waist=0.012, hip=0.016, looseness=0.1, sleeve=0.14,
        sleeve_ease=0.016, cuff_ease=0.02, skirt_from=1.16, flare=0.26, folds=9, fold_depth=0.010,
    ),
    "jeans": Pattern(
        "jeans", "trousers", top=1.05, hem=0.10, waist=0.010, hip=0.016, thigh=0.016, leg_hem=0.020, looseness=0.6,
    ),
}  # fmt: skip
#: Vertices per square metre.
DENSITY = 1400


def garnet_garment(kind: str, density: int = DENSITY) -> OutfitMesh:
    """A garment of `PATTERNS` on the reference body. Raises KeyError for another kind."""
    model = AnnyBody.load()
    worn = assemble([PATTERNS[kind]], body_fields(model, model.shape()), [(density, "isotropic")])
    return OutfitMesh(kind, 0, worn)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("data/garnet"))
    parser.add_argument("--density", type=int, default=DENSITY, help="vertices a square metre")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    for kind in PATTERNS:
        write_obj(garnet_garment(kind, args.density), args.out / f"{kind}.obj")
        print(args.out / f"{kind}.obj", flush=True)


if __name__ == "__main__":
    main()
