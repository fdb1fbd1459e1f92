"""The preset poses and the walk: `python -m body.poses` writes `artifacts/poses.json`.

Heights are those of the reference body; the server and `humanoid.posed_world` put any body's lowest
vertex on the floor, so only x and z of a translation carry over.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from body import quaternions as qt
from body.anny_body import AnnyBody
from body.humanoid import grounded_translation
from body.posture import SIDES, Posture, euler
from body.walk import FRAME_RATE, KEY_FRAMES, walk_cycle

OUT = Path(__file__).parents[1] / "artifacts" / "poses.json"


def hang_arms(p: Posture, raised: float = 19.0, forward: float = 12.0, bend: float = 18.0) -> None:
    """Both arms relaxed beside the body, clear of it by a sleeve's room."""
    for side in SIDES:
        p.arm(side, raised, forward, bend)
        p.forearm(side, 10)
        p.hand(side, 6)


def hand_on_hip(p: Posture, side: str, above: float = 0.0) -> None:
    """The palm over the hip bone, a finger's breadth off the skin so that cloth fits between."""
    p.reach(side, [0.292, 1.14 + above, 0.034], [1, 0, -0.45])
    p.forearm(side, -36)
    p.hand(side, -20, 10, curl=8)


def a_pose(p: Posture) -> None:
    """What outfits are fitted in: nothing turns."""


def t_pose(p: Posture) -> None:
    for side in SIDES:
        p.arm(side, 90, 0, 4)
        p.hand(side, curl=4)


def standing(p: Posture) -> None:
    hang_arms(p)
    for side, x in (("left", 0.11), ("right", -0.11)):
        p.plant(side, [x, 0.081, 0.009])


def contrapposto(p: Posture) -> None:
    p.turn("hips", euler(roll=-6, yaw=-4))
    p.translation[:] = [-0.035, 0.0, 0]
    p.torso(euler(pitch=-1, roll=6, yaw=2), euler(roll=5, yaw=4))
    p.head(euler(yaw=14, roll=-3, pitch=4))
    p.plant("right", [-0.075, 0.081, -0.005], foot=qt.about(qt.Y, -12))
    p.plant("left", [0.17, 0.081, 0.09], knee=(0.3, 0, 1), foot=qt.about(qt.Y, 16))
    p.arm("left", 22, 14, 24)
    p.arm("right", 24, -14, 30)
    for side in SIDES:
        p.forearm(side, 12)
        p.hand(side, 8)


def arms_up(p: Posture) -> None:
    p.torso(euler(pitch=-3), euler(pitch=-4))
    p.head(euler(pitch=-8))
    for side in SIDES:
        p.arm(side, 158, 12, 18, turn=-25)
        p.hand(side, curl=10)
        p.leg(side, 0, -3, 4)
        p.flat_foot(side, 0)


def hands_on_hips(p: Posture) -> None:
    for side in SIDES:
        hand_on_hip(p, side)
        p.leg(side, 0, 1, 4)
        p.flat_foot(side, 6)


def sitting(p: Posture) -> None:
    p.turn("hips", euler(pitch=-4))
    p.torso(euler(pitch=6), euler(pitch=4))
    p.head(euler(pitch=-4))
    for side in SIDES:
        p.leg(side, 84, 10, 88, turn=4)
        p.flat_foot(side, 8)
        p.arm(side, 28, 55, 62, turn=10)
        p.forearm(side, 30)
        p.hand(side, 4, curl=12)


def squat(p: Posture) -> None:
    p.turn("hips", euler(pitch=28))
    p.torso(euler(pitch=8), euler(pitch=4))
    p.head(euler(pitch=-26))
    p.translation[:] = [0, -0.47, -0.2]
    for side, s in SIDES.items():
        p.plant(side, [s * 0.2, 0.081, 0.009], knee=(0.55, 0, 1), foot=qt.about(qt.Y, s * 18))
        p.arm(side, 116, 80, 12)
        p.hand(side, curl=10)


def reach(p: Posture) -> None:
    p.turn("hips", euler(yaw=8, roll=4))
    p.torso(euler(roll=5, pitch=2), euler(roll=6, yaw=6))
    p.head(euler(pitch=-18, yaw=-6))
    p.translation[:] = [0.03, 0.0, 0.03]
    p.plant("left", [0.13, 0.081, 0.02], foot=qt.about(qt.Y, 10))
    p.plant("right", [-0.14, 0.10, -0.13], foot=qt.multiply(qt.about(qt.Y, -10), qt.about(qt.X, 14)))
    p.arm("right", 142, 62, 14)
    p.arm("left", 24, -10, 24)
    p.forearm("left", 10)
    for side in SIDES:
        p.hand(side, 4, curl=10)


