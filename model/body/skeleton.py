"""Names of the skeleton: the humanoid (VRM) joints of the API and the Anny joints that they drive."""

from __future__ import annotations

import numpy as np

#: Anny joints that carry no cloth of their own: they fold into their parents in the garment skeleton.
FOLDED = ("finger", "metacarpal", "toe", "eye")

_FINGERS = {"Thumb": 1, "Index": 2, "Middle": 3, "Ring": 4, "Little": 5}
_PHALANGES = {"Thumb": ("Metacarpal", "Proximal", "Distal")}


def _side(side: str, s: str) -> dict[str, list[str]]:
    limbs = {
        "Shoulder": [f"clavicle.{s}"],
        "UpperArm": [f"upperarm01.{s}", f"upperarm02.{s}"],
        "LowerArm": [f"lowerarm01.{s}", f"lowerarm02.{s}"],
        "Hand": [f"wrist.{s}"],
        "UpperLeg": [f"upperleg01.{s}", f"upperleg02.{s}"],
        "LowerLeg": [f"lowerleg01.{s}", f"lowerleg02.{s}"],
        "Foot": [f"foot.{s}"],
        "Eye": [f"eye.{s}"],
    }
    for finger, number in _FINGERS.items():
        for k, phalanx in enumerate(_PHALANGES.get(finger, ("Proximal", "Intermediate", "Distal")), 1):
            limbs[f"{finger}{phalanx}"] = [f"finger{number}-{k}.{s}"]
    return {f"{side}{name}": joints for name, joints in limbs.items()}


#: humanoid joint -> Anny joints. For a spine pair the rotation is halved over both; for a limb pair the
#: first takes the swing and half of the twist about the bone, the second the other half of the twist.
HUMANOID: dict[str, list[str]] = {
    "hips": ["root"],
    "spine": ["spine05", "spine04"],
    "chest": ["spine03", "spine02"],
    "upperChest": ["spine01"],
    "neck": ["neck01", "neck02"],
    "head": ["head"],
    **_side("left", "L"),
    **_side("right", "R"),
}


def bone_axes(names: list[str], parents: list[int], positions: np.ndarray) -> dict[str, list[float]]:
    """Unit direction of each limb bone on the reference body, for swing and twist, {humanoid: (3,)}.

    positions: (J, 3), metres, glTF axes.
    """
    axes = {}
    for humanoid, joints in HUMANOID.items():
        if len(joints) == 2 and humanoid.startswith(("left", "right")):
            first, second = (names.index(j) for j in joints)
            end = next(i for i, p in enumerate(parents) if p == second)
            axis = positions[end] - positions[first]
            axes[humanoid] = [round(float(x), 6) for x in axis / np.linalg.norm(axis)]
    return axes
