"""Random natural poses to train cloth on: `sample_poses(count, seed)`.

A pose is drawn from a mixture of activities, each with anatomical angles within the joints' limits and
both sides correlated; then arms that come too near the trunk are lifted out, and what still collides on
the reference body or on a heavy one is thrown away.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from body import quaternions as qt
from body.clearance import Clearance, sample_bodies
from body.humanoid import Rotations
from body.posture import SIDES, Posture, arm, euler
from body.walk import arm_swing, frame

Array = np.ndarray
Rng = np.random.Generator
LIFT_STEP, LIFTS = 7.0, 4


def spread(rng: Rng, scale: float, size: int | None = None) -> Array | float:
    """Normal noise cut at two deviations, degrees."""
    return np.clip(rng.normal(0, scale, size), -2 * scale, 2 * scale)


def spine(p: Posture, rng: Rng, amount: float = 1.0) -> None:
    """Bend, turn and lean the trunk, lumbar and thoracic together; the head looks mostly ahead."""
    pitch = amount * (spread(rng, 9) + (rng.uniform(15, 50) if rng.random() < 0.12 * amount else 0))
    yaw, roll = amount * spread(rng, 13), amount * spread(rng, 8)
    share = rng.uniform(0.35, 0.65)
    p.torso(
        euler(pitch * share, yaw * share, roll * share),
        euler(pitch * 0.8 * (1 - share), yaw * (1 - share), roll * (1 - share)),
    )
    p.head(euler(-0.4 * pitch + spread(rng, 9), -0.3 * yaw + spread(rng, 22), -0.3 * roll + spread(rng, 6)))


def stand(p: Posture, rng: Rng) -> None:
    """Weight on both legs or, as in contrapposto, on one."""
    lean, turn = spread(rng, 4), spread(rng, 5)
    p.turn("hips", euler(spread(rng, 4), spread(rng, 8), lean))
    for side, s in SIDES.items():
        free = max(0.0, lean * s) / 4
        p.leg(
            side,
            spread(rng, 5) + 9 * free,
            s * lean + rng.uniform(-4, 7),
            3 + abs(spread(rng, 4)) + 16 * free,
            turn + rng.uniform(-4, 14),
        )
        p.flat_foot(side, rng.uniform(-2, 16))
    spine(p, rng)


def walk(p: Posture, rng: Rng) -> None:
    """A phase of the walk, its stride shortened or lengthened, the arms swinging with it or not."""
    phase, stride = rng.random(), rng.choice([rng.uniform(0.5, 1.0), rng.uniform(1.0, 1.75)])
    step = frame(phase)
    for name, q in step.rotations.items():
        p.turn(name, scaled(q, stride) if name.endswith(("UpperLeg", "LowerLeg", "hips")) else q)
    for k, side in enumerate(SIDES):
        p.flat_foot(side, rng.uniform(-2, 12))
        foot = p.rotations[f"{side}Foot"]
        p.turn(f"{side}Foot", qt.multiply(foot, qt.about(qt.X, rng.uniform(-12, 30))))
        arm_swing(p, side, -stride * float(np.cos(2 * np.pi * (phase + 0.5 * k))))
    lean = spread(rng, 7)
    p.turn("spine", qt.multiply(p.rotations["spine"], euler(lean, spread(rng, 6), spread(rng, 3))))
    p.head(euler(spread(rng, 8), spread(rng, 18), spread(rng, 4)))


def scaled(q: Array, amount: float) -> Array:
    """A rotation with its angle multiplied."""
    angle = 2 * np.degrees(np.arctan2(np.linalg.norm(q[:3]), q[3]))
    return qt.about(q[:3], angle * amount) if angle > 1e-6 else qt.IDENTITY


def sit(p: Posture, rng: Rng) -> None:
    """Seated, from a high stool to a low sofa; sometimes one knee is higher or the legs are apart."""
    thigh, apart = rng.uniform(60, 100), rng.uniform(0, 20)
    p.turn("hips", euler(rng.uniform(-14, 10), 0, spread(rng, 2)))
    for side in SIDES:
        own = thigh + spread(rng, 5)
        p.leg(side, own, apart + spread(rng, 4), own + rng.uniform(-35, 12), spread(rng, 8))
        p.flat_foot(side, rng.uniform(-4, 14))
    spine(p, rng, 0.8)


def squat(p: Posture, rng: Rng) -> None:
    depth, apart = rng.uniform(0.3, 1.0), rng.uniform(4, 26)
    p.turn("hips", euler(depth * rng.uniform(15, 38), 0, 0))
    for side in SIDES:
        thigh = depth * 112 + spread(rng, 4)
        p.leg(side, thigh, apart, depth * rng.uniform(112, 124), apart * 0.6 + spread(rng, 5))
        p.flat_foot(side, apart * 0.8)
    spine(p, rng, 0.6)


def lunge(p: Posture, rng: Rng) -> None:
    front, back = rng.permutation(list(SIDES))
    depth = rng.uniform(0.3, 1.0)
    p.turn("hips", euler(spread(rng, 8), spread(rng, 6), 0))
    p.leg(front, 25 + 60 * depth, rng.uniform(-2, 8), 10 + 75 * depth + spread(rng, 6), spread(rng, 5))
    p.leg(
        back,
        -rng.uniform(8, 26) * (0.5 + depth / 2),
        rng.uniform(-2, 6),
        rng.uniform(8, 30) + 45 * depth,
        spread(rng, 4),
    )
    p.flat_foot(front, rng.uniform(-2, 10))
    spine(p, rng, 0.7)


def step_out(p: Posture, rng: Rng) -> None:
    """Any leg anywhere within its limits: kicks, steps aside, a raised knee."""
    active = rng.choice(list(SIDES))
    p.turn("hips", euler(spread(rng, 6), spread(rng, 8), spread(rng, 5)))
    for side in SIDES:
        reach = 1.0 if side == active else 0.25
        bend = reach * rng.uniform(0, 1) ** 1.5 * 115
        p.leg(side, reach * rng.uniform(-25, 85), -2 + reach * rng.uniform(-4, 42), 4 + bend, reach * spread(rng, 14))
        if side != active:
            p.flat_foot(side, rng.uniform(0, 12))
    spine(p, rng)


def hang(p: Posture, rng: Rng, side: str) -> None:
    p.arm(side, rng.uniform(13, 30), rng.uniform(-45, 75), rng.uniform(6, 40), spread(rng, 14))


def lift_aside(p: Posture, rng: Rng, side: str) -> None:
    p.arm(side, rng.uniform(30, 100), rng.uniform(-20, 35), rng.uniform(4, 60), spread(rng, 25))


def lift_forward(p: Posture, rng: Rng, side: str) -> None:
    p.arm(side, rng.uniform(25, 110), rng.uniform(40, 95), rng.uniform(4, 95), spread(rng, 20))


def lift_up(p: Posture, rng: Rng, side: str) -> None:
    p.arm(side, rng.uniform(110, 165), rng.uniform(0, 80), rng.uniform(4, 70), rng.uniform(-30, 30))


def on_hip(p: Posture, rng: Rng, side: str) -> None:
    p.reach(
        side,
        [rng.uniform(0.28, 0.34), rng.uniform(1.04, 1.18), rng.uniform(-0.02, 0.12)],
        [1, rng.uniform(-0.1, 0.3), rng.uniform(-0.7, 0.2)],
    )


def bent_up(p: Posture, rng: Rng, side: str) -> None:
    """The forearm raised from an arm held out: waving, a phone at the ear, hands behind the head."""
    p.arm(side, rng.uniform(60, 120), rng.uniform(-5, 60), rng.uniform(60, 125), rng.uniform(30, 85))


def to_side(p: Posture, rng: Rng, side: str) -> None:
    """Back to the A-pose, more or less: what outfits are fitted in."""
    p.arm(side, 42 + spread(rng, 6), spread(rng, 10), 42 + spread(rng, 12), spread(rng, 6))


Body = Callable[[Posture, Rng], None]
Choice = TypeVar("Choice")
Arm = Callable[[Posture, Rng, str], None]
BODIES: list[tuple[Body, float]] = [
    (stand, 0.34),
    (walk, 0.27),
    (sit, 0.09),
    (squat, 0.07),
    (lunge, 0.09),
    (step_out, 0.14),
]
#: For training: deep bends are the hardest for cloth and learn slowest, so they come more often than in life.
DEMANDING: list[tuple[Body, float]] = [
    (stand, 0.24),
    (walk, 0.22),
    (sit, 0.15),
    (squat, 0.12),
    (lunge, 0.11),
    (step_out, 0.16),
]
ARMS: list[tuple[Arm, float]] = [
    (hang, 0.36), (lift_aside, 0.16), (lift_forward, 0.16), (lift_up, 0.1), (on_hip, 0.1), (bent_up, 0.07),
    (to_side, 0.05),
]  # fmt: skip
SAME_ARMS, CALM = 0.6, 0.25


def choose(rng: Rng, options: list[tuple[Choice, float]]) -> Choice:
    weights = np.array([w for _, w in options])
    return options[rng.choice(len(options), p=weights / weights.sum())][0]


def sample_pose(rng: Rng, activities: list[tuple[Body, float]] = BODIES) -> dict[str, Array]:
    """One random pose, {humanoid joint: quaternion xyzw}; not tested for collisions."""
    p = Posture()
    body = choose(rng, activities)
    body(p, rng)
    if body is not walk or rng.random() < 0.3:
        first = choose(rng, ARMS)
        for side in SIDES:
            move = first if side == "left" or rng.random() < SAME_ARMS else choose(rng, ARMS)
            move(p, rng, side)
    for side in SIDES:
        p.forearm(side, rng.uniform(-50, 40))
        p.hand(side, spread(rng, 14), spread(rng, 7), rng.uniform(0, 30))
    if rng.random() < CALM:
        amount = rng.uniform(0.3, 0.9)
        return {name: scaled(q, amount) for name, q in p.rotations.items()}
    return p.rotations


def lifted(rotations: Rotations, sides: tuple[bool, bool]) -> dict[str, Array]:
    """The pose with the named upper arms (left, right) swung a step further out from the trunk."""
    out = {name: np.asarray(q) for name, q in rotations.items()}
    for (side, s), lift in zip(SIDES.items(), sides, strict=True):
        if lift:
            name = arm(side).upper
            out[name] = qt.multiply(qt.about(qt.Z, s * LIFT_STEP), out.get(name, qt.IDENTITY))
    return out


def cleared(rotations: Rotations, bodies: tuple[Clearance, ...]) -> dict[str, Array] | None:
    """The pose with its arms lifted until cloth fits on all the bodies, or None where that does not help."""
    pose = {name: np.asarray(q) for name, q in rotations.items()}
    for body in bodies:
        for attempt in range(LIFTS + 1):
            room = body.room(pose)
            if not body.legs_clear(room):
                return None
            tight = body.tight_arms(room)
            if not any(tight):
                break
            if attempt == LIFTS:
                return None
            pose = lifted(pose, tight)
    return pose


def sample_poses(count: int, seed: int, activities: list[tuple[Body, float]] = BODIES) -> list[dict[str, Array]]:
    """`count` random poses without collisions; the same seed gives the same poses."""
    rng = np.random.default_rng(seed)
    poses: list[dict[str, Array]] = []
    while len(poses) < count:
        pose = cleared(sample_pose(rng, activities), sample_bodies())
        if pose is not None:
            poses.append(pose)
    return poses