def lunge(p: Posture) -> None:
    p.turn("hips", euler(pitch=4))
    p.torso(euler(pitch=1), euler())
    p.translation[:] = [0, -0.26, 0.0]
    toes = qt.about(qt.X, 52)
    p.plant("left", [0.13, 0.081, 0.42], knee=(0.1, 0, 1), foot=qt.about(qt.Y, 4))
    p.plant("right", [-0.13, 0.185, -0.52], knee=(0, -0.6, 1), foot=toes)
    for side in SIDES:
        hand_on_hip(p, side, above=0.04)


def look_back(p: Posture) -> None:
    p.turn("hips", euler(yaw=18))
    p.torso(euler(yaw=16), euler(yaw=20, roll=-3))
    p.head(euler(yaw=46, pitch=2))
    p.plant("left", [0.12, 0.081, -0.06], foot=qt.about(qt.Y, 26))
    p.plant("right", [-0.1, 0.081, 0.1], foot=qt.about(qt.Y, 8))
    p.arm("left", 26, -24, 22)
    p.arm("right", 28, 40, 26)
    for side in SIDES:
        p.forearm(side, 10)
        p.hand(side, 6)


def wave(p: Posture) -> None:
    standing(p)
    p.torso(euler(roll=-2), euler(roll=-3))
    p.head(euler(yaw=-8, roll=4))
    p.arm("right", 88, 12, 105, turn=78)
    p.forearm("right", 30)
    p.hand("right", -6, curl=4)


PRESETS: list[tuple[str, str, str, Callable[[Posture], None]]] = [
    ("a-pose", "A-pose", "standing", a_pose),
    ("t-pose", "T-pose", "standing", t_pose),
    ("standing", "Standing", "standing", standing),
    ("contrapposto", "Contrapposto", "standing", contrapposto),
    ("hands-on-hips", "Hands on hips", "standing", hands_on_hips),
    ("look-back", "Looking back", "standing", look_back),
    ("arms-up", "Arms up", "active", arms_up),
    ("wave", "Waving", "active", wave),
    ("reach", "Reaching", "active", reach),
    ("lunge", "Lunge", "active", lunge),
    ("squat", "Squat", "active", squat),
    ("sitting", "Sitting", "active", sitting),
]


def rounded(p: Posture) -> dict:
    """One pose as JSON: unit quaternions to seven places, joints that do not turn left out."""
    body = AnnyBody.load()
    rotations = {}
    for name in sorted(p.rotations):
        q = p.rotations[name] / np.linalg.norm(p.rotations[name])
        q = q if q[3] >= 0 else -q
        if q[3] < 1 - 1e-10:
            rotations[name] = [round(float(x), 7) + 0.0 for x in q]
    up = grounded_translation(body, body.shape(), rotations)
    translation = [round(float(x), 5) + 0.0 for x in (p.translation[0], up, p.translation[2])]
    return {"rotations": rotations, "root_translation": translation}


def build() -> dict:
    """The whole file: {"poses": [...], "motions": [...]}."""
    poses = []
    for pose_id, label, group, pose in PRESETS:
        p = Posture()
        pose(p)
        poses.append({"id": pose_id, "label": label, "group": group} | rounded(p))
    frames = [rounded(p) for p in walk_cycle()]
    for k, frame in enumerate(KEY_FRAMES, 1):
        poses.append({"id": f"walk-{k}", "label": f"Walk {k}", "group": "walk"} | frames[frame])
    return {"poses": poses, "motions": [{"id": "walk", "label": "Walk", "frame_rate": FRAME_RATE, "frames": frames}]}


def main() -> None:
    data = build()
    lines = ",\n".join(json.dumps(p) for p in data["poses"])
    motions = ",\n".join(json.dumps(m) for m in data["motions"])
    OUT.write_text(f'{{"poses": [\n{lines}\n],\n"motions": [\n{motions}\n]}}\n')
    print(f"{OUT.name}: {len(data['poses'])} poses, {len(data['motions'][0]['frames'])} frames")


if __name__ == "__main__":
    main()
