"""Share of GarNet's vertices and normals within an error, test bodies: `python -m figures.garnet_precision`.

Gundogdu et al. 2020, Figure 9, for every trained network and the warped garment alone, into
docs/pictures/garnet-precision.png.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

import garnet_losses as losses
from evaluate_garnet import ROWS, network
from garnet_data import RELAXED, SPLITS
from garnet_scenes import Garment, Scenes, load
from outfits.garnet_garments import PATTERNS

mpl.use("Agg")
from matplotlib import pyplot as plt

OUT = Path(__file__).parents[2] / "docs" / "pictures" / "garnet-precision.png"
#: Thresholds of a vertex, cm, and of a normal, degrees.
FARTHEST, WIDEST = np.linspace(0, 6, 61), np.linspace(0, 40, 41)

Way = Callable[[Garment, Scenes], Tensor]


@torch.no_grad()
def errors(way: Way, garment: Garment, scenes: Scenes) -> tuple[NDArray, NDArray]:
    """Of all vertices, cm, and of all facet normals, degrees."""
    far, wide = [], []
    for i in range(len(scenes)):
        one = scenes.pick(torch.tensor([i]))
        x = way(garment, one)
        far.append(100 * (x - one.truth).norm(dim=-1).flatten())
        a, b = (losses.face_normals(y, garment.triangles) for y in (x, one.truth))
        wide.append(torch.rad2deg((a * b).sum(-1).clamp(-1, 1).arccos()).flatten())
    return torch.cat(far).numpy(), torch.cat(wide).numpy()


def below(values: NDArray, thresholds: NDArray) -> NDArray:
    """Percent of the values below each threshold."""
    return 100 * np.searchsorted(np.sort(values), thresholds) / len(values)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--drapes", type=Path, default=RELAXED.folder)
    p.add_argument("--out", type=Path, default=OUT)
    a = p.parse_args()
    split = SPLITS[2]
    bank = split.bank()
    figure, axes = plt.subplots(2, len(PATTERNS), figsize=(3 * len(PATTERNS), 5), layout="constrained", sharey=True)
    for column, kind in zip(axes.T, PATTERNS, strict=True):
        garment, scenes = load(kind, split, bank, a.drapes)
        for name, variant, curved in ROWS:
            if (way := network(kind, variant, curved)) is None:
                continue
            for axis, values, thresholds in zip(column, errors(way, garment, scenes), (FARTHEST, WIDEST), strict=True):
                axis.plot(thresholds, below(values, thresholds), label=name)
        column[0].set(title=kind, xlabel="vertices within, cm", ylim=(0, 100))
        column[1].set(xlabel="normals within, degrees")
    axes[0, 0].legend(fontsize=8)
    axes[0, 0].set_ylabel("%")
    axes[1, 0].set_ylabel("%")
    figure.savefig(a.out, dpi=90)


if __name__ == "__main__":
    main()
