"""Motion capture: BVH files, and poses whose bones point where the captured ones do. No torch."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from body import quaternions as qt
from body.anny_body import AnnyBody
from body.humanoid import Rotations, joint_rotations
from body.mimic_clips import HINGES, JOINTS, WIDTH, read_mimic
from body.motion_capture import read_bvh, retargeted
from body.pose_sampling import sample_poses
from body.posture import SIDES, Posture, arm, leg

#: A skeleton in a T-pose, named as CMU's: joint, parent, offset from it.
TREE = [("Hips", "", (0, 0, 0)), ("Spine", "Hips", (0, 2, 0)), ("Spine1", "Spine", (0, 2, 0))]
TREE += [("Head", "Spine1", (0, 3, 0))]
CGSPEED = {"Hips": "hip", "Spine": "abdomen", "Spine1": "chest", "Head": "head"}
SPINE = ("hips", "spine", "chest", "upperChest")
#: Our joint at the start of each captured bone of the limbs, and where that bone points at rest.
OURS, REST = {}, {}
for _side, _s in (("Left", 1), ("Right", -1)):
    _limbs = [
        ("Arm", "Spine1", (3.2 * _s, 1, 0), "UpperArm", "Shldr"),
        ("ForeArm", "Arm", (5 * _s, 0, 0), "LowerArm", "ForeArm"),
        ("Hand", "ForeArm", (3.4 * _s, 0, 0), "", "Hand"),
        ("UpLeg", "Hips", (1.8 * _s, -1.7, 0.8), "UpperLeg", "Thigh"),
        ("Leg", "UpLeg", (0, -7, 0), "LowerLeg", "Shin"),
        ("Foot", "Leg", (0, -7, 0), "", "Foot"),
    ]
    for _name, _parent, _offset, _ours, _cgspeed in _limbs:
        TREE.append((_side + _name, _parent if _parent in CGSPEED else _side + _parent, _offset))
        CGSPEED[_side + _name] = _side[0].lower() + _cgspeed
        if _ours:
            OURS[_side + _name] = _side.lower() + _ours
            REST[_side.lower() + _ours] = np.array([_s, 0, 0]) if "Arm" in _name else np.array([0, -1, 0])


def bvh(frames: list[dict[str, np.ndarray]], order: str = "ZYX", names: dict[str, str] | None = None) -> str:
    """A file with the skeleton's local rotations (3, 3) in frames; joints that do not turn may be left out."""

    def joint(k: int, deep: str) -> str:
        name, _, offset = TREE[k]
        channels = [f"{axis}rotation" for axis in order]
        if k == 0:
            channels = ["Xposition", "Yposition", "Zposition", *channels]
        below = [joint(c, deep + "\t") for c, child in enumerate(TREE) if child[1] == name]
        below = below or [f"{deep}\tEnd Site\n{deep}\t{{\n{deep}\t\tOFFSET 0 1 0\n{deep}\t}}\n"]
        head = f"{deep}{'JOINT' if k else 'ROOT'} {(names or {}).get(name, name)}\n{deep}{{\n"
        told = f"{deep}\tOFFSET {' '.join(map(str, offset))}\n{deep}\tCHANNELS {len(channels)} {' '.join(channels)}\n"
        return head + told + "".join(below) + f"{deep}}}\n"

    def walk(name: str) -> list[str]:
        return [name] + [n for child in TREE if child[1] == name for n in walk(child[0])]

    rows = []
    for frame in frames:
        turns = [Rotation.from_matrix(frame.get(n, np.eye(3))).as_euler(order, degrees=True) for n in walk("Hips")]
        rows.append(" ".join(str(x) for x in (1, 17, -3, *np.concatenate(turns))))
    return f"HIERARCHY\n{joint(0, '')}MOTION\nFrames: {len(rows)}\nFrame Time: 0.01\n" + "\n".join(rows) + "\n"


