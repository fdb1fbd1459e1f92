"""Poses of captured movement that drapes are made in."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from body import quaternions as qt
from body.clearance import Clearance, sample_bodies
from body.mimic_clips import read_mimic
from body.motion_capture import Clip, read_bvh, retargeted
from body.pose_sampling import cleared
from body.posture import SIDES, arm

Pose = dict[str, np.ndarray]
#: Frames tried for each that is wanted, because some are left out.
TRIED = 4
#: Clips that `pybullet` ships (`requirements-teacher.txt`): of people who walk, turn, run, dance, jump and fight.
CLIPS = (
    "humanoid3d_walk", "walker/0walk_forward", "walker/turn_left0", "walker/turn_left1", "walker/turn_right0",
    "walker/turn_right1", "humanoid3d_run", "humanoid3d_dance_a", "humanoid3d_dance_b", "humanoid3d_jump",
    "humanoid3d_kick", "humanoid3d_punch", "humanoid3d_spin", "humanoid3d_spinkick",
)  # fmt: skip
#: Poses of these in a second: nearer ones hardly differ.
RATE = 12.0
#: Cosine of how far a trunk may lean: nobody looks at clothes on people who lie or stand on their hands.
UPRIGHT = 0.5


def clip_of(source: str) -> Clip:
    """A clip of `CLIPS`, or of a BVH file. Raises ValueError on a file that is neither, FileNotFoundError."""
    if source not in CLIPS:
        return read_bvh(Path(source).read_text())
    # Among what simulating needs, not among what training on relaxed cloth does.
    import pybullet_data

    return read_mimic((Path(pybullet_data.getDataPath()) / "data" / "motions" / f"{source}.txt").read_text())


@lru_cache(1)
def captured_poses() -> list[Pose]:
    """Every upright pose of `CLIPS` in which cloth has room, on the reference body and on a heavy one."""
    found = [cleared(pose, sample_bodies()) for name in CLIPS for pose in retargeted(clip_of(name), RATE)]
    return [pose for pose in found if pose is not None and upright(pose)]


def upright(pose: Pose) -> bool:
    """Whether the trunk leans by less than 60 degrees."""
    return bool(qt.rotate(qt.multiply(pose["hips"], pose["spine"]), qt.Y)[1] > UPRIGHT)


def frames(clip: Clip, count: int, bodies: tuple[Clearance, ...], still: tuple[str, ...] = ()) -> list[Pose]:
    """`count` poses spread over a clip, or all that there are, in which none of `bodies` meets itself.

    Joints that are `still` do not turn; arms are lifted where they are too near the trunk. Raises ValueError when the
    bodies meet themselves in every frame.
    """
    rate = min(1 / clip.seconds, TRIED * count / (len(clip.turns) * clip.seconds))
    tried = [{k: q for k, q in pose.items() if k not in still} for pose in retargeted(clip, rate)]
    found = [(pose, cleared(pose, bodies)) for pose in tried]
    kept = [(before, after) for before, after in found if after is not None]
    if not kept:
        raise ValueError("the body meets itself in every frame")
    count = min(count, len(kept))
    # The middle of each stretch, because the first frame of many a clip is the rest pose.
    some = [kept[int((k + 0.5) * len(kept) / count)] for k in range(count)]
    lifts = np.array([[lift(*poses, side) for side in SIDES] for poses in some])
    dropped = f"{len(tried)} tried, {len(tried) - len(kept)} dropped as the body meets itself, {count} used"
    lifted = f"{(lifts > 1).sum()} of {lifts.size} arms lifted, all of them by {lifts.mean():.1f} degrees on average"
    print(f"{len(clip.turns)} frames of {1e3 * clip.seconds:.1f} ms: {dropped}; {lifted}, {lifts.max():.0f} at most")
    return [after for _, after in some]


def lift(before: Pose, after: Pose, side: str) -> float:
    """Degrees between an upper arm in two poses."""
    turned = qt.multiply(qt.inverse(before[arm(side).upper]), after[arm(side).upper])
    return float(np.degrees(2 * np.arctan2(np.linalg.norm(turned[:3]), abs(turned[3]))))
