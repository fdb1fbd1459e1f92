"""Golden bodies for the tests of Python and Rust: `python -m body.goldens` (needs torch and anny).

Vertices and joints come from Anny itself, not from our baked file; measurements from our tapes on the
baked body. Writes `artifacts/golden/body.safetensors`; docs/body.md says what is in it.
"""

from __future__ import annotations

import json
from pathlib import Path

import anny
import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.numpy import save_file

from body.anny_body import AnnyBody
from body.bake import GLTF_FROM_ANNY, REFERENCE_AGE
from body.humanoid import Rotations, joint_rotations
from body.measuring import Tape
from body.pose_sampling import sample_pose

Array = NDArray[np.float64]
OUT = Path(__file__).parents[1] / "artifacts" / "golden" / "body.safetensors"
CASES, STRIDE = 100, 37


def random_case(rng: np.random.Generator, body: AnnyBody, case: int) -> dict:
    """A shape and a pose; the first is the reference body, the second takes every range to its ends."""
    if case == 0:
        phenotypes = dict.fromkeys(body.phenotypes, 0.5) | {"age": REFERENCE_AGE}
        return {"phenotypes": phenotypes, "local_changes": {}, "rotations": {}}
    ends = case == 1
    phenotypes = {p: float(rng.integers(2)) if ends else round(float(rng.uniform()), 4) for p in body.phenotypes}
    phenotypes["age"] = round(float(rng.uniform(0.6, 1.0)), 4)
    local = {n: float(rng.choice([-1, 1])) if ends else round(float(rng.uniform(-1, 1)), 4) for n in body.local_changes}
    rotations = {name: np.round(q, 7) for name, q in sample_pose(rng).items()}
    rotations = {name: (q / np.linalg.norm(q)).tolist() for name, q in rotations.items()}
    return {"phenotypes": phenotypes, "local_changes": local, "rotations": rotations}


def anny_vertices(model: anny.Anny, case: dict, rotations: Array) -> tuple[Array, Array]:
    """Anny's own posed vertices (V, 3) and joint frames (J, 4, 4) in glTF axes, over the rest body's root.

    Anny puts the root at the origin; ours stays above the same point of the floor as at rest.
    """
    g = GLTF_FROM_ANNY
    poses = np.tile(np.eye(4), (1, len(rotations), 1, 1))
    poses[0, :, :3, :3] = g.T @ rotations @ g
    with torch.no_grad():
        out = model(
            pose_parameters=torch.tensor(poses, dtype=model.dtype),
            phenotype_kwargs=case["phenotypes"],
            local_changes_kwargs=case["local_changes"],
        )
    frames = np.tile(np.eye(4), (len(rotations), 1, 1))
    own = out["bone_poses"][0].double().numpy()
    root = g @ out["rest_bone_heads"][0, 0].double().numpy() * [1, 0, 1]
    frames[:, :3, :3], frames[:, :3, 3] = g @ own[:, :3, :3], own[:, :3, 3] @ g.T + root
    return out["vertices"][0].double().numpy() @ g.T + root, frames


def golden(model: anny.Anny, body: AnnyBody, case: dict) -> dict[str, Array]:
    """Everything expected of one case. A-pose and posed bodies stand on the floor, as the server's do."""
    apose, apose_frames = anny_vertices(model, case, joint_rotations(body, {}))
    posed, frames = anny_vertices(model, case, joint_rotations(body, case["rotations"]))
    apose_frames[:, 1, 3] -= apose[:, 1].min()
    frames[:, 1, 3] -= posed[:, 1].min()
    kept = body.garment_joints
    transforms = frames[kept] @ np.linalg.inv(apose_frames[kept])
    return {
        "apose_vertices": (apose - [0, apose[:, 1].min(), 0])[::STRIDE],
        "posed_vertices": (posed - [0, posed[:, 1].min(), 0])[::STRIDE],
        "joints": apose_frames[:, :3, 3],
        "garment_transforms": transforms[:, :3],
        "measurements": Tape(body).measure(body.coefficients(case["phenotypes"], case["local_changes"])),
    }


def split_cases(rng: np.random.Generator, body: AnnyBody) -> dict[str, Array]:
    """Random humanoid rotations and what each gives to Anny's joints, whatever the angle."""
    names = [n for n, joints in body.meta["humanoid"].items() if len(joints) == 2 or n == "head"]
    quaternions = rng.normal(size=(len(names), 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    rotations: Rotations = dict(zip(names, quaternions, strict=True))
    return {"split_quaternions": quaternions, "split_rotations": joint_rotations(body, rotations)}


def main() -> None:
    body, rng = AnnyBody.load(), np.random.default_rng(7)
    model = anny.Anny(local_changes=body.local_changes)
    cases = [random_case(rng, body, k) for k in range(CASES)]
    results = [golden(model, body, case) for case in cases]
    data = {name: np.stack([r[name] for r in results]) for name in results[0]} | split_cases(rng, body)
    names = [n for n, joints in body.meta["humanoid"].items() if len(joints) == 2 or n == "head"]
    meta = {"format": "toile-body-golden/1", "stride": STRIDE, "cases": cases, "split_names": names}
    OUT.parent.mkdir(exist_ok=True)
    stored = {name: np.ascontiguousarray(value, dtype=np.float32) for name, value in data.items()}
    save_file(stored, OUT, {"toile": json.dumps(meta)})
    print(f"{OUT.name}: {CASES} cases, {OUT.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
