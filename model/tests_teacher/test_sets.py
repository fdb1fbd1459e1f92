"""The judge's sets."""

from __future__ import annotations

import json
from pathlib import Path

from teacher.drapes import Size, prepare


def test_a_larger_set_begins_with_the_smaller_one(tmp_path: Path) -> None:
    small, large = (
        [json.loads((folder / "set.json").read_text()) for folder in prepare(size, tmp_path / str(size.outfits))]
        for size in (Size(1, 1, 1, 300), Size(2, 2, 2, 300))
    )
    assert len(large) == 2 and large[0]["poses"] != large[1]["poses"]
    assert large[0]["bodies"][:1] == small[0]["bodies"]
    assert large[0]["poses"][:1] == small[0]["poses"]
