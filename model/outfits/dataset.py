"""Write training and validation outfits: `python -m outfits.dataset --count 640 --validation 60 --out data/outfits`.

One `.npz` per outfit: vertices (N, 3) f32 in rest space, triangles (M, 3) i32, garment (N,) u8 (index into
garment_names, innermost first), garment_names, family, seed, body (JSON: phenotypes and local changes).
Files that exist are kept, so that a stopped run resumes.
"""

from __future__ import annotations

import argparse
import json
import os
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from body.anny_body import AnnyBody

from .body_fields import body_fields
from .families import ORNAMENTED, TRAIN_ORDER, VALIDATION
from .generate import generate
from .mesh import OutfitMesh
from .snug import snug

VALIDATION_SEED = 1_000_000
#: Every so many outfits one is worn tight.
SNUG_EVERY = 4
#: Share of the training outfits that are coarse, and their vertices per square metre. They relax in half the time,
#: and the network's graph has the same size (`garment.graph`).
COARSE_SHARE, COARSE = 0.6, 650


def save(outfit: OutfitMesh, path: Path) -> None:
    """Write one outfit; the file appears complete or not at all."""
    offsets = np.cumsum([0] + [len(g.vertices) for g in outfit.garments])
    scratch = path.with_suffix(f".partial{os.getpid()}.npz")
    np.savez_compressed(
        scratch,
        vertices=np.concatenate([g.vertices for g in outfit.garments]).astype(np.float32),
        triangles=np.concatenate([g.triangles + o for g, o in zip(outfit.garments, offsets, strict=False)]).astype(
            np.int32
        ),
        garment=np.repeat(np.arange(len(outfit.garments)), np.diff(offsets)).astype(np.uint8),
        garment_names=np.array([g.name for g in outfit.garments]),
        family=outfit.family,
        seed=outfit.seed,
        body=json.dumps({"phenotypes": {}, "local": {}}),
    )
    scratch.rename(path)


def _make(job: tuple[int, str, str]) -> str:
    seed, family, path = job
    if not Path(path).exists():
        save(_outfit(seed, family), Path(path))
    return path


def training_outfit(i: int) -> OutfitMesh:
    """Outfit i of the training set."""
    return _outfit(i, _turn(i))


def _outfit(seed: int, family: str) -> OutfitMesh:
    outfit = generate(seed, family, **_cloth(seed))
    if seed % SNUG_EVERY == 1:
        model = AnnyBody.load()
        outfit = snug(outfit, body_fields(model, model.shape()))
    return outfit


def _cloth(seed: int) -> dict[str, Any]:
    """How an outfit is meshed; held-out ones as the seed has it."""
    coarse = seed < VALIDATION_SEED and np.random.default_rng([seed, 11]).random() < COARSE_SHARE
    return {"vertices": COARSE, "triangulation": "isotropic"} if coarse else {}


def jobs(count: int, validation: int, out: Path) -> list[tuple[int, str, str]]:
    """(seed, family, path) of every outfit; families take turns."""
    train = [(i, _turn(i), out / "train") for i in range(count)]
    names = list(VALIDATION)
    held_out = [(VALIDATION_SEED + i, names[i % len(names)], out / "validation") for i in range(validation)]
    return [(s, f, str(d / f"{s:07d}_{f}.npz")) for s, f, d in [*held_out, *train]]


def _turn(i: int) -> str:
    """Family of training outfit i: every seventh has ornaments, the others follow the plain order."""
    ornamented = i // 7
    if i % 7 == 6:
        return list(ORNAMENTED)[ornamented % len(ORNAMENTED)]
    return TRAIN_ORDER[(i - ornamented) % len(TRAIN_ORDER)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=640)
    parser.add_argument("--validation", type=int, default=60)
    parser.add_argument("--out", type=Path, default=Path("data/outfits"))
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    for name in ("train", "validation"):
        (args.out / name).mkdir(parents=True, exist_ok=True)
    todo = [j for j in jobs(args.count, args.validation, args.out) if not Path(j[2]).exists()]
    with get_context("spawn").Pool(args.workers) as pool:
        for i, path in enumerate(pool.imap_unordered(_make, todo), 1):
            print(f"{i}/{len(todo)} {path}", flush=True)


if __name__ == "__main__":
    main()
