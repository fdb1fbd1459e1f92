"""How near pixel cloth comes to drapes that it was not trained on, and how sharp it is, beside other ways to drape."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

import energies
import garnet_losses
import shipped
import train_deepsd
from fabric import Fabric
from garment.rest_mesh import hinges, rest_mesh
from nets.pixel_cloth import PixelCloth
from pixel_data import SIMULATED, Drapes, in_poses, necktie, shirt
from pixel_filter import COUNTS, Filter, offsets_of
from pixel_scenes import Carrier, Garment, Scenes, draped, scenes
from relax import skinned
from train_pixel import RUNS, TEE, Run, answers, checkpoint, garment_of, network
from training_data import BodyBank, Sample

#: Networks of section 8, trained for the same number of steps.
SECTION_8 = RUNS / "section_8"
PATCHES = replace(TEE, patched=True)
#: What they are.
COMPARED: tuple[tuple[str, Run], ...] = (
    ("L1 and normals", TEE),
    ("L2 and normals", replace(TEE, loss="l2")),
    ("L1 alone", replace(TEE, normals=0.0)),
    ("patches", PATCHES),
    ("too thin a body", replace(TEE, carrier="thin")),
    ("too thick a body", replace(TEE, carrier="thick")),
    ("lagging skinning", replace(TEE, carrier="lagging")),
    ("rigid skinning", replace(TEE, carrier="rigid")),
)
#: The necktie's network.
NECKTIE = Run(garment="tie", simulated=True)


def off(x: Tensor, truth: Tensor, triangles: Tensor) -> str:
    """Mean distance, cm, and mean angle of the facets, degrees, as cells."""
    error = 100 * (x - truth).norm(dim=-1).mean().item()
    return f"{error:.3f} | {garnet_losses.normal_angle(x, truth, triangles).item():.1f}"


def errors(sets: dict[str, Drapes], rows: Iterable[tuple[str, Carrier, Garment, PixelCloth]]) -> None:
    """Errors of networks on drapes of the kind that they learned."""
    print("\n| | train cm | degrees | validation cm | degrees | test cm | degrees |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for name, carrier, garment, net in rows:
        data = {k: scenes(garment, d, carrier) for k, d in sets.items()}
        cells = [off(answers(net, garment, s), s.truth, garment.triangles) for s in data.values()]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def compared(sample: Sample) -> Iterator[tuple[str, Carrier, Garment, PixelCloth]]:
    """Section 8's networks that have been trained."""
    for name, run in COMPARED:
        if checkpoint(run, SECTION_8).exists():
            yield name, run.carrier, *trained(sample, run, SECTION_8)


def sharpness(sample: Sample, drapes: Drapes) -> None:
    """Ways to drape the test's poses: error, and wrinkles as the drapes have them."""
    mesh = rest_mesh(sample.vertices, sample.tables)
    around = torch.as_tensor(garnet_losses.neighbourhoods(sample.vertices.numpy(), 16))
    ways = {"skinning": _skinned(sample, drapes), "deepsd": deepsd(sample, drapes)}
    garment, net, smooth = served(sample)
    data = scenes(garment, drapes, "reference")
    ways["pixel cloth before the filter"] = answers(net, garment, data)
    offsets = smooth.apply(offsets_of(ways["pixel cloth before the filter"], garment, data))
    ways[f"pixel_cloth, {len(smooth.components)} components"] = draped(offsets, garment, data)
    print("\n| | error cm | degrees | bend of the drapes' % | curvature off (RQ, mm4) |\n|---|---:|---:|---:|---:|")
    bend = lambda x: energies.bending(x, mesh, Fabric()).mean().item()  # noqa: E731
    for name, x in ways.items():
        rayleigh = 1e12 * garnet_losses.rayleigh_curvature(x, drapes.x, around).item()
        cells = off(x, drapes.x, sample.tables[2])
        print(f"| {name} | {cells} | {100 * bend(x) / bend(drapes.x):.0f} | {rayleigh:.0f} |", flush=True)


def filter_of(sample: Sample, net: PixelCloth, garment: Garment, sets: dict[str, Drapes]) -> Filter:
    """The filter of a whole garment's network, from the drapes that it learned."""
    held_back = scenes(garment, sets["validation"], "reference")
    offsets = offsets_of(answers(net, garment, held_back), garment, held_back)
    return components_of(sample, garment, sets).chosen(offsets, garment, held_back)


def components_of(sample: Sample, garment: Garment, sets: dict[str, Drapes]) -> Filter:
    """Every component of the drapes that a whole garment's network learned."""
    return Filter.of(scenes(garment, sets["train"].with_mirrored(sample), "reference"))


