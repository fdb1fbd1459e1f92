"""Write `artifacts/evaluation.json`: bodies and poses that `toile evaluate` drapes on. Seeded.

    python -m evaluation_set

Five bodies from slim to heavy and short to tall, and forty random poses that training does not draw
(another seed of `body.pose_sampling`).
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from body.pose_sampling import sample_poses

OUT = Path(__file__).parent / "artifacts" / "evaluation.json"
POSES = 40
SEED = 20_000

BODIES: list[dict[str, float]] = [
    {},
    {"gender": 1.0, "weight": 0.15, "height": 0.35},
    {"gender": 0.0, "weight": 0.3, "muscle": 0.8, "height": 0.8},
    {"gender": 1.0, "weight": 0.75, "height": 0.5, "muscle": 0.4},
    {"gender": 0.0, "weight": 0.9, "height": 0.45},
]


def main() -> None:
    poses = [
        {"kind": "joints", "rotations": {name: rounded(q) for name, q in pose.items()}}
        for pose in sample_poses(POSES, SEED)
    ]
    bodies = [{"kind": "phenotypes", "values": values} for values in BODIES]
    OUT.write_text(json.dumps({"bodies": bodies, "poses": poses}) + "\n")


def rounded(q: np.ndarray) -> list[float]:
    """A quaternion in six digits, still of unit length within 1e-5."""
    return [round(float(x), 6) for x in q]


if __name__ == "__main__":
    main()
