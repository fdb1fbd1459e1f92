"""Motion capture as poses of the humanoid: a reader of BVH files, and retargeting.

A BVH skeleton rests in a pose of its own (arms out, or down) with bones of its own lengths, so its local rotations mean
nothing here. Upper arms, forearms, thighs and shins are pointed where the captured ones point; pelvis, loins, ribcage,
head and feet, which are upright in every rest pose, turn as far from it as the captured ones do.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from body import quaternions as qt
from body.posture import SIDES, Limb, Posture, arc, arm, clavicle_of, leg

Array = NDArray[np.float64]
#: Names of a joint in CMU's files, in cgspeed's and in MakeHuman's, in lower case; {s} and {side} are l and left.
NAMES = {
    "hips": ("hips", "hip", "pelvis"),
    "spine": ("spine", "abdomen"),
    "chest": ("spine2", "spine1", "chest"),
    "head": ("head",),
    "UpperArm": ("{side}arm", "{s}shldr", "{s}shoulder"),
    "LowerArm": ("{side}forearm", "{s}forearm", "{s}elbow"),
    "Hand": ("{side}hand", "{s}hand"),
    "UpperLeg": ("{side}upleg", "{s}thigh", "{s}hip"),
    "LowerLeg": ("{side}leg", "{s}shin", "{s}knee"),
    "Foot": ("{side}foot", "{s}foot"),
}
#: Sine of the bend from which on a limb's hinge begins to show, and from which on it is believed.
STRAIGHT, BENT = 0.09, 0.34
#: Least cosine between the rest pose's up or left and an axis of the file.
UPRIGHT = 0.9


@dataclass(frozen=True)
class Clip:
    """T captured frames of J joints, in the file's axes and units; parents come before their children."""

    names: tuple[str, ...]
    parents: tuple[int, ...]  # -1 is none
    offsets: Array  # (J, 3) from the parent, at rest
    turns: Array  # (T, J, 3, 3) world rotations; at rest nothing turns
    positions: Array  # (T, J, 3) world
    seconds: float  # a frame

    def rest(self) -> Array:
        """Where the joints are when nothing turns, (J, 3)."""
        out = self.offsets.copy()
        for j, parent in enumerate(self.parents):
            if parent >= 0:
                out[j] += out[parent]
        return out


@dataclass
class _Hierarchy:
    """Joints in the order of the file; their channels are the columns of a frame."""

    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    offsets: list[list[float]] = field(default_factory=list)
    channels: list[list[str]] = field(default_factory=list)


def read_bvh(text: str) -> Clip:
    """A BVH file's text. Raises ValueError that says what is wrong with it."""
    words = iter(text.split())
    _expect(words, "HIERARCHY", "ROOT")
    found = _Hierarchy()
    _joint(words, found, -1)
    _expect(words, "MOTION", "Frames:")
    count = _number(words)
    _expect(words, "Frame", "Time:")
    seconds = _number(words)
    if count != int(count) or count < 1 or seconds <= 0:
        raise ValueError(f"{count:g} frames of {seconds:g} s: both must be positive, and the first whole")
    width = sum(map(len, found.channels))
    try:
        values = np.array(list(words), dtype=float)
    except ValueError as e:
        raise ValueError(f"a frame holds something that is not a number: {e}") from None
    if len(values) != count * width or not np.isfinite(values).all():
        raise ValueError(f"{int(count)} frames of {width} channels need as many finite numbers, not {len(values)}")
    turns, positions = _world(found, values.reshape(int(count), width))
    return Clip(tuple(found.names), tuple(found.parents), np.array(found.offsets), turns, positions, seconds)


def _expect(words: Iterator[str], *wanted: str) -> None:
    for word in wanted:
        if (got := next(words, "the end")) != word:
            raise ValueError(f"{word} expected, {got} found")


def _number(words: Iterator[str]) -> float:
    word = next(words, "the end")
    try:
        value = float(word)
    except ValueError:
        raise ValueError(f"a number expected, {word} found") from None
    if not np.isfinite(value):
        raise ValueError(f"a finite number expected, {word} found")
    return value


