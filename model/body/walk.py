"""One cycle of a natural walk in place, from foot paths and smooth periodic curves.

The stance foot rolls over heel, sole and toes, and its contact moves backwards at a constant speed, as
on a treadmill; the legs follow by two-bone inverse kinematics. Amplitudes after Perry & Burnfield,
Gait Analysis (2010): about 1.3 m/s, stance 60 % of the cycle.
"""

from __future__ import annotations

import numpy as np

from body import quaternions as qt
from body.posture import SIDES, Posture, euler, leg

FRAMES, FRAME_RATE = 28, 24
#: Contact, loaded, passing and push-off of the left leg.
KEY_FRAMES = (0, 4, 9, 20)
STANCE, STEP = 0.6, 0.62  # share of the cycle; how far the sole travels while it bears, metres
#: Foot pitch (toes up positive, degrees) over the cycle from heel strike; rest is flat.
PITCH = ([0.0, 0.09, 0.34, 0.5, 0.62, 0.74, 0.88, 1.0], [19.0, 0.0, 0.0, -9.0, -36.0, -26.0, 12.0, 19.0])
HEEL, TOES = np.array([0.0, -0.079, -0.036]), np.array([0.0, -0.079, 0.203])  # from the ankle, metres


def smooth(phase: float, keys: tuple[list[float], list[float]]) -> float:
    """Periodic curve through keys (phase in [0, 1], value), monotone between them (Fritsch & Carlson 1980)."""
    x, y = np.array(keys[0]), np.array(keys[1])
    slope = np.diff(y) / np.diff(x)
    around = np.concatenate([slope[-1:], slope, slope[:1]])
    product = around[:-1] * around[1:]
    total = around[:-1] + around[1:]
    tangent = np.where(product > 0, 2 * product / np.where(total == 0, 1, total), 0.0)
    k = int(np.clip(np.searchsorted(x, phase, side="right") - 1, 0, len(slope) - 1))
    h = x[k + 1] - x[k]
    t = (phase - x[k]) / h
    a, b = (1 + 2 * t) * (1 - t) ** 2, t * (1 - t) ** 2
    c, d = t * t * (3 - 2 * t), t * t * (t - 1)
    return float(a * y[k] + b * h * tangent[k] + c * y[k + 1] + d * h * tangent[k + 1])


def ankle_of_contact(z: float, pitch: float) -> tuple[float, float]:
    """Height and z of the ankle while the sole whose flat ankle would be at z bears, for a foot pitch."""
    pivot = HEEL if pitch > 0 else TOES
    turned = qt.rotate(qt.about(qt.X, -pitch), pivot)
    return float(-turned[1]), float(z + pivot[2] - turned[2])


def ankle(phase: float) -> tuple[float, float, float]:
    """Height, z and pitch of the ankle at a phase of its own cycle (0 = heel strike)."""
    pitch = smooth(phase, PITCH)
    if phase <= STANCE:
        y, z = ankle_of_contact(STEP * (0.5 - phase / STANCE), pitch)
        return y, z, pitch
    y0, z0 = ankle_of_contact(-STEP / 2, smooth(STANCE, PITCH))
    y1, z1 = ankle_of_contact(STEP / 2, PITCH[1][0])
    t = (phase - STANCE) / (1 - STANCE)
    speed = -STEP / STANCE * (1 - STANCE)
    z = hermite(t, (z0, z1), (speed * 0.3, speed * 0.25))
    y = hermite(t, (y0, y1), (0.12, -0.02)) + 0.014 * np.sin(np.pi * t) ** 2
    return float(y), float(z), pitch


def hermite(t: float, ends: tuple[float, float], slopes: tuple[float, float]) -> float:
    """Cubic between two values with given slopes, t in [0, 1]."""
    a, b, c, d = (1 + 2 * t) * (1 - t) ** 2, t * (1 - t) ** 2, t * t * (3 - 2 * t), t * t * (t - 1)
    return a * ends[0] + b * slopes[0] + c * ends[1] + d * slopes[1]


def frame(phase: float) -> Posture:
    """The body at a phase of the left leg's cycle in [0, 1)."""
    p = Posture()
    wave = lambda shift, times=1: float(np.cos(2 * np.pi * times * (phase - shift)))  # noqa: E731
    yaw, drop = -5.0 * wave(0.0), 4.0 * wave(0.13)
    p.turn("hips", euler(pitch=3, yaw=yaw, roll=-drop))
    p.translation[:] = [0.022 * wave(0.32), -0.022 - 0.02 * wave(0.06, 2), 0.0]
    p.torso(euler(pitch=-1, yaw=-yaw * 0.7, roll=drop * 0.6), euler(yaw=-yaw * 0.9, roll=drop * 0.5, pitch=1))
    p.head(euler(pitch=-2, yaw=yaw * 0.55, roll=-drop * 0.2))
    for side, s in SIDES.items():
        own = phase if side == "left" else (phase + 0.5) % 1.0
        y, z, pitch = ankle(own)
        foot = qt.multiply(qt.about(qt.Y, s * 5), qt.about(qt.X, -pitch))
        p.plant(side, [s * 0.09, y, z], knee=(0.08, 0, 1), foot=foot)
        arm_swing(p, side, -float(np.cos(2 * np.pi * (own - 0.03))))
    return p


def arm_swing(p: Posture, side: str, swing: float) -> None:
    """Arm against the leg: `swing` from -1 (behind) to 1 (in front)."""
    angle = 4 + 24 * swing
    out = 19.0
    direction = np.array([np.tan(np.radians(out)), -1.0, np.tan(np.radians(angle))])
    raised = float(np.degrees(np.arccos(1 / np.linalg.norm(direction))))
    forward = float(np.degrees(np.arctan2(direction[2], direction[0])))
    p.arm(side, raised, forward, 22 + 12 * swing)
    p.forearm(side, 12)
    p.hand(side, 6, curl=20)


def walk_cycle() -> list[Posture]:
    """The frames of one cycle; the frame after the last is the first."""
    return [frame(k / FRAMES) for k in range(FRAMES)]


def knee_bends() -> list[float]:
    """Bend of the left knee in each frame, degrees: two peaks, in loading and in swing."""
    limb = leg("left")
    bends = []
    for p in walk_cycle():
        q = p.rotations[limb.lower]
        bends.append(limb.bend + float(np.degrees(2 * np.arctan2(q[:3] @ limb.hinge, q[3]))))
    return bends