def directions(rotations: Rotations) -> dict[str, np.ndarray]:
    """Where the bones of our limbs point in a pose, {upper or lower joint: (3,)}."""
    body = AnnyBody.load()
    places = body.world_from_apose(body.shape(), joint_rotations(body, rotations))[:, :, 3]
    at = {n: places[body.joint_names.index(own[0])] for n, own in body.meta["humanoid"].items()}
    limbs = [limb(side) for side in SIDES for limb in (arm, leg)]
    ends = {k: v for limb in limbs for k, v in ((limb.upper, limb.lower), (limb.lower, limb.end))}
    return {k: (at[v] - at[k]) / np.linalg.norm(at[v] - at[k]) for k, v in ends.items()}


def turned(rotations: Rotations, *names: str) -> np.ndarray:
    """World rotation (3, 3) at the end of a chain of joints."""
    return qt.to_matrix(qt.multiply(*(rotations.get(n, qt.IDENTITY) for n in names)))


def captured(rotations: Rotations) -> dict[str, np.ndarray]:
    """The T-pose skeleton's local rotations (3, 3) that point its bones where ours point."""
    chains = {"Hips": SPINE[:1], "Spine": SPINE[:2], "Spine1": SPINE, "Head": (*SPINE, "neck", "head")}
    world = {name: turned(rotations, *chain) for name, chain in chains.items()}
    found, parents = directions(rotations), {name: parent for name, parent, _ in TREE}
    for theirs, ours in OURS.items():
        world[theirs] = Rotation.align_vectors([found[ours]], [REST[ours]])[0].as_matrix()
    return {k: world[parents[k]].T @ m if parents[k] else m for k, m in world.items()}


@pytest.mark.parametrize("order", ["ZYX", "XYZ", "YXZ"])
def test_the_bones_of_poses_come_back(order: str) -> None:
    poses = sample_poses(5, 3)
    for before, after in zip(poses, retargeted(read_bvh(bvh([captured(p) for p in poses], order)), 100), strict=True):
        theirs, ours = directions(before), directions(after)
        for name, v in theirs.items():
            assert v @ ours[name] > np.cos(np.radians(0.5)), name
        for chain in (SPINE[:1], SPINE[:2], SPINE):
            np.testing.assert_allclose(turned(before, *chain), turned(after, *chain), atol=1e-4)


def test_arms_of_a_t_pose_point_sideways_and_its_legs_down() -> None:
    (pose,) = retargeted(read_bvh(bvh([{}])), 30)
    found = directions(pose)
    for name, v in REST.items():
        assert v @ found[name] > np.cos(np.radians(0.5)), name
    posture = Posture()
    for side in SIDES:
        posture.arm(side, 90, 0, 0)
        np.testing.assert_allclose(pose[f"{side}Shoulder"], posture.rotations[f"{side}Shoulder"], atol=1e-6)


def test_a_skeleton_that_rests_with_z_up_and_cgspeeds_names_is_understood() -> None:
    raised = {"RightArm": Rotation.from_euler("Z", -60, degrees=True).as_matrix()}
    text = bvh([raised], names=CGSPEED).split("MOTION")
    lines = []
    for line in text[0].splitlines():  # x, y, z become x, -z, y
        words = line.split()
        lines.append(f"OFFSET {words[1]} {-float(words[3])} {words[2]}" if words[0] == "OFFSET" else line)
    swapped = {"Yrotation": "Zrotation", "Zrotation": "Yrotation"}
    head = " ".join(swapped.get(w, w) for w in "\n".join(lines).split())
    numbers = text[1].split()
    numbers[5:] = [str(-float(x) if k >= 3 and k % 3 == 0 else x) for k, x in enumerate(numbers[5:])]
    (pose,) = retargeted(read_bvh(f"{head} MOTION {' '.join(numbers)}"), 30)
    np.testing.assert_allclose(directions(pose)["rightUpperArm"], [-0.5, np.sqrt(0.75), 0], atol=0.01)
    np.testing.assert_allclose(directions(pose)["leftLowerLeg"], [0, -1, 0], atol=0.01)


def test_elbows_keep_their_hinge() -> None:
    limb, posture = arm("left"), Posture()
    posture.arm("left", 60, 40, 70, 25)
    (pose,) = retargeted(read_bvh(bvh([captured(posture.rotations)])), 30)
    for name in (limb.upper, limb.lower):
        assert abs(np.dot(pose[name], posture.rotations[name])) > np.cos(np.radians(1.5)), name