def _joint(words: Iterator[str], found: _Hierarchy, parent: int) -> None:
    """A joint and its descendants, from its name on. Raises ValueError."""
    own, opened = len(found.names), [parent]
    name = next(words, "the end")
    while True:
        if name in found.names:
            raise ValueError(f"two joints are called {name}")
        _expect(words, "{", "OFFSET")
        found.names.append(name)
        found.parents.append(opened[-1])
        found.offsets.append([_number(words) for _ in range(3)])
        _expect(words, "CHANNELS")
        found.channels.append(_channels(words, name))
        opened.append(len(found.names) - 1)
        while (word := next(words, "the end")) != "JOINT":
            if word == "End":
                _expect(words, "Site", "{", "OFFSET")
                _ = [_number(words) for _ in range(3)]
                _expect(words, "}")
            elif word != "}":
                raise ValueError(f"JOINT, End Site or }} expected in {found.names[opened[-1]]}, {word} found")
            elif opened.pop() == own:
                return
        name = next(words, "the end")


def _channels(words: Iterator[str], name: str) -> list[str]:
    """Channels of a joint, as "r" or "p" and an axis."""
    out = [next(words, "the end") for _ in range(int(_number(words)))]
    for word in out:
        if word[:1].upper() not in "XYZ" or word[1:].lower() not in ("rotation", "position") or out.count(word) > 1:
            raise ValueError(f"{name} has channels {' '.join(out)}")
    return [word[1].lower() + word[0].upper() for word in out]


def _world(found: _Hierarchy, values: Array) -> tuple[Array, Array]:
    """World rotations (T, J, 3, 3) and positions (T, J, 3) of the joints by the frames' channels (T, C)."""
    turns = np.tile(np.eye(3), (len(values), len(found.names), 1, 1))
    positions = np.tile(np.array(found.offsets), (len(values), 1, 1))
    at = 0
    for j, (parent, channels) in enumerate(zip(found.parents, found.channels, strict=True)):
        own = dict(zip(channels, values[:, at : at + len(channels)].T, strict=True))
        at += len(channels)
        order = "".join(c[1] for c in channels if c[0] == "r")
        if order:
            angles = np.stack([own["r" + axis] for axis in order], 1)
            turns[:, j] = Rotation.from_euler(order, angles, degrees=True).as_matrix()
        for k, axis in enumerate("XYZ"):
            if "p" + axis in own:
                positions[:, j, k] = own["p" + axis]
        if parent >= 0:
            positions[:, j] = positions[:, parent] + (turns[:, parent] @ positions[:, j, :, None])[..., 0]
            turns[:, j] = turns[:, parent] @ turns[:, j]
    return turns, positions


def retargeted(clip: Clip, frames_per_second: float) -> list[dict[str, Array]]:
    """The clip's poses at a rate, the nearest frame each, as {humanoid joint: quaternion xyzw}.

    Hands, fingers, collars and turns of the forearm about its bone are not taken over. Raises ValueError where a joint
    is missing or the skeleton does not rest upright.
    """
    if not frames_per_second > 0:
        raise ValueError(f"{frames_per_second:g} frames a second")
    joints = joints_of(clip)
    axes = axes_of(clip, joints)
    count = 1 + int((len(clip.turns) - 1) * clip.seconds * frames_per_second + 1e-6)
    frames = np.rint(np.arange(count) / (clip.seconds * frames_per_second)).astype(int).clip(0, len(clip.turns) - 1)
    picked = list(joints.values())
    turns = axes @ clip.turns[frames][:, picked] @ axes.T
    places = clip.positions[frames][:, picked] @ axes.T
    by_name = lambda rows: dict(zip(joints, rows, strict=True))  # noqa: E731
    return [pose(by_name(turn), by_name(place)) for turn, place in zip(turns, places, strict=True)]


