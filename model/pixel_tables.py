"""How near pixel cloth comes to drapes that it was not trained on, and how sharp it is, beside other ways to drape."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

import energies
import garnet_losses
import train_deepsd
from fabric import Fabric
from garment.rest_mesh import hinges, rest_mesh
from nets.deepsd import Sizes
from pixel_data import Drapes, in_poses, load, necktie, shirt
from pixel_filter import COUNTS, Filter, offsets_of
from pixel_scenes import Garment, Scenes, draped, scenes
from relax import skinned
from train_pixel import RUNS, TEE, Run, answers, checkpoint, garment_of, network
from training_data import BodyBank, Sample

#: The repository's DeePSD, by `python -m shipped`.
SHIPPED = RUNS.parent / "shipped.pt"
#: Networks of section 8, trained for the same number of steps.
SECTION_8 = RUNS / "section_8"
#: What they are.
COMPARED: tuple[tuple[str, Run], ...] = (
    ("L1 and normals", Run()),
    ("L2 and normals", Run(loss="l2")),
    ("L1 alone", Run(normals=0.0)),
    ("patches", Run(patched=True)),
    ("too thin a body", Run(carrier="thin")),
    ("too thick a body", Run(carrier="thick")),
    ("lagging skinning", Run(carrier="lagging")),
    ("rigid skinning", Run(carrier="rigid")),
)
#: The necktie's network.
NECKTIE = Run(garment="tie")


def off(x: Tensor, truth: Tensor, triangles: Tensor) -> str:
    """Mean distance, cm, and mean angle of the facets, degrees, as cells."""
    error = 100 * (x - truth).norm(dim=-1).mean().item()
    return f"{error:.3f} | {garnet_losses.normal_angle(x, truth, triangles).item():.1f}"


def section_8(sample: Sample, sets: dict[str, Drapes]) -> None:
    """Errors of every network that has been trained."""
    print("| | train cm | degrees | validation cm | degrees | test cm | degrees |\n|---|---:|---:|---:|---:|---:|---:|")
    rows = [("shipped", Run(), RUNS), *((name, run, SECTION_8) for name, run in COMPARED)]
    for name, run, folder in rows:
        if checkpoint(run, folder).exists():
            garment, net = trained(sample, run, folder)
            data = {k: scenes(garment, d, run.carrier) for k, d in sets.items()}
            cells = [off(answers(net, garment, s), s.truth, garment.triangles) for s in data.values()]
            print(f"| {name} | {' | '.join(cells)} |", flush=True)


def sharpness(sample: Sample, sets: dict[str, Drapes]) -> None:
    """Ways to drape the test's poses: error, and wrinkles as the drapes have them."""
    drapes, mesh = sets["test"], rest_mesh(sample.vertices, sample.tables)
    around = torch.as_tensor(garnet_losses.neighbourhoods(sample.vertices.numpy(), 16))
    ways = {"skinning": _skinned(sample, drapes), "deepsd": deepsd(sample, drapes)}
    if checkpoint().exists():
        garment, net = trained(sample)
        data = scenes(garment, drapes, "reference")
        ways["pixel cloth before the filter"] = answers(net, garment, data)
        smooth = filter_of(net, garment, sets)
        offsets = smooth.apply(offsets_of(ways["pixel cloth before the filter"], garment, data))
        ways[f"pixel_cloth, {len(smooth.components)} components"] = draped(offsets, garment, data)
    print("| | error cm | degrees | bend of the drapes' % | curvature off (RQ, mm4) |\n|---|---:|---:|---:|---:|")
    bend = lambda x: energies.bending(x, mesh, Fabric()).mean().item()  # noqa: E731
    for name, x in ways.items():
        rayleigh = 1e12 * garnet_losses.rayleigh_curvature(x, drapes.x, around).item()
        cells = off(x, drapes.x, sample.tables[2])
        print(f"| {name} | {cells} | {100 * bend(x) / bend(drapes.x):.0f} | {rayleigh:.0f} |", flush=True)


def filter_of(net: torch.nn.Module, garment: Garment, sets: dict[str, Drapes]) -> Filter:
    """The filter of a whole garment's network."""
    data = {k: scenes(garment, sets[k], "reference") for k in ("train", "validation")}
    offsets = offsets_of(answers(net, garment, data["validation"]), garment, data["validation"])
    return Filter.of(data["train"]).chosen(offsets, garment, data["validation"])


def patches(sample: Sample, sets: dict[str, Drapes]) -> None:
    """Patches before and after the filter, and how neighbours turn across their seams and elsewhere."""
    if not checkpoint(Run(patched=True), SECTION_8).exists():
        return
    garment, net = trained(sample, Run(patched=True), SECTION_8)
    whole = Garment.of(sample)
    said = {k: answers(net, garment, scenes(garment, d, "reference")) for k, d in sets.items() if k != "train"}
    data = {k: scenes(whole, d, "reference") for k, d in sets.items()}
    offsets = {k: offsets_of(x, whole, data[k]) for k, x in said.items()}
    smooth = Filter.of(data["train"]).chosen(offsets["validation"], whole, data["validation"])
    filtered = draped(smooth.apply(offsets["test"]), whole, data["test"])
    seam, mesh = seams(sample, garment), rest_mesh(sample.vertices, sample.tables)
    print("| | error cm | degrees | turn at seams, degrees | elsewhere |\n|---|---:|---:|---:|---:|")
    test = {"drapes": data["test"].truth, "patches": said["test"], f"{len(smooth.components)} components": filtered}
    for name, x in test.items():
        turned = torch.rad2deg((energies.dihedral(x, mesh.hinges) - mesh.angle).abs())
        at, elsewhere = turned[:, seam].mean().item(), turned[:, ~seam].mean().item()
        print(f"| {name} | {off(x, data['test'].truth, garment.triangles)} | {at:.1f} | {elsewhere:.1f} |", flush=True)


