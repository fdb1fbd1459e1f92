"""What each loss does: `python -m ablation --steps 1200`, as the paper's Tables 1 and 3.

Trains a network from nothing for each row, as many steps each, on the outfits and drapes of `teacher.training_set`, and
compares it with those of `teacher.drapes` (`teacher.compare`). L_D is the distance to simulated drapes, L_E stretch,
L_B bend, L_C contact with body and layers. Networks that are there already are only compared.
"""

from __future__ import annotations

import argparse
import math
import os
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import torch
from torch import Tensor

from devices import half_precision
from export import ARTIFACTS, export_all
from nets.deepsd import ConcatenatedPsi, Sizes
from teacher.compare import Figures, compare, table
from teacher.drapes import TEACHER, folders_in
from teacher.training_set import SIMULATED
from train_deepsd import RUNS, Data, DeePSD, Settings, learn
from training_data import DATA, BodyBank, OutfitPool, Sample, TargetPool

#: Of the blend weights, in every row.
ALWAYS = frozenset({"prior", "smooth"})


class PrintedDeePSD(DeePSD):
    """Psi as printed (section 4.2.2) in the place of basis and coefficients."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__(sizes)
        self.concat = ConcatenatedPsi(sizes)

    def offsets(self, sample: Sample, nodes: tuple[Tensor, Tensor], pose: Tensor, shape: Tensor) -> Tensor:
        descriptors = sample.at_vertices(nodes[1])
        with half_precision(wanted=torch.is_grad_enabled()):
            of_poses = [self.concat(descriptors, one[None], shape[None]) for one in pose]
        return torch.stack(of_poses).float()


@dataclass(frozen=True)
class Row:
    """A network of the table."""

    name: str
    terms: frozenset[str] | None = None
    aimed: float = 1.0
    then: float | None = None  # share of aimed draws in the second half, where it changes
    printed: bool = False

    @property
    def checkpoint(self) -> Path:
        return RUNS / "ablation" / f"{self.name.replace(' ', '_').replace(',', '')}.pt"

    @property
    def method(self) -> str:
        """By which the service drapes with it."""
        return "deepsd-concat" if self.printed else "deepsd"

    def network(self) -> DeePSD:
        return PrintedDeePSD(Sizes()) if self.printed else DeePSD(Sizes())


def with_terms(name: str, *terms: str) -> Row:
    return Row(name, ALWAYS | {"target", *terms})


ROWS = (
    with_terms("L_D"),
    with_terms("L_D + L_E", "stretch"),
    with_terms("L_D + L_B", "bend"),
    with_terms("L_D + L_C", "contact", "layer"),
    Row("all"),
    Row("unsupervised", aimed=0.0),
    Row("supervised, then unsupervised", aimed=1.0, then=0.0),
    Row("all, printed form", printed=True),
)


def train(row: Row, data: Data, steps: int) -> None:
    """Trains one row from nothing, in two halves where it says so."""
    torch.manual_seed(0)
    net = row.network()
    row.checkpoint.parent.mkdir(parents=True, exist_ok=True)
    part = row.checkpoint.with_suffix(".part.pt")
    settings = Settings(math.inf, steps, copied=0.0, terms=row.terms, aimed=row.aimed)
    if row.then is None:
        learn(net, data, settings, part)
    else:
        learn(net, data, replace(settings, steps=steps // 2), part)
        learn(net, data, replace(settings, steps=steps // 2, aimed=row.then, start=0.5), part)
    part.rename(row.checkpoint)


def figures(row: Row, drapes: Path, artifacts: Path) -> dict[str, list[Figures]]:
    """Of a trained row on every good drape, by outfit."""
    net = row.network()
    net.load_state_dict(torch.load(row.checkpoint)["net"])
    printed = net.concat if isinstance(net, PrintedDeePSD) else ConcatenatedPsi(Sizes())
    export_all(net, printed, Sizes(), artifacts)
    os.environ["TOILE_ARTIFACTS"] = str(artifacts.resolve())
    found: dict[str, list[Figures]] = {}
    for folder in folders_in(drapes):
        for way, _, of_drape in compare(folder, (row.method,)):
            if way == f"{row.method}, before the resolve":
                found.setdefault(folder.name, []).append(of_drape)
    return found


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--steps", type=int, default=1200)
    p.add_argument("--rows", nargs="*", default=[row.name for row in ROWS])
    p.add_argument("--simulated", type=Path, default=SIMULATED, help="drapes to learn from")
    p.add_argument("--drapes", type=Path, default=TEACHER, help="drapes to judge by")
    p.add_argument("--artifacts", type=Path, default=DATA / "ablation_artifacts", help="scratch folder")
    a = p.parse_args()
    rows = [row for row in ROWS if row.name in a.rows]
    if not all(row.checkpoint.exists() for row in rows):
        outfits, bank = OutfitPool(a.simulated / "outfits"), BodyBank.for_training()
        data = Data(outfits, bank, TargetPool(a.simulated, outfits, bank), [], BodyBank(1, 1, 2))
        for row in rows:
            if not row.checkpoint.exists():
                train(row, data, a.steps)
    shutil.copytree(ARTIFACTS, a.artifacts, dirs_exist_ok=True)
    for line in table({row.name: figures(row, a.drapes, a.artifacts) for row in rows}):
        print(line)


if __name__ == "__main__":
    main()
