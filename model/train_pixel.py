"""Train pixel-based cloth on one garment (Jin et al. 2020, section 7).

python -m train_pixel --minutes 240
python -m train_pixel --minutes 6 --device cuda --batch 64
python -m train_pixel --minutes 60 --loss l2 --normals 0       # section 8.1
python -m train_pixel --minutes 60 --carrier thin              # section 8.2
python -m train_pixel --minutes 60 --patches                   # section 8.3
python -m train_pixel --minutes 30 --garment tie               # section 8.4
python -m train_pixel --simulated --minutes 20 --rate 5e-4 --resume runs/pixel/tee_l1.pt
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import torch
from torch import Tensor, nn

import garnet_losses
from devices import half_precision, on
from garment import nearest
from garment.cloth_image import Panel
from garment.flat import flattened
from nets.pixel_cloth import OFFSET_UNIT, PixelCloth, Sizes, at_sites, of_mask
from pixel_data import GARMENTS, PIXEL, RELAXED, SIMULATED, Source
from pixel_scenes import PATCH_SIZE, Carrier, Garment, Scenes, draped, pixels, scenes
from training_data import Sample

RUNS = Path(__file__).parent / "runs" / "pixel"
Norm = Literal["l1", "l2"]
#: Steps in which the rate rises: at full rate from the first, offsets along u may stay unlearned for hundreds.
RISE = 100
#: Channels of a patch's network: a step of twelve costs what a step of the whole does.
PATCHED = (128, 64, 48, 24)


@dataclass(frozen=True)
class Settings:
    """What a run is made of."""

    minutes: float
    batch: int = 8
    rate: float = 2e-3
    steps: int = 10**9  # stop after this many
    loss: Norm = "l1"
    normals: float = 0.01  # weight of the normals (section 7), m
    seed: int = 0


def losses(images: Tensor, garment: Garment, s: Scenes, settings: Settings) -> dict[str, Tensor]:
    """The base loss on the pixels of the mask (equation 1) and that of the normals (equation 2), metres."""
    off = of_mask(images, garment.pixel) - pixels(garment, s)
    terms = {"pixels": off.abs().mean() if settings.loss == "l1" else off.square().mean() / OFFSET_UNIT}
    if settings.normals:
        x = draped(at_sites(images, garment.pixel_of_site, garment.pixel_weight), garment, s)
        normals = [nearest.vertex_normals(v, garment.triangles) for v in (x, s.truth)]
        terms["normals"] = settings.normals * (1 - (normals[0] * normals[1]).sum(-1)).mean()
    return terms


def learn(net: PixelCloth, garment: Garment, data: Scenes, s: Settings) -> None:
    """The training loop: Adam, a rate that rises and then falls as a cosine, a log line every hundred steps."""
    rng, started, count, history = np.random.default_rng(s.seed), time.time(), 0, []
    net = net.to(memory_format=torch.channels_last)
    adam = torch.optim.Adam(net.parameters(), s.rate, betas=(0.9, 0.98))
    while (progress := max((time.time() - started) / (60 * s.minutes), count / s.steps)) < 1:
        rise = min(1.0, (count + 1) / RISE)
        for group in adam.param_groups:
            group["lr"] = s.rate * rise * (0.01 + 0.99 * 0.5 * (1 + np.cos(np.pi * progress)))
        batch = data.pick(torch.as_tensor(rng.integers(len(data), size=s.batch)).to(data.pose.device))
        with half_precision(batch.pose.device.type):
            images = net(batch.pose)
        terms = losses(images.float(), garment, batch, s)
        torch.stack(list(terms.values())).sum().backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        adam.step()
        adam.zero_grad()
        count += 1
        history.append(torch.stack(list(terms.values())).detach())
        if count % 100 == 0:
            mean = dict(zip(terms, torch.stack(history).mean(0).tolist(), strict=True))
            rounded = {k: round(v, 6) for k, v in mean.items()}
            print(json.dumps({"step": count, "progress": round(progress, 3), **rounded}), flush=True)
            history.clear()


@torch.no_grad()
def answers(net: PixelCloth, garment: Garment, data: Scenes) -> Tensor:
    """Cloth that a network says, (D, N, 3) world."""
    net.eval()
    parts = [
        draped(at_sites(net(s.pose), garment.pixel_of_site, garment.pixel_weight), garment, s)
        for s in (data.pick(rows) for rows in torch.arange(len(data), device=data.pose.device).split(32))
    ]
    return torch.cat(parts)


def measures(x: Tensor, garment: Garment, data: Scenes) -> dict[str, float]:
    """Mean distance to the drapes, and mean angle to their normals."""
    return {
        "error_cm": round(100 * (x - data.truth).norm(dim=-1).mean().item(), 4),
        "angle": round(garnet_losses.normal_angle(x, data.truth, garment.triangles).item(), 3),
    }


@dataclass(frozen=True)
class Run:
    """Which network a run trains."""

    loss: Norm = "l1"
    normals: float = Settings.normals
    carrier: Carrier = "reference"
    patched: bool = False
    garment: str = "tee"
    simulated: bool = False  # drapes to learn from: by physics instead of relaxed

    @property
    def source(self) -> Source:
        return SIMULATED if self.simulated else RELAXED


#: The network that ships.
TEE = Run(simulated=True)


def checkpoint(run: Run = TEE, folder: Path = RUNS) -> Path:
    """Where a run's weights lie."""
    parts = (
        run.garment,
        "simulated" if run.simulated else "",
        "patches" if run.patched else "",
        "" if run.carrier == "reference" else run.carrier,
        run.loss if run.normals else f"{run.loss}_only",
    )
    return folder / f"{'_'.join(filter(None, parts))}.pt"


