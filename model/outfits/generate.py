"""One outfit from a seed: `generate(seed, family)`."""

from __future__ import annotations

import numpy as np

from body.anny_body import AnnyBody, ShapedBody

from .body_fields import BodyFields, body_fields
from .families import TRAIN, TRAIN_ORDER, VALIDATION, patterns
from .mesh import GarmentMesh, OutfitMesh
from .ornaments import Trimming, trim_shape, trim_sheet
from .pattern import Pattern, Shape, shape
from .sew import TRIANGULATIONS, Cloth, keep_clear, sew
from .uv import planar, unwrap

SHEETS = ("tie", "bow")
TRIMMING_DENSITY = 5000
families_train = tuple(TRAIN)
families_validation = tuple(VALIDATION)


def generate(
    seed: int,
    family: str | None = None,
    body: ShapedBody | None = None,
    vertices: int | None = None,
    triangulation: str | None = None,
) -> OutfitMesh:
    """Make an outfit on a body (the reference body by default).

    `vertices` is the wanted count per square metre of cloth, `triangulation` one of `TRIANGULATIONS`; without them
    the seed chooses. The same arguments give the same outfit. Raises KeyError for an unknown family.
    """
    rng = np.random.default_rng([seed, 7])
    family = family or str(rng.choice(TRAIN_ORDER))
    model = AnnyBody.load()
    fields = body_fields(model, body or model.shape())
    worn = patterns(rng, family)
    density = vertices or int(np.exp(rng.normal(np.log(1300), 0.45)))
    styles = rng.choice(TRIANGULATIONS, size=len(worn), p=[0.55, 0.15, 0.15, 0.15])
    if triangulation:
        styles = [triangulation] * len(worn)
    return OutfitMesh(family, seed, assemble(worn, fields, [(density, str(s)) for s in styles]))


def assemble(
    worn: list[Pattern | Trimming], fields: BodyFields, cloths: list[tuple[int, str]], seamed: bool = False
) -> list[GarmentMesh]:
    """Sew from the inside out; `cloths` gives (vertices per square metre, triangulation) for each piece.

    With `seamed`, mesh edges follow the armholes.
    """
    shapes: list[Shape] = []
    garments: list[GarmentMesh] = []
    for item, (density, style) in zip(worn, cloths, strict=True):
        if isinstance(item, Trimming) and item.kind in SHEETS:
            garments.append(_loose(item, shapes, fields, garments))
            continue
        if isinstance(item, Trimming):
            shapes.append(trim_shape(item, shapes))
            density, style = max(2 * density, TRIMMING_DENSITY), "isotropic"
        else:
            shapes.append(shape(item, fields, shapes[:]))
        garments.append(sew(shapes[-1], fields, garments, Cloth(density, style, seamed)))
        unwrap(garments[-1], shapes[-1].pattern, fields)
    return garments


def _loose(item: Trimming, shapes: list[Shape], fields: BodyFields, worn: list[GarmentMesh]) -> GarmentMesh:
    piece = trim_sheet(item, shapes, len(worn))
    piece.vertices = keep_clear(piece.vertices, piece.triangles, fields, 0.006, worn)
    planar(piece)
    return piece
