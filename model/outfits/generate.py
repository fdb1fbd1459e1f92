"""One outfit from a seed: `generate(seed, family)`."""

from __future__ import annotations

import numpy as np
from body.anny_body import AnnyBody, ShapedBody

from .body_fields import BodyFields, body_fields
from .families import TRAIN, TRAIN_ORDER, VALIDATION, patterns
from .mesh import GarmentMesh, OutfitMesh
from .pattern import Pattern, Shape, shape
from .sew import TRIANGULATIONS, Cloth, sew

families_train = tuple(TRAIN)
families_validation = tuple(VALIDATION)


def generate(
    seed: int, family: str | None = None, body: ShapedBody | None = None, vertices: int | None = None
) -> OutfitMesh:
    """Make an outfit on a body (the reference body by default).

    `vertices` is the wanted count per square metre of cloth; without it the seed chooses. The same arguments give
    the same outfit. Raises KeyError for an unknown family.
    """
    rng = np.random.default_rng([seed, 7])
    family = family or str(rng.choice(TRAIN_ORDER))
    model = AnnyBody.load()
    fields = body_fields(model, body or model.shape())
    worn = patterns(rng, family)
    density = vertices or int(np.exp(rng.normal(np.log(1300), 0.45)))
    styles = rng.choice(TRIANGULATIONS, size=len(worn), p=[0.55, 0.15, 0.15, 0.15])
    return OutfitMesh(family, seed, assemble(worn, fields, [(density, str(s)) for s in styles]))


def assemble(worn: list[Pattern], fields: BodyFields, cloths: list[tuple[int, str]]) -> list[GarmentMesh]:
    """Sew patterns from the inside out; `cloths` gives (vertices per square metre, triangulation) for each."""
    shapes: list[Shape] = []
    garments: list[GarmentMesh] = []
    for pattern, (density, style) in zip(worn, cloths, strict=True):
        shapes.append(shape(pattern, fields, shapes[:]))
        garments.append(sew(shapes[-1], fields, garments, Cloth(density, style)))
    return garments