def components(name: str, garment: Garment, smooth: Filter, said: dict[str, Tensor], data: dict[str, Scenes]) -> None:
    """A row: errors, cm, that a network is left with for every count of components on validation and test."""
    cells = []
    for count in COUNTS:
        left = []
        for split in ("validation", "test"):
            x = draped(smooth.apply(offsets_of(said[split], garment, data[split]), count), garment, data[split])
            left.append(f"{100 * (x - data[split].truth).norm(dim=-1).mean().item():.3f}")
        cells.append(" / ".join(left))
    print(f"| {name} | {' | '.join(cells)} |", flush=True)


def filters(sample: Sample, sets: dict[str, Drapes]) -> None:
    """Figure 16: how many components of the training's drapes to keep, for the whole and for patches."""
    whole, net = trained(sample)
    data = {k: scenes(whole, d, "reference") for k, d in sets.items()}
    smooth = Filter.of(data["train"])
    print(f"| validation / test, cm | {' | '.join(map(str, COUNTS))} |\n|---|{'---:|' * len(COUNTS)}")
    components("whole", whole, smooth, {k: answers(net, whole, data[k]) for k in ("validation", "test")}, data)
    if checkpoint(Run(patched=True), SECTION_8).exists():
        garment, net = trained(sample, Run(patched=True), SECTION_8)
        said = {k: answers(net, garment, scenes(garment, sets[k], "reference")) for k in ("validation", "test")}
        components("patches", whole, smooth, said, data)


def seams(sample: Sample, garment: Garment) -> Tensor:
    """Which hinges (H,) of the garment lie between two patches."""
    uses = torch.bincount(garment.vertex, minlength=len(sample.vertices))
    ends = torch.as_tensor(hinges(sample.tables[2].numpy()))[:, :2]
    return (uses[ends] > 1).all(1)


def speed(sample: Sample) -> None:
    """Milliseconds of the decoder on one core, PyTorch."""
    torch.set_num_threads(1)
    garment = Garment.of(sample)
    net, pose = network(garment).eval(), torch.randn(1, 90)
    with torch.no_grad():
        times = []
        for _ in range(20):
            started = time.perf_counter()
            net(pose)
            times.append(time.perf_counter() - started)
    print(f"decoder: {1e3 * float(np.median(times)):.1f} ms on one core")


def trained(sample: Sample, run: Run = TEE, folder: Path = RUNS) -> tuple[Garment, torch.nn.Module]:
    """A run's garment and network."""
    garment = garment_of(run, sample)
    net = network(garment)
    kept = torch.load(checkpoint(run, folder))
    net.load_state_dict({k: v.float() if v.is_floating_point() else v for k, v in kept.items()})
    return garment, net.eval()


@torch.no_grad()
def deepsd(sample: Sample, drapes: Drapes) -> Tensor:
    """The shipped DeePSD, before any resolve."""
    net = train_deepsd.DeePSD(Sizes())
    net.load_state_dict(torch.load(SHIPPED)["net"])
    bank = BodyBank(0, 0, 0)
    entry = replace(in_poses(bank, [{}]), transforms=drapes.transforms)
    every = torch.arange(len(drapes.x))
    return train_deepsd.drape(net.eval(), sample, sample.vertices, entry, every, bank.parents).posed


def _skinned(sample: Sample, drapes: Drapes) -> Tensor:
    return skinned(sample, sample.vertices.expand(len(drapes.x), -1, -1), drapes.transforms).posed


def tie() -> None:
    """The necktie of section 8.4: how far it is from its pixels on the body, and errors."""
    if not checkpoint(NECKTIE).exists():
        return
    sample = necktie()
    garment, net = trained(sample, NECKTIE)
    print("| necktie | drapes | from the body cm, mean | most | skinning cm | network cm | degrees |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for split in ("train", "validation", "test"):
        drapes = load(split, garment="tie")
        data = scenes(garment, drapes, "reference")
        away = 100 * data.offsets.norm(dim=-1)
        rigid = 100 * (_skinned(sample, drapes) - drapes.x).norm(dim=-1).mean().item()
        cells = [str(len(drapes.x)), f"{away.mean():.1f}", f"{away.max():.0f}", f"{rigid:.2f}"]
        print(f"| {split} | {' | '.join(cells)} | {off(answers(net, garment, data), data.truth, garment.triangles)} |")


def tables() -> None:
    sample = shirt()
    sets = {split: load(split) for split in ("train", "validation", "test")}
    print(f"\n{', '.join(f'{len(d.x)} {k}' for k, d in sets.items())} drapes\n")
    section_8(sample, sets)
    print()
    sharpness(sample, sets)
    print()
    patches(sample, sets)
    print()
    filters(sample, sets)
    print()
    tie()
    print()
    speed(sample)
