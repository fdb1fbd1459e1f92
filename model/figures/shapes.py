"""Figures over body shapes: `python -m figures.shapes`.

shapes.png: from short to tall and slim to heavy, what is inside the body before and after the resolve, how edges
change and stretch, of outfits of kinds never trained on (`toile evaluate`); and the error to simulated drapes on the
bodies of `teacher.drapes`, by their weight.
"""

from __future__ import annotations

import argparse
import json
import subprocess
from pathlib import Path

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

from teacher.compare import compare
from teacher.drapes import TEACHER, TOILE, folders_in

mpl.use("Agg")
from matplotlib import pyplot as plt

OUT = Path(__file__).parents[2] / "docs" / "pictures"
EVALUATION = Path(__file__).parents[1] / "artifacts" / "evaluation.json"
STEPS = (0.05, 0.275, 0.5, 0.725, 0.95)
POSES = 10
NAMES = ("inside before, %", "inside after, %", "edges change by, %", "stretch p99.9")


def row(values: dict[str, float], outfits: list[Path], scratch: Path) -> list[float]:
    """Means of `toile evaluate` on one body, as NAMES."""
    poses = json.loads(EVALUATION.read_text())["poses"][:POSES]
    scratch.write_text(json.dumps({"bodies": [{"kind": "phenotypes", "values": values}], "poses": poses}))
    printed = subprocess.run(
        [TOILE, "evaluate", "--set", scratch, *outfits], check=True, capture_output=True, text=True
    ).stdout
    cells = [c.split(" / ") for c in printed.splitlines()[-1].split("|")[2:8]]
    before, after, _, percent, stretch, _ = cells
    return [float(before[0]), float(after[0]), float(percent[1]), float(stretch[1])]


def heights_and_weights(outfits: list[Path], scratch: Path) -> NDArray:
    """(4, heights, weights) of the service's figures."""
    found = []
    for height in STEPS:
        found.append([row({"height": height, "weight": weight}, outfits, scratch) for weight in STEPS])
        print(f"height {height}: {found[-1]}", flush=True)
    return np.moveaxis(np.array(found), 2, 0)


def errors(drapes: Path) -> list[tuple[float, float, float]]:
    """Weight of each simulated body and the error of skinning and DeePSD on it, mm."""
    out = []
    for folder in folders_in(drapes):
        bodies = json.loads((folder / "set.json").read_text())["bodies"]
        by_body: dict[int, dict[str, list[float]]] = {}
        for way, body, figures in compare(folder):
            by_body.setdefault(body, {}).setdefault(way, []).append(figures.error)
        for body, ways in by_body.items():
            means = (float(np.mean(ways[f"{way}, before the resolve"])) for way in ("skinning", "deepsd"))
            out.append((bodies[body]["values"]["weight"], *means))
    return out


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--outfits", type=Path, default=Path("data/held_out"))
    p.add_argument("--drapes", type=Path, default=TEACHER)
    p.add_argument("--out", type=Path, default=OUT)
    a = p.parse_args()
    outfits = sorted(a.outfits.glob("0[0-4]_*.obj"))
    tables = heights_and_weights(outfits, a.outfits / "shape.json")
    figure, axes = plt.subplots(1, 5, figsize=(15, 3.2), layout="constrained")
    for axis, table, name in zip(axes, tables, NAMES, strict=False):
        axis.imshow(table, origin="lower", cmap="OrRd", vmin=0, vmax=2 * table.max())
        for (y, x), value in np.ndenumerate(table):
            axis.text(x, y, f"{value:.3g}", ha="center", va="center", fontsize=8)
        axis.set(title=name, xlabel="weight, slim to heavy", ylabel="height", xticks=[], yticks=[])
    weight, skinning, deepsd = np.array(errors(a.drapes)).T
    axes[4].scatter(weight, skinning, s=14, label="skinning", color="#b6504c")
    axes[4].scatter(weight, deepsd, s=14, label="DeePSD", color="#4f7ca8")
    axes[4].set(title="error to simulation, mm", xlabel="weight, slim to heavy", ylim=(0, None))
    axes[4].legend(fontsize=8)
    figure.savefig(a.out / "deepsd-shapes.png", dpi=90)


if __name__ == "__main__":
    main()
