"""Networks that share their start, averaged."""

import sys
from pathlib import Path

import pytest
import torch

import average
from nets.deepsd import Sizes
from train_deepsd import DeePSD


def test_the_mean_of_two_networks_lies_between_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nets = [DeePSD(Sizes()).state_dict() for _ in range(2)]
    paths = [tmp_path / f"{k}.pt" for k in range(2)]
    for net, path in zip(nets, paths, strict=True):
        torch.save({"net": net}, path)
    out = tmp_path / "mean.pt"
    monkeypatch.setattr(sys, "argv", ["average", *map(str, paths), "--out", str(out)])
    average.main()
    found = torch.load(out)["net"]
    DeePSD(Sizes()).load_state_dict(found)
    for name, value in found.items():
        torch.testing.assert_close(value, (nets[0][name] + nets[1][name]) / 2)
