"""Rows of the ablation: as many steps each, and the printed form in the place of the basis."""

from __future__ import annotations

import math
from pathlib import Path

import torch

from ablation import ROWS, PrintedDeePSD
from train_deepsd import Data, Settings, Sizes, learn, run_one
from training_data import BodyBank, OutfitPool, Sample, TargetPool


def test_the_printed_form_learns_in_the_place_of_the_basis(sample: Sample, bank: BodyBank) -> None:
    net = PrintedDeePSD(Sizes())
    draped, _, contacts = run_one(net, sample, bank, bank.entries[1], torch.arange(2))
    assert draped.offset.shape == (2, len(sample.vertices), 3)
    (draped.posed.square().sum() + draped.node_weights.square().sum() + contacts.body.sum()).backward()
    assert all(p.grad is not None and p.grad.abs().max() > 0 for p in net.concat.parameters())
    assert all(p.grad is None for p in net.coefficients.parameters())


def test_a_run_of_steps_takes_as_many_whatever_the_clock(outfits: Path, bank: BodyBank, tmp_path: Path) -> None:
    pool = OutfitPool(outfits / "train", 1)
    data = Data(pool, bank, TargetPool(tmp_path / "none", pool, bank), [], bank)
    settings = Settings(math.inf, 2, poses=1, outfits_per_step=1, copied=0.0)
    learn(PrintedDeePSD(Sizes()), data, settings, tmp_path / "run.pt")
    assert torch.load(tmp_path / "run.pt")["step"] == 2


def test_every_row_is_kept_in_a_file_of_its_own() -> None:
    assert len({row.checkpoint for row in ROWS}) == len(ROWS)