def test_a_clip_is_resampled() -> None:
    frames = [{"Hips": Rotation.from_euler("Y", 3 * k, degrees=True).as_matrix()} for k in range(11)]
    poses = retargeted(read_bvh(bvh(frames)), 20)
    angles = [np.degrees(2 * np.arctan2(p["hips"][1], p["hips"][3])) for p in poses]
    np.testing.assert_allclose(angles, [0, 15, 30], atol=1e-3)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("HIERARCHY", "HIERARCHIES", "HIERARCHY expected"),
        ("MOTION", "", "MOTION expected"),
        ("OFFSET 0 2 0", "OFFSET 0 two 0", "a number expected, two found"),
        ("Zrotation Yrotation", "Zrotation Wrotation", "has channels"),
        ("JOINT Spine1", "JOINT Spine", "two joints"),
        ("Frames: 1", "Frames: 2", "2 frames of 51 channels"),
        ("Frame Time: 0.01", "Frame Time: 0", "must be positive"),
        (" 17 ", " inf ", "finite"),
        (" 17 ", " high ", "not a number"),
        ("}\nMOTION", "MOTION", "MOTION found"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(old: str, new: str, said: str) -> None:
    text = bvh([{}])
    assert old in text
    with pytest.raises(ValueError, match=said):
        read_bvh(text.replace(old, new, 1))


def mimic(**turns: np.ndarray | float) -> str:
    """One frame of DeepMimic's humanoid, its joints turned by quaternions xyzw or a hinge's angle."""
    frame = np.zeros(WIDTH)
    frame[0] = 1 / 30
    for name, (_, _, column) in JOINTS.items():
        if name in HINGES:
            frame[column] = turns.get(name, 0.0)
        elif column is not None:
            frame[column : column + 4] = np.roll(turns.get(name, qt.IDENTITY), 1)
    return json.dumps({"Loop": "wrap", "Frames": [frame.tolist()]})


def test_deepmimics_arms_and_shins_point_where_it_says() -> None:
    text = mimic(rightArm=qt.about(qt.X, -90), leftLeg=-np.pi / 2, leftForeArm=np.pi / 2)
    (pose,) = retargeted(read_mimic(text), 30)
    found = directions(pose)
    wanted = {"rightUpperArm": -qt.X, "leftUpperArm": -qt.Y, "leftLowerArm": qt.Z, "leftLowerLeg": -qt.Z}
    for name, v in (wanted | {"leftUpperLeg": -qt.Y, "rightLowerLeg": -qt.Y}).items():
        assert v @ found[name] > np.cos(np.radians(0.5)), name


def test_deepmimics_chest_bends_loins_and_ribs_and_its_pelvis_the_whole_body() -> None:
    (pose,) = retargeted(read_mimic(mimic(chest=qt.about(qt.Z, -40), hips=qt.about(qt.Y, 30))), 30)
    # Ahead is x there and z here, to the right z there and -x here.
    np.testing.assert_allclose(pose["hips"], qt.about(qt.Y, 30), atol=1e-6)
    np.testing.assert_allclose(pose["spine"], qt.about(qt.X, 20), atol=1e-6)
    whole = Rotation.from_euler("YX", [30, 40], degrees=True).as_matrix()
    np.testing.assert_allclose(turned(pose, *SPINE), whole, atol=1e-6)
    with pytest.raises(ValueError, match="44 finite numbers"):
        read_mimic(json.dumps({"Frames": [[0.1, 2.0]]}))


def test_what_is_wrong_with_a_skeleton_is_said() -> None:
    with pytest.raises(ValueError, match="no joint for leftUpperArm"):
        retargeted(read_bvh(bvh([{}], names={"LeftArm": "tentacle"})), 30)
    with pytest.raises(ValueError, match="upright"):
        retargeted(read_bvh(bvh([{}]).replace("OFFSET 0 3 0", "OFFSET 0 3 9")), 30)
