"""Train pixel cloth on an outfit of one garment: `python -m hero FILE_OR_ID --server http://127.0.0.1:8080`.

The outfit's UVs are its sewing pattern, an image for each island. It is simulated in sampled poses of the reference
body, a decoder learns to draw these drapes (Jin et al. 2020), and the server gets what it learned: from then on the
outfit has the method `pixel_cloth`. Drapes are kept under `data/heroes`; a run that was stopped goes on with them.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.numpy import load, save

import export_pixel
from bake import metadata, tell
from body.pose_sampling import sample_poses
from garment.embedding import REACH, hips
from garment.mirror import asymmetry, opposite
from garment.uv_panels import uv_panels
from outfits.mesh import GarmentMesh
from pixel_data import Drapes, good, in_poses, keep, worn
from pixel_filter import Filter, offsets_of
from pixel_poses import JOINTS, WHOLE_BODY, upper_body_poses
from pixel_scenes import Garment, Scenes, draped, scenes
from relax import skinned
from rig import Rig, Scene, coefficients, drape, read
from service import Service
from train_pixel import Settings, answers, learn, network
from training_data import DATA, BodyBank, Sample, carry

ARTIFACTS = Path(__file__).parent / "artifacts"
#: Poses to simulate the cloth in at most, of a file, and the seed of the first file's.
COUNT, CHUNK, SEED = 2000, 4, 9_500
#: Share of the time that drapes are made in.
MAKING = 0.5
#: m by which a garment may differ from its mirror image (99 %).
SYMMETRIC = 5e-3


@dataclass(frozen=True)
class Task:
    """An outfit as the server has it."""

    id: str
    positions: NDArray[np.float32]  # (N, 3) as uploaded
    sample: Sample
    rig: Rig
    garment: Garment

    @property
    def folder(self) -> Path:
        return DATA / "heroes" / self.id / "simulated"

    def files(self) -> list[Path]:
        """Where each chunk of drapes lies."""
        return [self.folder / f"{k:03d}.npz" for k in range(COUNT // CHUNK)]


def task(name: str, tensors: dict[str, NDArray]) -> Task:
    """What a `static.safetensors` holds. Raises ValueError where pixel cloth cannot learn it."""
    if tensors["garment"].max(initial=0) > 0:
        raise ValueError("The outfit has several garments; pixel cloth learns one: upload each on its own.")
    sample, rig = read(tensors)
    drawn, triangles = (tensors[f"drawn_{k}"].astype(np.int64) for k in ("vertices", "triangles"))
    vertices = sample.vertices.double().numpy()
    panels = uv_panels(vertices, drawn, triangles.reshape(-1, 3), tensors["uvs"].reshape(-1, 2))
    joints = WHOLE_BODY if vertices[:, 1].min() < hips() - REACH else JOINTS
    garment = Garment.laid(sample, panels, joints=joints)
    return Task(name, tensors["positions"].reshape(-1, 3), sample, rig, garment)


def make(garment: GarmentMesh, path: Path, number: int, is_upper: bool) -> None:
    """Simulates one chunk, in poses of the upper body or of everything."""
    # Only simulation needs its tools.
    from teacher.garment import simulated

    poses = (upper_body_poses if is_upper else sample_poses)(CHUNK, SEED + number)
    keep(path, *simulated(garment, poses, path.parent / "scratch" / path.stem))


def simulate(it: Task, seconds: float) -> Drapes:
    """The outfit at rest in as many poses as time allows, on two cores; chunks that are there are kept."""
    started, paths, is_upper = time.time(), it.files(), it.garment.joints == JOINTS
    missing = iter([k for k, path in enumerate(paths) if not path.exists()])
    tell(f"simulating; the first {CHUNK} poses take some minutes", started)
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        submit = lambda k: pool.submit(make, worn(it.sample), paths[k], k, is_upper)  # noqa: E731
        running = {submit(k) for k, _ in zip(missing, range(2), strict=False)}
        while running:
            done = next(as_completed(running))
            running.remove(done)
            done.result()
            there = CHUNK * sum(path.exists() for path in paths)
            left = max(0.0, seconds - (time.time() - started))
            tell(f"simulated in {there} of {CHUNK * len(paths)} poses, {left / 60:.0f} min left for it", started)
            if left > 0 and (k := next(missing, None)) is not None:
                running.add(submit(k))
    return good(paths, CHUNK)


def taught(it: Task, drapes: dict[str, Drapes], settings: Settings) -> tuple[torch.nn.Module, Filter]:
    """A network that has learned the drapes, and its filter."""
    v, t = it.sample.vertices.double().numpy(), it.sample.tables[2].numpy()
    is_even = np.percentile(asymmetry(v, opposite(v, t)), 99) < SYMMETRIC
    learned = drapes["train"].with_mirrored(it.sample) if is_even else drapes["train"]
    train, validation = (scenes(it.garment, d, "reference") for d in (learned, drapes["validation"]))
    net = network(it.garment)
    learn(net, it.garment, train, settings)
    offsets = offsets_of(answers(net, it.garment, validation), it.garment, validation)
    return net, Filter.of(train).chosen(offsets, it.garment, validation)


@torch.no_grad()
def errors(it: Task, net: torch.nn.Module, smooth: Filter, drapes: Drapes) -> dict[str, float]:
    """Mean distances to drapes that were not learned from, cm."""
    bank = BodyBank(0, 0, 0)
    entry = replace(in_poses(bank, [{}]), transforms=drapes.transforms)
    data: Scenes = scenes(it.garment, drapes, "reference")
    offsets = smooth.apply(offsets_of(answers(net, it.garment, data), it.garment, data))
    rest, mesh = carry(it.sample, bank, entry)
    every, shared = torch.arange(len(drapes.x)), coefficients(entry, bank.parents, ARTIFACTS)
    scene, rig = Scene(entry, rest, mesh, shared, drapes.x), it.rig
    ways = {
        "skinning_cm": skinned(it.sample, rest.expand_as(drapes.x), drapes.transforms).posed,
        "deepsd_cm": drape(rig, scene, every, rig.basis, rig.weight).posed,
        "pixel_cloth_cm": draped(offsets, it.garment, data),
    }
    return {name: round(100 * (x - drapes.x).norm(dim=-1).mean().item(), 3) for name, x in ways.items()}


def hero(it: Task, made: Drapes, started: float, settings: Settings) -> bytes:
    """The file of a network for the outfit, as the server takes it (`toile-server/src/heroes.rs`)."""
    drapes = {split: made.of(split) for split in ("train", "validation", "test")}
    if min(len(d.x) for d in drapes.values()) == 0:
        raise SystemExit(f"Only {len(made.x)} drapes are good: give it more --minutes.")
    tell(f"{len(made.x)} good drapes; training", started)
    net, smooth = taught(it, drapes, settings)
    report = {"minutes": round((time.time() - started) / 60, 1), "drapes": len(drapes["train"].x)}
    report |= errors(it, net, smooth, drapes["test"])
    data = export_pixel.tables(it.sample, it.garment, net, smooth) | {"rest": np.ascontiguousarray(it.positions)}
    return save(data, {"report": json.dumps(report)})


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("outfit", help="a file to upload, or an outfit's id at the server")
    p.add_argument("--server", default="http://127.0.0.1:8080")
    p.add_argument("--minutes", type=float, default=90, help="for everything")
    a = p.parse_args()
    service = Service.of(a.server, a.outfit)
    tensors = load(service.ask("GET", "static.safetensors"))
    try:
        it = task(service.outfit, tensors)
    except ValueError as error:
        raise SystemExit(str(error)) from error
    print(f"{len(it.positions)} vertices in {it.garment.images} panels, {len(it.garment.joints)} joints", flush=True)
    started = time.time()
    made = simulate(it, 60 * MAKING * a.minutes)
    left = max(1.0, a.minutes - (time.time() - started) / 60)
    file = hero(it, made, started, Settings(left))
    report = json.loads(metadata(file)["report"])
    print(json.dumps(report))
    if report["pixel_cloth_cm"] >= report["deepsd_cm"]:
        raise SystemExit("Not nearer than deepsd, so the server keeps that. Run it again: it goes on with the drapes.")
    service.ask("PUT", "hero", file)


if __name__ == "__main__":
    # Of the processes that simulate, which have a core each.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
