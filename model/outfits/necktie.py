"""A necktie on the bare reference body, the loose garment of pixel cloth (Jin et al. 2020, section 8.4)."""

from __future__ import annotations

from body.anny_body import AnnyBody

from .body_fields import body_fields
from .garnet_garments import PATTERNS
from .generate import assemble
from .mesh import GarmentMesh, OutfitMesh
from .ornaments import Trimming

#: m: height of the knot, and length.
TOP, LENGTH = 1.53, 0.46
#: m below its upper end in which it is tied.
KNOT = 0.045


def necktie() -> OutfitMesh:
    """Knot, blade and point, as they lie on a T-shirt; what goes around the neck is left out."""
    model = AnnyBody.load()
    worn = assemble(
        [PATTERNS["tee"], Trimming("tie", (TOP, LENGTH))], body_fields(model, model.shape()), [(700, "isotropic")] * 2
    )
    tie: GarmentMesh = worn[-1]
    return OutfitMesh("tie", 0, [tie])
