"""Where tensors are, `--device cuda` on a GPU, and what a device is fast with."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import TypeVar

import torch
from torch import Tensor

T = TypeVar("T")


def on(thing: T, device: str | torch.device) -> T:
    """The same tensor, tuple, dictionary or dataclass, its tensors on a device; everything else as it is."""
    if isinstance(thing, Tensor):
        return thing.to(device)
    if isinstance(thing, tuple):
        return tuple(on(x, device) for x in thing)  # type: ignore[return-value]
    if isinstance(thing, dict):
        return {k: on(x, device) for k, x in thing.items()}  # type: ignore[return-value]
    if is_dataclass(thing) and not isinstance(thing, type):
        return replace(thing, **{f.name: on(getattr(thing, f.name), device) for f in fields(thing)})
    return thing


def half_precision(device: str = "cpu", wanted: bool = True) -> torch.autocast:
    """Products in bfloat16 where they are wanted and the device has it; other cores take three to ten times as long."""
    able = device != "cpu" or any(torch.cpu.get_capabilities().get(x) for x in ("avx512_bf16", "amx_bf16", "bf16"))
    return torch.autocast(device, torch.bfloat16, enabled=wanted and able)
