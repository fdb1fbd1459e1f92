"""Simulated drapes that the page shows."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from safetensors import safe_open

from teacher import shown
from teacher.checks import Judged
from teacher.simulation import Resting


def test_good_drapes_are_kept_with_what_they_are_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    faults = {0: 0.0, 1: 0.5, 2: 0.0}

    def settled(start: dict, body: int, pose: int) -> tuple[Resting, Judged]:
        assert start == {"of": "gown"} and body == 0
        return Resting(np.full((4, 3), pose, np.float64), 0.0, 30), Judged(0.0, faults[pose], 1.0, 0.0)

    monkeypatch.setattr(shown, "settled", settled)
    monkeypatch.setattr(shown, "draped", lambda folder, method, outfit: {"of": outfit.stem})
    kept = shown.simulate(Path("gown.glb"), ("standing", "squat", "reach"), tmp_path)
    assert kept.poses == ("standing", "reach"), "the squat is inside the body"
    on = json.loads((tmp_path / "set.json").read_text())
    assert [pose["id"] for pose in on["poses"]] == ["standing", "squat", "reach"]
    shown.write(kept, tmp_path / "simulated" / "gown.safetensors")
    with safe_open(tmp_path / "simulated" / "gown.safetensors", "np") as file:
        cloth, about = file.get_tensor("cloth"), json.loads(file.metadata()["drapes"])
    assert cloth.shape == (2, 4, 3) and cloth.dtype == np.float32 and (cloth[1] == 2).all()
    assert [on["pose"]["id"] for on in about] == ["standing", "reach"]
    assert about[0]["body"] == {"kind": "phenotypes", "values": {}}
