"""One garment simulated on a body that training knows, in less time than the evaluation set's drapes take."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from body.anny_body import AnnyBody
from body.humanoid import Rotations
from evaluation_set import rounded
from outfits.held_out import write_obj
from outfits.mesh import GarmentMesh, OutfitMesh
from training_data import BodyBank, ShapedPoses, ShapeValues

from .checks import Judged
from .drapes import draped, settled


def simulated(
    garment: GarmentMesh,
    poses: list[Rotations],
    folder: Path,
    values: ShapeValues = ({}, {}),
    knot: NDArray[np.integer] | None = None,
) -> tuple[ShapedPoses, NDArray[np.float32], list[Judged]]:
    """A garment at rest on a body in poses, (P, N, 3) world where training's body stands, and its judgements.

    garment: welded, on the reference body. folder: for what the service is asked and answers. knot: vertices that
    stay where skinning puts them while nothing but they bear the rest.
    """
    # Its kernels take a minute to compile where nothing needs them.
    from .simulation import QUICK, Settings

    folder.mkdir(parents=True, exist_ok=True)
    write_obj(OutfitMesh(garment.name, 0, [garment]), folder / "outfit.obj")
    body = {"kind": "phenotypes", "values": values[0] | values[1]}
    asked = [{"kind": "joints", "rotations": {name: rounded(q) for name, q in pose.items()}} for pose in poses]
    (folder / "set.json").write_text(json.dumps({"bodies": [body], "poses": asked}))
    start = draped(folder, "skinning") | ({} if knot is None else {"knot": knot})
    entry = BodyBank(0, 0, 0).random_entry(AnnyBody.load(), values, poses)
    # What hangs from a knot falls far and swings.
    settings = QUICK if knot is None else Settings()
    ends, found = zip(*(settled(start, 0, k, settings=settings) for k in range(len(poses))), strict=True)
    # The service lifts the body to the ground, which training does not.
    lifted = (start["body"][0] - entry.vertices.numpy()).mean(1)
    return entry, (np.stack([end.x for end in ends]) - lifted[:, None]).astype(np.float32), list(found)