def garment_of(run: Run, sample: Sample) -> Garment:
    """The garment of a run, in its images."""
    if run.garment == "tee":
        return Garment.of(sample, run.patched)
    v, t = sample.vertices.double().numpy(), sample.tables[2].numpy()
    return Garment.laid(sample, [Panel(np.arange(len(v)), t, flattened(v, t))])


def network(garment: Garment) -> PixelCloth:
    """Untrained, for a whole garment or for its patches."""
    pose = 9 * len(garment.joints)
    if garment.side == PATCH_SIZE:
        return PixelCloth(Sizes(garment.images, PATCHED, garment.images, pose))
    return PixelCloth(Sizes(garment.images, pose=pose))


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--garment", choices=list(GARMENTS), default="tee")
    p.add_argument("--minutes", type=float, default=240)
    p.add_argument("--steps", type=int, default=Settings.steps, help="stop after this many, if time is left")
    p.add_argument("--loss", choices=get_args(Norm), default="l1")
    p.add_argument("--normals", type=float, default=Settings.normals)
    p.add_argument("--carrier", choices=get_args(Carrier), default="reference")
    p.add_argument("--patches", action="store_true")
    p.add_argument("--simulated", action="store_true", help="learn drapes of `teacher.pixel_drapes`")
    p.add_argument("--resume", type=Path, metavar="FILE", help="weights to go on from")
    p.add_argument("--seed", type=int, default=Settings.seed, help="of the untrained weights and the drapes' order")
    p.add_argument("--rate", type=float, default=Settings.rate, help="of learning, at the start")
    p.add_argument("--out", type=Path, default=RUNS, help="folder of the weights")
    p.add_argument("--device", default="cpu")
    p.add_argument("--batch", type=int, default=Settings.batch, help="drapes a step: 8 for two cores, 64 for a GPU")
    a = p.parse_args()
    torch.manual_seed(a.seed)
    run = Run(a.loss, a.normals, a.carrier, a.patches, a.garment, a.simulated)
    sample = GARMENTS[a.garment](PIXEL)
    garment = on(garment_of(run, sample), a.device)
    drapes = run.source.load(a.garment)
    learned = drapes["train"].with_mirrored(sample)
    sets = {k: scenes(garment, d, a.carrier, a.device) for k, d in (drapes | {"train": learned}).items() if k != "test"}
    print(f"{len(sets['train'])} drapes, {len(sets['validation'])} to validate", flush=True)
    net = network(garment).to(a.device)
    if a.resume:
        net.load_state_dict(torch.load(a.resume, map_location=a.device))
    settings = Settings(a.minutes, a.batch, a.rate, a.steps, a.loss, a.normals, a.seed)
    learn(net, garment, sets["train"], settings)
    for name, data in sets.items():
        print(json.dumps({name: measures(answers(net, garment, data), garment, data)}), flush=True)
    a.out.mkdir(parents=True, exist_ok=True)
    torch.save(net.cpu().state_dict(), checkpoint(run, a.out))


if __name__ == "__main__":
    main()
