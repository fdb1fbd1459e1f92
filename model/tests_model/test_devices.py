"""What a device is fast with."""

from __future__ import annotations

import pytest
import torch

from devices import half_precision


@pytest.mark.parametrize(
    ("has", "wanted", "dtype"),
    [(True, True, torch.bfloat16), (True, False, torch.float32), (False, True, torch.float32)],
)
def test_products_are_halved_where_wanted_and_quick(
    monkeypatch: pytest.MonkeyPatch, has: bool, wanted: bool, dtype: torch.dtype
) -> None:
    monkeypatch.setattr(torch.cpu, "get_capabilities", lambda: {"avx2": True, "avx512_bf16": has})
    with half_precision(wanted=wanted):
        assert (torch.ones(4, 4) @ torch.ones(4, 4)).dtype == dtype
