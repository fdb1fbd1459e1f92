"""Networks that share their start, averaged."""

import sys
from pathlib import Path

import pytest
import torch

import average
from average_pixel import averaged
from nets.deepsd import Sizes
from nets.pixel_cloth import PixelCloth
from nets.pixel_cloth import Sizes as PixelSizes
from pixel_poses import POSE
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


def test_the_mean_of_pixel_cloth_is_normalised_for_its_poses() -> None:
    torch.manual_seed(0)
    nets, poses = [PixelCloth(PixelSizes()) for _ in range(2)], torch.randn(4, POSE)
    found = averaged([net.state_dict() for net in nets], poses)
    weights = [net.layers[0].weight for net in (found, *nets)]
    torch.testing.assert_close(weights[0], (weights[1] + weights[2]) / 2)
    with torch.no_grad():
        said, learning = found(poses), found.train()(poses)
    assert (said - learning).abs().mean() < 0.02 * learning.std()