def joints_of(clip: Clip) -> dict[str, int]:
    """Humanoid joint -> the clip's joint. Raises ValueError on one that is missing."""
    there = {name.split(":")[-1].lower(): j for j, name in reversed(list(enumerate(clip.names)))}
    out = {}
    for part, names in NAMES.items():
        for side in ("",) if part[0].islower() else SIDES:
            wanted = [name.format(side=side, s=side[:1]) for name in names]
            known = [there[name] for name in wanted if name in there]
            if not known:
                raise ValueError(f"no joint for {side}{part}: none is called {' or '.join(wanted)}")
            out[side + part] = known[0]
    return out


def axes_of(clip: Clip, joints: dict[str, int]) -> Array:
    """Left, up and ahead of the rest pose in the file's axes, rows of (3, 3). Raises ValueError."""
    rest = clip.rest()
    left = rest[joints["leftUpperLeg"]] - rest[joints["rightUpperLeg"]]
    up = rest[joints["head"]] - rest[joints["hips"]]
    rows = []
    for v in (left, up):
        k = int(np.argmax(np.abs(v)))
        if np.abs(v[k]) <= UPRIGHT * np.linalg.norm(v):
            raise ValueError("the skeleton's rest pose does not stand upright along the file's axes")
        rows.append(np.sign(v[k]) * np.eye(3)[k])
    if np.any(rows[0] * rows[1]):
        raise ValueError("the skeleton's rest pose is as wide as it is high")
    return np.stack([*rows, np.cross(*rows)])


def pose(turns: dict[str, Array], places: dict[str, Array]) -> dict[str, Array]:
    """Humanoid rotations by world rotations (3, 3) and positions (3,) of the captured joints, x left, y up."""
    p = Posture()
    turn = {name: qt.from_matrix(turns[name]) for name in ("hips", "spine", "chest", "head", "leftFoot", "rightFoot")}
    against = lambda name, parent: qt.multiply(qt.inverse(parent), turn[name])  # noqa: E731
    p.turn("hips", turn["hips"])
    p.torso(against("spine", turn["hips"]), against("chest", turn["spine"]))
    p.head(against("head", turn["chest"]))
    for side in SIDES:
        limb = arm(side)
        upper, lower = aimed(limb, *_bones(limb, turns["chest"], places))
        clavicle = clavicle_of(limb, upper)
        p.turn(f"{side}Shoulder", clavicle)
        p.turn(limb.upper, qt.multiply(qt.inverse(clavicle), upper))
        p.turn(limb.lower, lower)
        limb = leg(side)
        upper, lower = aimed(limb, *_bones(limb, turns["hips"], places))
        p.turn(limb.upper, upper)
        p.turn(limb.lower, lower)
        p.turn(limb.end, against(limb.end, qt.multiply(turn["hips"], upper, lower)))
    return p.rotations


def _bones(limb: Limb, trunk: Array, places: dict[str, Array]) -> tuple[Array, Array]:
    """Unit directions (3,) of a captured limb's bones in what it hangs from, which is turned by (3, 3)."""
    along = (places[limb.lower] - places[limb.upper], places[limb.end] - places[limb.lower])
    first, second = (v @ trunk / max(np.linalg.norm(v), 1e-9) for v in along)
    return first, second


def aimed(limb: Limb, first: Array, second: Array) -> tuple[Array, Array]:
    """Rotations of a limb's two joints, the second against the first, that point its bones in unit directions (3,).

    A bent limb shows its hinge; a straight one turns from the A-pose the shortest way.
    """
    shortest = qt.rotate(arc(limb.first, first), limb.hinge)
    shown = np.cross(first, second)
    sine = float(np.linalg.norm(shown))
    share = float(np.clip((sine - STRAIGHT) / (BENT - STRAIGHT), 0, 1))
    hinge = (1 - share) * shortest + share * shown / max(sine, 1e-9)
    length = np.linalg.norm(hinge)
    hinge = hinge / length if length > 1e-6 else shortest
    frame = np.stack([first, hinge, np.cross(first, hinge)], 1)
    own = np.stack([limb.first, limb.hinge, np.cross(limb.first, limb.hinge)], 1)
    upper = qt.from_matrix(frame @ own.T)
    return upper, arc(limb.second, qt.rotate(qt.inverse(upper), second))
