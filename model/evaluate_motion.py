"""How near pixel cloth comes to drapes in captured movement: `python -m evaluate_motion humanoid3d_walk --frames 24`.

Frames spread over a clip of `captured` or a BVH file, the T-shirt simulated in each as for training
(`teacher.pixel_drapes`), beside skinning and DeePSD (Jin et al. 2020, Figure 12). The legs stand still, as in training;
frames in which the body meets itself are left out. With --save, also a picture of some frames.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from body.anny_body import AnnyBody
from body.clearance import sample_bodies
from captured import CLIPS, Pose, clip_of, frames
from pixel_data import Drapes, shirt, worn
from pixel_filter import offsets_of
from pixel_poses import LEGS
from pixel_scenes import draped, scenes
from pixel_tables import deepsd, off, served
from relax import skinned
from teacher.checks import Limits
from teacher.garment import simulated
from train_pixel import answers
from training_data import DATA, Sample

#: Joints that stand still.
STILL = (*LEGS, "leftFoot", "rightFoot")


def at_rest(sample: Sample, poses: list[Pose], scratch: Path) -> Drapes:
    """The T-shirt in poses, without drapes that are at fault."""
    entry, x, found = simulated(worn(sample), poses, scratch)
    faults = [j.fault(Limits()) for j in found]
    rows = torch.tensor([k for k, fault in enumerate(faults) if fault is None], dtype=torch.long)
    print(f"{len(rows)} drapes good, the others: {', '.join(filter(None, faults)) or 'none'}")
    return Drapes(torch.as_tensor(x)[rows], entry.transforms[rows], rows)


@torch.no_grad()
def ways(sample: Sample, drapes: Drapes) -> dict[str, Tensor]:
    """Cloth of every way to drape, (D, N, 3) each, before any resolve."""
    garment, net, smooth = served(sample)
    data = scenes(garment, drapes, "reference")
    offsets = smooth.apply(offsets_of(answers(net, garment, data), garment, data))
    rest = sample.vertices.expand(len(drapes.x), -1, -1)
    return {
        "skinning": skinned(sample, rest, drapes.transforms).posed,
        "deepsd": deepsd(sample, drapes),
        f"pixel_cloth, {len(smooth.components)} components": draped(offsets, garment, data),
    }


def picture(path: Path, sample: Sample, drapes: Drapes, found: dict[str, Tensor], rows: int) -> None:
    """Some drapes, one a row, every way beside the simulated cloth."""
    # Drawing is not among what training needs.
    from figures.drawing import CLOTH, Drawn, cell, grid
    from figures.pixel_cloth import bodies

    some = np.linspace(0, len(drapes.x) - 1, min(rows, len(drapes.x))).astype(int)
    skin, faces, cloth = bodies(drapes).numpy(), AnnyBody.load().triangles, sample.tables[2].numpy()
    columns = {**found, "simulated": drapes.x}
    dressed = lambda k, x: cell([Drawn(skin[k], faces), Drawn(x[k].numpy(), cloth, CLOTH[0])])  # noqa: E731
    path.parent.mkdir(parents=True, exist_ok=True)
    grid([[dressed(k, x) for x in columns.values()] for k in some], tuple(columns)).save(path)
    print(path)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("clip", metavar="CLIP", help=f"a BVH file, or one of {', '.join(CLIPS)}")
    p.add_argument("--frames", type=int, default=24)
    p.add_argument("--save", type=Path, metavar="DIR", help="where to put a picture of some frames")
    a = p.parse_args()
    # Of the reference body alone, which is what drapes are on: a heavy one would have its arms lifted further.
    poses = frames(clip_of(a.clip), a.frames, sample_bodies()[:1], STILL)
    sample = shirt()
    drapes = at_rest(sample, poses, DATA / "motion" / Path(a.clip).stem)
    found = ways(sample, drapes)
    print("\n| | error cm | degrees |\n|---|---:|---:|")
    for name, x in found.items():
        print(f"| {name} | {off(x, drapes.x, sample.tables[2])} |")
    if a.save:
        picture(a.save / f"{Path(a.clip).stem}.png", sample, drapes, found, 6)


if __name__ == "__main__":
    torch.set_num_threads(1)
    main()
