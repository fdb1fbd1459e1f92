"""Tight variants of an outfit: the same garments drawn towards the skin, as scanned and bought outfits often are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .body_fields import BodyFields
from .mesh import GarmentMesh, OutfitMesh

#: Cloth nearer than this is drawn in, metres.
REACH = 0.04
#: Share of its distance that cloth on the skin keeps.
KEPT = 0.3


def snug(outfit: OutfitMesh, fields: BodyFields) -> OutfitMesh:
    """The outfit with every distance d below REACH shortened to d (KEPT + (1 - KEPT) d / REACH).

    The map grows with d, so that layers keep their order; cloth that hangs free stays.
    """
    return replace(outfit, garments=[_drawn_in(g, fields) for g in outfit.garments])


def _drawn_in(garment: GarmentMesh, fields: BodyFields) -> GarmentMesh:
    distance, normal = fields.clearance(garment.vertices)
    d = np.clip(distance, 0, REACH)
    shorter = d * (KEPT + (1 - KEPT) * d / REACH)
    return replace(garment, vertices=garment.vertices - (d - shorter)[:, None] * normal)