def patches(sample: Sample, sets: dict[str, Drapes]) -> None:
    """Patches before and after the filter, and how neighbours turn across their seams and elsewhere."""
    garment, net = trained(sample, PATCHES, SECTION_8)
    whole = Garment.of(sample)
    said = {k: answers(net, garment, scenes(garment, d, "reference")) for k, d in sets.items() if k != "train"}
    data = {k: scenes(whole, sets[k], "reference") for k in said}
    offsets = {k: offsets_of(x, whole, data[k]) for k, x in said.items()}
    smooth = components_of(sample, whole, sets).chosen(offsets["validation"], whole, data["validation"])
    filtered = draped(smooth.apply(offsets["test"]), whole, data["test"])
    seam, mesh = seams(sample, garment), rest_mesh(sample.vertices, sample.tables)
    print("\n| | error cm | degrees | turn at seams, degrees | elsewhere |\n|---|---:|---:|---:|---:|")
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


def filters(name: str, sample: Sample, sets: dict[str, Drapes], garment: Garment, net: PixelCloth) -> None:
    """Figure 16: how many components of the training's drapes to keep of what a network says."""
    whole = Garment.of(sample)
    said = {k: answers(net, garment, scenes(garment, sets[k], "reference")) for k in ("validation", "test")}
    data = {k: scenes(whole, sets[k], "reference") for k in said}
    smooth = components_of(sample, whole, sets)
    print(f"\n| validation / test, cm | {' | '.join(map(str, COUNTS))} |\n|---|{'---:|' * len(COUNTS)}")
    components(name, whole, smooth, said, data)


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
    print(f"\ndecoder: {1e3 * float(np.median(times)):.1f} ms on one core")


def served(sample: Sample) -> tuple[Garment, PixelCloth, Filter]:
    """The T-shirt's images, and the network and filter that ship."""
    return Garment.of(sample), *shipped.shipped_tee(shipped.some_poses())


def trained(sample: Sample, run: Run = TEE, folder: Path = RUNS) -> tuple[Garment, PixelCloth]:
    """A run's garment and network."""
    garment = garment_of(run, sample)
    net = network(garment)
    kept = torch.load(checkpoint(run, folder))
    net.load_state_dict({k: v.float() if v.is_floating_point() else v for k, v in kept.items()})
    return garment, net.eval()


@torch.no_grad()
def deepsd(sample: Sample, drapes: Drapes) -> Tensor:
    """The shipped DeePSD, before any resolve."""
    net, bank = shipped.shipped().eval(), BodyBank(0, 0, 0)
    entry = replace(in_poses(bank, [{}]), transforms=drapes.transforms)
    every = torch.arange(len(drapes.x))
    return train_deepsd.drape(net, sample, sample.vertices, entry, every, bank.parents).posed


def _skinned(sample: Sample, drapes: Drapes) -> Tensor:
    return skinned(sample, sample.vertices.expand(len(drapes.x), -1, -1), drapes.transforms).posed


def tie() -> None:
    """The necktie of section 8.4: how far it is from its pixels on the body, and errors."""
    if not (SIMULATED.has("tie") and checkpoint(NECKTIE).exists()):
        return
    sample = necktie()
    garment, net = trained(sample, NECKTIE)
    print("\n| necktie | drapes | from the body cm, mean | most | skinning cm | network cm | degrees |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for split, drapes in SIMULATED.load("tie").items():
        data = scenes(garment, drapes, "reference")
        away = 100 * data.offsets.norm(dim=-1)
        rigid = 100 * (_skinned(sample, drapes) - drapes.x).norm(dim=-1).mean().item()
        cells = [str(len(drapes.x)), f"{away.mean():.1f}", f"{away.max():.0f}", f"{rigid:.2f}"]
        print(f"| {split} | {' | '.join(cells)} | {off(answers(net, garment, data), data.truth, garment.triangles)} |")


def tables() -> None:
    """Every table whose drapes and networks are there."""
    sample = shirt()
    if SIMULATED.has():
        sets, (garment, net, _) = SIMULATED.load(), served(sample)
        print(f"\n{', '.join(f'{len(d.x)} {k}' for k, d in sets.items())} simulated drapes")
        errors(sets, [("shipped", "reference", garment, net)])
        sharpness(sample, sets["test"])
        filters("shipped", sample, sets, garment, net)
        errors(sets, compared(sample))
        if checkpoint(PATCHES, SECTION_8).exists():
            patches(sample, sets)
            filters("patches", sample, sets, *trained(sample, PATCHES, SECTION_8))
            filters("L1 and normals", sample, sets, *trained(sample, TEE, SECTION_8))
    tie()
    speed(sample)
