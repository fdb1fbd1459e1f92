"""A pose put together from anatomical angles and targets: torso, arms, legs, hands.

Angles are in degrees and meant for the left side; the right side mirrors them. Directions and
positions are of the reference body in the A-pose, glTF axes. The knee and the elbow bend about the one
hinge that the A-pose shows (it is bent at both), so that a turn of the limb is a turn of the whole.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from body import quaternions as qt
from body.anny_body import AnnyBody

Array = NDArray[np.float64]
SIDES = {"left": 1.0, "right": -1.0}
FINGERS = {"Index": 1.0, "Middle": 1.1, "Ring": 1.2, "Little": 1.3}
#: Arms raised beyond this take the clavicle with them by a third (scapulohumeral rhythm).
CLAVICLE_FROM, CLAVICLE_SHARE, CLAVICLE_MOST = 55.0, 1 / 3, 32.0


class Limb:
    """Two bones and their hinge: an arm or a leg of the reference body."""

    def __init__(self, side: str, upper: str, lower: str, end: str) -> None:
        joints = reference_joints()
        self.upper, self.lower, self.end = side + upper, side + lower, side + end
        self.root, self.middle, self.tip = (joints[n] for n in (self.upper, self.lower, self.end))
        first, second = self.middle - self.root, self.tip - self.middle
        self.lengths = float(np.linalg.norm(first)), float(np.linalg.norm(second))
        self.first, self.second = first / self.lengths[0], second / self.lengths[1]
        hinge = np.cross(self.first, self.second)
        self.hinge = hinge / np.linalg.norm(hinge)
        self.bend = float(np.degrees(np.arccos(self.first @ self.second)))


@lru_cache(1)
def reference_joints() -> dict[str, Array]:
    """Humanoid joint -> its position on the reference body, (3,)."""
    body = AnnyBody.load()
    joints = body.shape().joints
    return {name: joints[body.joint_names.index(own[0])] for name, own in body.meta["humanoid"].items()}


@lru_cache
def arm(side: str) -> Limb:
    return Limb(side, "UpperArm", "LowerArm", "Hand")


@lru_cache
def leg(side: str) -> Limb:
    return Limb(side, "UpperLeg", "LowerLeg", "Foot")


def mirror(side: str, v: ArrayLike) -> Array:
    """A direction of the left side, on `side`."""
    return np.asarray(v, dtype=float) * [SIDES[side], 1, 1]


def euler(pitch: float = 0.0, yaw: float = 0.0, roll: float = 0.0) -> Array:
    """Bend forwards (pitch), turn to the left (yaw), lean to the right (roll), degrees."""
    return qt.multiply(qt.about(qt.Y, yaw), qt.about(qt.Z, -roll), qt.about(qt.X, pitch))


def arc(a: Array, b: Array) -> Array:
    """Shortest rotation that takes unit vector a to b."""
    q = np.append(np.cross(a, b), 1 + a @ b)
    length = np.linalg.norm(q)
    return q / length if length > 1e-6 else qt.about(qt.Z, 180)


class Posture:
    """Rotations being collected: {humanoid joint: quaternion xyzw}, with the hips' translation in metres."""

    def __init__(self) -> None:
        self.rotations: dict[str, Array] = {}
        self.translation = np.zeros(3)

    def turn(self, name: str, q: Array) -> None:
        self.rotations[name] = q

    def torso(self, lumbar: Array, thoracic: Array) -> None:
        """Bend the spine below and in the ribcage."""
        self.turn("spine", lumbar)
        self.turn("chest", qt.half(thoracic))
        self.turn("upperChest", qt.half(thoracic))

    def head(self, q: Array) -> None:
        """Turn the head against the chest, shared with the neck."""
        self.turn("neck", qt.half(q))
        self.turn("head", qt.half(q))

    def arm(self, side: str, raised: float, forward: float, bend: float, turn: float = 0.0) -> None:
        """Raise the upper arm from hanging by `raised`, towards the side (forward = 0) or the front (90);
        bend the elbow to `bend` (0 is straight); turn the arm about its bone (positive: outwards)."""
        e, a = np.radians([raised, forward])
        direction = mirror(side, [np.sin(e) * np.cos(a), -np.cos(e), np.sin(e) * np.sin(a)])
        limb = arm(side)
        about_bone = qt.about(limb.first, -SIDES[side] * turn)
        self._arm(side, qt.multiply(arc(limb.first, direction), about_bone), bend)

    def reach(self, side: str, wrist: ArrayLike, elbow: ArrayLike) -> None:
        """Bring the wrist to a point near the unbent torso, elbow towards a direction (both of the left side)."""
        limb = arm(side)
        upper = self._two_bones(limb, limb.root, mirror(side, wrist), mirror(side, elbow))
        self._arm(side, *upper)

    def _arm(self, side: str, upper: Array, bend: float) -> None:
        limb = arm(side)
        clavicle = clavicle_of(limb, upper)
        self.turn(f"{side}Shoulder", clavicle)
        self.turn(limb.upper, qt.multiply(qt.inverse(clavicle), upper))
        self.turn(limb.lower, qt.about(limb.hinge, bend - limb.bend))

    def forearm(self, side: str, turn: float) -> None:
        """Turn the forearm about its bone (positive: the palm backwards, pronation)."""
        limb = arm(side)
        about_bone = qt.about(limb.second, SIDES[side] * turn)
        self.turn(limb.lower, qt.multiply(self.rotations.get(limb.lower, qt.IDENTITY), about_bone))

    def hand(self, side: str, bend: float = 0.0, deviate: float = 0.0, curl: float = 18.0) -> None:
        """Bend the wrist towards the palm, deviate it towards the thumb, curl the fingers."""
        across, palm = hand_axes(side)
        self.turn(f"{side}Hand", qt.multiply(qt.about(across, bend), qt.about(palm, deviate)))
        for finger, share in FINGERS.items():
            for phalanx in ("Proximal", "Intermediate", "Distal"):
                self.turn(f"{side}{finger}{phalanx}", qt.about(across, curl * share))

    def leg(self, side: str, forward: float, out: float, bend: float, turn: float = 0.0) -> None:
        """Swing the thigh forwards and outwards from the A-pose, turn it (positive: toes out), bend the knee."""
        limb = leg(side)
        s = SIDES[side]
        upper = qt.multiply(qt.about(qt.Z, s * out), qt.about(qt.X, -forward), qt.about(limb.first, -s * turn))
        self.turn(limb.upper, upper)
        self.turn(limb.lower, qt.about(limb.hinge, bend - limb.bend))

    def plant(self, side: str, ankle: ArrayLike, knee: ArrayLike = (0.12, 0, 1), foot: Array = qt.IDENTITY) -> None:
        """Put the ankle at a point of the world (of that side as it is), the knee towards a direction
        (of the left side), the foot turned by `foot` against its rest. Call it after the hips are set."""
        limb, hips = leg(side), self.rotations.get("hips", qt.IDENTITY)
        pelvis = reference_joints()["hips"]
        root = pelvis + self.translation + qt.rotate(hips, limb.root - pelvis)
        upper, bend = self._two_bones(limb, root, np.asarray(ankle, float), qt.rotate(hips, mirror(side, knee)))
        lower = qt.about(limb.hinge, bend - limb.bend)
        self.turn(limb.upper, qt.multiply(qt.inverse(hips), upper))
        self.turn(limb.lower, lower)
        self.turn(limb.end, qt.multiply(qt.inverse(qt.multiply(upper, lower)), foot))

    def flat_foot(self, side: str, yaw: float = 0.0) -> None:
        """Level the foot whatever the leg does, toes `yaw` outwards."""
        limb = leg(side)
        chain = ("hips", limb.upper, limb.lower)
        above = qt.multiply(*(self.rotations.get(n, qt.IDENTITY) for n in chain))
        self.turn(limb.end, qt.multiply(qt.inverse(above), qt.about(qt.Y, SIDES[side] * yaw)))

    @staticmethod
    def _two_bones(limb: Limb, root: Array, target: Array, towards: Array) -> tuple[Array, float]:
        """Upper rotation and bend in degrees that bring the limb's tip to the target (law of cosines)."""
        a, b = limb.lengths
        span = target - root
        reach = float(np.clip(np.linalg.norm(span), abs(a - b) + 1e-3, (a + b) * 0.9995))
        along = span / np.linalg.norm(span)
        side = towards - along * (towards @ along)
        side /= np.linalg.norm(side)
        cosine = (a * a + reach * reach - b * b) / (2 * a * reach)
        first = along * cosine + side * np.sqrt(max(0.0, 1 - cosine * cosine))
        hinge = np.cross(first, along)
        hinge /= np.linalg.norm(hinge)
        frame = np.stack([first, hinge, np.cross(first, hinge)], 1)
        own = np.stack([limb.first, limb.hinge, np.cross(limb.first, limb.hinge)], 1)
        bend = np.degrees(np.arccos((reach * reach - a * a - b * b) / (2 * a * b)))
        return qt.from_matrix(frame @ own.T), float(bend)


def clavicle_of(limb: Limb, upper: Array) -> Array:
    """The clavicle's share of raising an arm whose whole rotation against the chest is `upper`."""
    direction = qt.rotate(upper, limb.first)
    raised = float(np.degrees(np.arccos(np.clip(-direction[1], -1, 1))))
    angle = min(CLAVICLE_MOST, max(0.0, raised - CLAVICLE_FROM) * CLAVICLE_SHARE)
    axis = np.cross(limb.first, direction)
    length = np.linalg.norm(axis)
    return qt.about(axis, angle) if length > 1e-6 and angle > 0 else qt.IDENTITY


@lru_cache
def hand_axes(side: str) -> tuple[Array, Array]:
    """Axes of a hand: across the palm (turning about it bends the fingers), and out of the palm's back."""
    joints = reference_joints()
    across = joints[f"{side}LittleProximal"] - joints[f"{side}IndexProximal"]
    across = across * SIDES[side] / np.linalg.norm(across)
    along = joints[f"{side}MiddleProximal"] - joints[f"{side}Hand"]
    palm = np.cross(along, across)
    return across, palm / np.linalg.norm(palm)
