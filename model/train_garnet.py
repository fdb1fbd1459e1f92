"""Train GarNet++ on one garment (Gundogdu et al. 2020, section 3.5).

    python -m train_garnet tee --variant local --minutes 10
    python -m train_garnet tee --variant local --minutes 5 --curvature rq    # goes on from the run above
    python -m train_garnet tee --simulated --minutes 10 --resume runs/garnet/shipped_tee.pt

The first form lowers equation 3. The second fine-tunes with curvature terms, by Rayleigh quotients (equation 16) or by
mean curvature normals (equation 15). The third goes on from any weights with simulated drapes.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

import garnet_losses as losses
import optimisers
from devices import on
from garnet_data import RELAXED, SIMULATED
from garnet_scenes import SCALES, Garment, Scenes, load
from nets.garnet import GarNet, Sizes, Variant
from outfits.garnet_garments import PATTERNS

RUNS = Path(__file__).parent / "runs" / "garnet"
#: Weights of equation 3 (section 3.5).
NORMALS, PENETRATION, BENDING = 0.3, 1.0, 0.5
#: What is left of equation 3 in fine-tuning (section 3.5).
KEPT = 0.1


@dataclass(frozen=True)
class Settings:
    """What a run is made of."""

    minutes: float
    batch: int = 2
    rate: float = 4e-3
    steps: int = 10**9  # stop after this many, for smoke runs
    curvature: str = ""  # fine-tuning by "rq" or "mc"
    seed: int = 0


def draped(net: GarNet, garment: Garment, s: Scenes) -> Tensor:
    """Equation 1: where skinning puts the cloth, and the network's translations, read at the vertices. (D, N, 3)."""
    translations = net(s.nodes, s.turn, s.body, s.near(garment))
    return s.warped + (garment.support_weight[..., None] * translations[:, garment.support]).sum(2)


def physical(x: Tensor, garment: Garment, s: Scenes) -> dict[str, Tensor]:
    """Terms of equation 3, weighted."""
    inside = losses.interpenetration(x, s.truth, s.body, s.body_normals, garment.edge)
    return {
        "vertices": losses.vertices(x, s.truth),
        "penetration": PENETRATION * inside,
        "normals": NORMALS * losses.normals(x, s.truth, garment.triangles),
        "bending": BENDING * losses.bending(x, s.truth, garment.two_apart),
    }


def curvature(x: Tensor, garment: Garment, s: Scenes, kind: str) -> dict[str, Tensor]:
    """Terms that equations 15 and 16 add, not weighted."""
    if kind == "mc":
        return {"mc": losses.mean_curvature(x, s.truth, garment.triangles)}
    return {f"rq{k}": losses.rayleigh_curvature(x, s.truth, garment.around[k]) for k in SCALES if kind == "rq"}


def balanced(net: GarNet, garment: Garment, scenes: Scenes, kind: str) -> dict[str, float]:
    """Weights that make every curvature term as large as what is left of equation 3, as section 3.5 chose them."""
    with torch.no_grad():
        rows = torch.linspace(0, len(scenes) - 1, min(16, len(scenes))).long()
        some = scenes.pick(rows.to(scenes.warped.device))
        x = draped(net, garment, some)
        whole = KEPT * sum(v.item() for v in physical(x, garment, some).values())
        return {name: whole / max(v.item(), 1e-20) for name, v in curvature(x, garment, some, kind).items()}


def learn(net: GarNet, garment: Garment, scenes: Scenes, s: Settings) -> None:
    """The training loop: Muon and Adam, cosine rate, a log line every hundred steps."""
    rng, started = np.random.default_rng(s.seed), time.time()
    tools, count, history = optimisers.muon_and_adam(net, s.rate, ()), 0, []
    weights = balanced(net, garment, scenes, s.curvature) if s.curvature else {}
    while (progress := (time.time() - started) / (60 * s.minutes)) < 1 and count < s.steps:
        optimisers.set_rate(tools, s.rate * (0.02 + 0.98 * 0.5 * (1 + np.cos(np.pi * progress))))
        rows = torch.as_tensor(rng.integers(len(scenes), size=s.batch))
        batch = scenes.pick(rows.to(scenes.warped.device))
        batch = batch.mirrored() if rng.random() < 0.5 else batch
        x = draped(net, garment, batch)
        terms = {k: (KEPT if s.curvature else 1.0) * v for k, v in physical(x, garment, batch).items()}
        terms |= {k: weights[k] * v for k, v in curvature(x, garment, batch, s.curvature).items()}
        torch.stack(list(terms.values())).sum().backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimisers.step(tools)
        count += 1
        history.append(torch.stack(list(terms.values())).detach())
        if count % 100 == 0:
            mean = dict(zip(terms, torch.stack(history).mean(0).tolist(), strict=True))
            rounded = {k: round(v, 6) for k, v in mean.items()}
            print(json.dumps({"step": count, "progress": round(progress, 3), **rounded}), flush=True)
            history.clear()


def checkpoint(garment: str, variant: Variant, curved: str = "", simulated: bool = False) -> Path:
    """Where a run's weights lie."""
    return RUNS / f"{'_'.join(filter(None, (garment, variant, curved, 'simulated' if simulated else '')))}.pt"


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("garment", choices=list(PATTERNS))
    p.add_argument("--variant", choices=["naive", "global", "local"], default="local")
    p.add_argument("--curvature", choices=["", "rq", "mc"], default="")
    p.add_argument("--minutes", type=float, default=10)
    p.add_argument("--resume", type=Path, metavar="FILE", help="weights to go on from")
    p.add_argument("--rate", type=float, help="highest rate; 4e-3, or 1e-3 where a run goes on from another")
    p.add_argument("--simulated", action="store_true", help="learn drapes of `teacher.garnet_drapes`")
    p.add_argument("--device", default="cpu")
    p.add_argument("--batch", type=int, default=2, help="drapes a step: 2 for a core, 16 for a GPU")
    a = p.parse_args()
    torch.manual_seed(0)
    source = SIMULATED if a.simulated else RELAXED
    train = source.split("train")
    garment, scenes = on(load(a.garment, train, train.bank(), source.folder), a.device)
    print(f"{len(scenes)} drapes of {scenes.warped.shape[1]} vertices", flush=True)
    net = GarNet(Sizes(variant=a.variant)).to(a.device)
    if start := a.resume or (checkpoint(a.garment, a.variant, "", a.simulated) if a.curvature else None):
        net.load_state_dict(torch.load(start, map_location=a.device))
    rate = a.rate or (1e-3 if start else 4e-3)
    learn(net, garment, scenes, Settings(a.minutes, a.batch, rate, curvature=a.curvature))
    RUNS.mkdir(parents=True, exist_ok=True)
    torch.save(net.cpu().state_dict(), checkpoint(a.garment, a.variant, a.curvature, a.simulated))


if __name__ == "__main__":
    main()
