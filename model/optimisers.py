"""What trains the networks: Muon for the matrices inside them, Adam for the rest."""

from __future__ import annotations

import torch
from torch import nn


def muon_and_adam(net: nn.Module, rate: float, outer: tuple[str, ...]) -> list[torch.optim.Optimizer]:
    """Optimisers of a network. `outer` names its first and last matrices, which Adam trains with biases and norms.

    The first matrices see features of many scales and the last are read out; between them Muon's
    orthogonal steps learn about twice as much a step as Adam's (model/LOG.md).
    """
    inner = [p for name, p in net.named_parameters() if p.ndim == 2 and not name.endswith(outer)]
    held = {id(p) for p in inner}
    rest = [p for p in net.parameters() if id(p) not in held]
    muon = torch.optim.Muon(inner, lr=rate, weight_decay=0.0, adjust_lr_fn="match_rms_adamw")
    return [torch.optim.Adam(rest, lr=rate, betas=(0.9, 0.98)), muon]


def set_rate(optimisers: list[torch.optim.Optimizer], rate: float) -> None:
    for group in (g for o in optimisers for g in o.param_groups):
        group["lr"] = rate


def step(optimisers: list[torch.optim.Optimizer]) -> None:
    """One step of each; gradients are cleared."""
    for optimiser in optimisers:
        optimiser.step()
        optimiser.zero_grad()
