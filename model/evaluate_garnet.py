"""GarNet's tables on bodies never trained on (Gundogdu et al. 2020, Tables 1, 2, 5 and 6): `python -m evaluate_garnet`.

For every trained network (`train_garnet`) and for the warped garment alone: E_dist (equation 17), E_norm (18),
vertices behind the nearest body point, the curvature losses (13, 14), and the time of one drape. E_dist and E_norm
with their standard deviation over the drapes.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import astuple, dataclass

import numpy as np
import torch
from torch import Tensor

import garnet_losses as losses
from garnet_data import RELAXED, SIMULATED, SPLITS
from garnet_scenes import SCALES, Garment, Scenes, load
from nets.garnet import GarNet, Sizes, Variant
from outfits.garnet_garments import PATTERNS
from train_garnet import checkpoint, draped

#: Name, variant and fine-tuning of each row.
ROWS: tuple[tuple[str, Variant | None, str], ...] = (
    ("warped (DQS)", None, ""),
    ("naive", "naive", ""),
    ("global", "global", ""),
    ("local", "local", ""),
    ("local, RQ", "local", "rq"),
    ("local, MC", "local", "mc"),
)
HEADER = """\
| | E_dist cm | E_norm degrees | inside % | RQ mm4 | MC 1/m2 | ms | drapes |
|---|---:|---:|---:|---:|---:|---:|---:|"""


@dataclass(frozen=True)
class Figures:
    """Of one drape."""

    distance: float  # cm
    angle: float  # degrees
    inside: float  # percent of the vertices
    rayleigh: float  # mm4, sum over the scales
    mean_curvature: float  # 1/m2
    milliseconds: float


def figures(x: Tensor, garment: Garment, s: Scenes, milliseconds: float) -> Figures:
    """Of one drape x (1, N, 3)."""
    rayleigh = sum(losses.rayleigh_curvature(x, s.truth, garment.around[k]).item() for k in SCALES)
    return Figures(
        100 * losses.vertices(x, s.truth).item(),
        losses.normal_angle(x, s.truth, garment.triangles).item(),
        100 * (losses.clearance(x, s.body, s.body_normals) < 0).float().mean().item(),
        1e12 * rayleigh,
        losses.mean_curvature(x, s.truth, garment.triangles).item(),
        milliseconds,
    )


def network(
    garment: str, variant: Variant | None, curved: str, simulated: bool = False
) -> Callable[[Garment, Scenes], Tensor] | None:
    """A way to drape; none where it has not been trained."""
    if variant is None:
        return lambda _, s: s.warped
    path = checkpoint(garment, variant, curved, simulated)
    if not path.exists():
        return None
    net = GarNet(Sizes(variant=variant)).eval()
    net.load_state_dict(torch.load(path))
    return lambda g, s: draped(net, g, s)


@torch.no_grad()
def measured(way: Callable[[Garment, Scenes], Tensor], garment: Garment, scenes: Scenes) -> Iterator[Figures]:
    """Figures of every drape, one after the other."""
    for i in range(len(scenes)):
        one, started = scenes.pick(torch.tensor([i])), time.perf_counter()
        x = way(garment, one)
        yield figures(x, garment, one, 1e3 * (time.perf_counter() - started))


def row(name: str, found: list[Figures]) -> str:
    """A line of the Markdown table."""
    mean, off = (f(np.array([astuple(x) for x in found]), axis=0) for f in (np.mean, np.std))
    return (
        f"| {name} | {mean[0]:.2f} ± {off[0]:.2f} | {mean[1]:.1f} ± {off[1]:.1f} | {mean[2]:.2f} | {mean[3]:.2f} "
        f"| {mean[4]:.0f} | {mean[5]:.0f} | {len(found)} |"
    )


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--simulated", action="store_true", help="networks and drapes of `teacher.garnet_drapes`")
    p.add_argument("--split", choices=[s.name for s in SPLITS], default="test")
    a = p.parse_args()
    source = SIMULATED if a.simulated else RELAXED
    split = source.split(a.split)
    bank = split.bank()
    print(HEADER)
    for kind in PATTERNS:
        garment, scenes = load(kind, split, bank, source.folder)
        for name, variant, curved in ROWS:
            if (way := network(kind, variant, curved, a.simulated)) is not None:
                print(row(f"{kind}, {name}", list(measured(way, garment, scenes))), flush=True)


if __name__ == "__main__":
    main()
