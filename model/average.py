"""The mean of the weights of networks that share their start: `python -m average runs/a.pt runs/b.pt`.

On outfits that none of them learned from it makes fewer mistakes than each alone (Wortsman et al., Model Soups, 2022).
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch
from torch import Tensor

from train_deepsd import RUNS


def mean(networks: list[dict[str, Tensor]]) -> dict[str, Tensor]:
    """Of parameters by name. Raises KeyError where the networks differ in them."""
    return {name: torch.stack([net[name] for net in networks]).mean(0) for name in networks[0]}


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("checkpoints", type=Path, nargs="+")
    p.add_argument("--out", type=Path, default=RUNS / "deepsd.pt")
    a = p.parse_args()
    torch.save({"net": mean([torch.load(path)["net"] for path in a.checkpoints])}, a.out)
    print(a.out)


if __name__ == "__main__":
    main()
