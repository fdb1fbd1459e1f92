"""The T-shirt that pixel cloth drapes, with its panels as UVs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from body.anny_body import AnnyBody

from .body_fields import body_fields
from .garnet_garments import garnet_garment
from .mesh import GarmentMesh
from .panels import front_and_back

#: Vertices per square metre: 2.7 thousand vertices.
DENSITY = 3000


def hero_tee(density: int = DENSITY) -> GarmentMesh:
    """The garment on the reference body; front and back side by side in UV, metres."""
    garment, model = garnet_garment("tee", density).garments[0], AnnyBody.load()
    panels = front_and_back(garment, body_fields(model, model.shape()))
    places, triangles, right, first = [], [], 0.0, 0
    for panel in panels:
        moved = panel.places - panel.places.min(0)
        places.append(moved + np.array([right, 0.0]))
        triangles.append(panel.triangles + first)
        right, first = right + moved[:, 0].max() + 0.02, first + len(moved)
    corners = np.concatenate([p.vertices[p.triangles] for p in panels])
    return replace(
        garment,
        name="hero T-shirt",
        triangles=corners,
        uv=np.concatenate(places),
        uv_triangles=np.concatenate(triangles),
    )
