"""Poses of captured movement that drapes are made in."""

from __future__ import annotations

import numpy as np

from body import quaternions as qt
from body.clearance import Clearance
from body.motion_capture import Clip, retargeted
from body.pose_sampling import cleared
from body.posture import SIDES, arm

Pose = dict[str, np.ndarray]
#: Frames tried for each that is wanted, because some are left out.
TRIED = 4


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
