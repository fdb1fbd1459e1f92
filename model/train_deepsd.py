"""Train DeePSD without data (paper section 6): physics energies on random outfits, bodies and poses.

    python -m train_deepsd --minutes 60            # checkpoints and a log under runs/
    python -m train_deepsd --resume runs/deepsd.pt
    python -m train_deepsd --resume runs/deepsd.pt --simulated data/simulated   # go on, now from simulated drapes

Each step draws outfits, each on one body shape in several poses, runs the static pass once and the dynamic pass for
every pose. The first part of a run copies relaxed cloth (`relax.py`), the rest lowers the energy of the posed cloth as
well: supervised training first, then unsupervised (section 6).
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

import cloth_energy
import energies
import optimisers
from cloth_energy import Contacts, Posed
from devices import half_precision
from energies import RestMesh
from nets.deepsd import Coefficients, Sizes, StaticPass, pose_features, skin, top_four
from posed_bodies import Bodies
from training_data import DATA, BodyBank, OutfitPool, Sample, ShapedPoses, TargetPool, carry, load_samples

#: First and last matrices of the networks; `concat` is the printed form's (`ablation`).
OUTER = (
    "inlet.weight", "omega.2.weight", "psi.2.weight", "coefficients.net.4.weight", "concat.net.0.weight",
    "concat.net.6.weight",
)  # fmt: skip
#: Outfits of kinds never trained on that a checkpoint is measured on: two of each.
VALIDATION_OUTFITS = 12
RUNS = Path(__file__).parent / "runs"


@dataclass(frozen=True)
class Schedule:
    """Weights that change over a run; progress runs from 0 to 1."""

    prior: float = 1.5  # J/m2 per unit of divergence from the body's weights, fades to a fifth by 40 % of the run
    smooth_weights: float = 2.0
    target: float = 1000.0  # N/m3, distance of cloth from where relaxation puts it, while nothing else counts
    pull: float = 4000.0  # N/m3, the same beside the energies, fades to three fifths at the end
    copied: float = 0.5  # share of the run that only copies relaxed cloth
    aimed: float = 0.75  # share of the draws after it that have relaxed cloth to aim at

    def target_at(self, progress: float) -> float:
        return self.target if progress < self.copied else self.pull * min(1.0, 1.6 - progress)

    def prior_at(self, progress: float) -> float:
        return self.prior * max(0.2, 1 - 2 * progress)


class DeePSD(nn.Module):
    """Static pass and coefficients together."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.static = StaticPass(sizes)
        self.coefficients = Coefficients(sizes)

    def offsets(self, sample: Sample, nodes: tuple[Tensor, Tensor], pose: Tensor, shape: Tensor) -> Tensor:
        """Psi of every vertex: basis and descriptors of the nodes, (P, POSE), (1, SHAPE) -> (P, N, 3), metres."""
        basis = sample.at_vertices(nodes[0])
        coefficients = self.coefficients(pose, shape.expand(len(pose), -1))
        return torch.einsum("nkr,pr->pnk", basis.reshape(len(basis), 3, -1), coefficients)


@dataclass(frozen=True)
class Draped(Posed):
    """One outfit on one shape in several poses, as the network has it."""

    rest: Tensor  # (N, 3)
    offset: Tensor  # (P, N, 3) rest space
    node_weights: Tensor  # (M, 36)


def drape(net: DeePSD, sample: Sample, rest: Tensor, entry: ShapedPoses, poses: Tensor, parents: Tensor) -> Draped:
    """Equation 4: offsets in rest space, then linear blend skinning with four influences."""
    with half_precision(wanted=torch.is_grad_enabled()):
        node_weights, *nodes = (each.float() for each in net.static(sample.features, sample.prior, sample.graph))
    transforms = entry.transforms[poses]
    offset = net.offsets(sample, tuple(nodes), pose_features(transforms, parents), entry.shape)
    weight, joint = top_four(sample.at_vertices(node_weights))
    posed, up = skin(rest + offset, weight, joint, transforms)
    skinned, _ = skin(rest.expand_as(offset), weight, joint, transforms)
    return Draped(posed, skinned, up, rest, offset, node_weights)


def of_weights(d: Draped, sample: Sample, schedule: Schedule, progress: float) -> dict[str, Tensor]:
    """Energies of the blend weights: divergence from the body's, and roughness."""
    prior, edges = sample.prior.clamp(min=1e-4), sample.graph.near
    divergence = (d.node_weights * (d.node_weights.clamp(min=1e-6).log() - prior.log())).sum(1)
    rough = ((d.node_weights[edges] - d.node_weights[:, None]).square().sum(2) * (sample.graph.near_weight > 0)).mean()
    return {"prior": schedule.prior_at(progress) * divergence.mean(), "smooth": schedule.smooth_weights * rough}


@torch.no_grad()
def measures(d: Draped, mesh: RestMesh, contacts: Contacts) -> dict[str, float]:
    """The metrics of DESIGN section 9 that need no teacher."""
    length = energies.edge_lengths(d.posed, mesh.edges)
    stretch = (length / mesh.length).flatten()
    out = {
        "penetration_percent": 100 * (contacts.body < 0).float().mean().item(),
        "edge_mm": 1000 * (length - mesh.length).abs().mean().item(),
        "edge_percent": 100 * (stretch - 1).abs().mean().item(),
        "stretch_p999": stretch.kthvalue(int(0.999 * len(stretch))).values.item(),
        "offset_mm": 1000 * d.offset.norm(dim=-1).mean().item(),
    }
    if contacts.layer is not None:
        out["layer_percent"] = 100 * (contacts.layer < 0).float().mean().item()
    return out


def run_one(
    net: DeePSD, sample: Sample, bank: BodyBank, entry: ShapedPoses, poses: Tensor
) -> tuple[Draped, RestMesh, Contacts]:
    rest, mesh = carry(sample, bank, entry)
    d = drape(net, sample, rest, entry, poses, bank.parents)
    return d, mesh, cloth_energy.contacts(d, sample, bank, Bodies.of(entry, poses))


@torch.no_grad()
def validate(net: DeePSD, samples: list[Sample], bank: BodyBank) -> dict[str, float]:
    """Means over validation outfits, each on one held-out shape in all its poses."""
    rows = []
    for i, sample in enumerate(samples):
        entry = bank.entries[i % len(bank.entries)]
        d, mesh, contacts = run_one(net, sample, bank, entry, torch.arange(len(entry.vertices)))
        rows.append(measures(d, mesh, contacts))
    return {k: float(np.mean([r[k] for r in rows if k in r])) for k in sorted({k for r in rows for k in r})}


@dataclass(frozen=True)
class Drawn:
    """What a step drapes."""

    sample: Sample
    entry: ShapedPoses
    poses: Tensor  # (P,)
    rest: Tensor  # (N, 3)
    mesh: RestMesh
    aim: Tensor | None  # (P, N, 3) world, relaxed cloth


def draw(data: Data, rng: np.random.Generator, s: Settings, aimed: float) -> Drawn:
    """A random outfit, body and poses; a share of the draws has relaxed cloth to aim at."""
    bank, targets = data.bank, data.targets.targets
    if targets and rng.random() < aimed:
        t = targets[rng.integers(len(targets))]
        return Drawn(t.sample, bank.entries[t.entry], t.poses, t.rest, t.mesh, t.x)
    sample = data.outfits.samples[rng.integers(len(data.outfits.samples))]
    entry = bank.entries[rng.integers(len(bank.entries))]
    poses = torch.as_tensor(rng.choice(len(entry.vertices), s.poses, replace=False))
    return Drawn(sample, entry, poses, *carry(sample, bank, entry), None)


def step(net: DeePSD, data: Data, rng: np.random.Generator, s: Settings, progress: float) -> dict[str, float]:
    """Gradients of one draw, accumulated. Energies and measures of one step by name."""
    schedule, copying = Schedule(copied=s.copied), progress < s.copied
    it = draw(data, rng, s, 1.0 if copying else s.aimed)
    d = drape(net, it.sample, it.rest, it.entry, it.poses, data.bank.parents)
    terms, measured = of_weights(d, it.sample, schedule, progress), {}
    if it.aim is None or not copying:
        contacts = cloth_energy.contacts(d, it.sample, data.bank, Bodies.of(it.entry, it.poses))
        terms |= cloth_energy.terms(d, d.offset, it.mesh, contacts, it.sample)
        terms |= {name: s.contact * terms[name] for name in ("contact", "layer") if name in terms}
        measured = measures(d, it.mesh, contacts)
    if it.aim is not None:
        # Relaxed cloth is held by its waistband and by friction; holding it back as well would move it away from there.
        terms.pop("hold", None)
        firmness = torch.full_like(it.sample.distance, schedule.target_at(progress))
        terms["target"] = energies.hold(d.posed - it.aim, firmness, it.mesh.area).mean()
        measured["miss_mm"] = 1000 * (d.posed - it.aim).detach().norm(dim=-1).mean().item()
    total = torch.stack([value for name, value in terms.items() if s.terms is None or name in s.terms]).sum()
    total.backward()
    return {k: v.item() for k, v in terms.items()} | measured


@dataclass(frozen=True)
class Settings:
    """What a run is made of."""

    minutes: float
    steps: int = 10**9  # whichever of the two comes first
    poses: int = 5
    outfits_per_step: int = 2
    rate: float = 2e-3
    seed: int = 0
    start: float = 0.0  # progress at which a resumed run goes on
    copied: float = Schedule.copied
    aimed: float = Schedule.aimed
    contact: float = 1.0  # times that cloth in the body or in the layer below counts
    terms: frozenset[str] | None = None  # energies that count, all by default (`ablation`)


@dataclass(frozen=True)
class Data:
    """What a run learns from and is judged on."""

    outfits: OutfitPool
    bank: BodyBank
    targets: TargetPool
    validation: list[Sample]
    validation_bank: BodyBank

    def refresh(self) -> None:
        """Takes in what was made since."""
        self.outfits.refresh()
        self.targets.refresh()


def learn(net: DeePSD, data: Data, s: Settings, out: Path) -> None:
    """The training loop: Muon and Adam, cosine rate, running average of the weights, log lines and checkpoints."""
    rng = np.random.default_rng(s.seed)
    tools = optimisers.muon_and_adam(net, s.rate, OUTER)
    average = torch.optim.swa_utils.AveragedModel(net, multi_avg_fn=torch.optim.swa_utils.get_ema_multi_avg_fn(0.998))
    started, history, count = time.time(), [], 0
    while (done := max((time.time() - started) / (60 * s.minutes), count / s.steps)) < 1:
        progress = s.start + (1 - s.start) * done
        rate = s.rate * min(1, count / 100) * (0.02 + 0.98 * 0.5 * (1 + np.cos(np.pi * progress)))
        optimisers.set_rate(tools, rate)
        history += [step(net, data, rng, s, progress) for _ in range(s.outfits_per_step)]
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimisers.step(tools)
        average.update_parameters(net)
        count += 1
        if count % 100 == 0:
            report(history, count, progress, time.time() - started)
            history.clear()
            data.refresh()
        if count % 500 == 0:
            save(average.module, out, validate(average.module, data.validation, data.validation_bank), count)
    save(average.module, out, validate(average.module, data.validation, data.validation_bank), count)


def report(history: list[dict[str, float]], count: int, progress: float, seconds: float) -> None:
    mean = {
        k: round(float(np.mean([h[k] for h in history if k in h])), 4) for k in sorted({k for h in history for k in h})
    }
    print(json.dumps({"step": count, "progress": round(progress, 3), "seconds": round(seconds), **mean}), flush=True)


def save(net: nn.Module, out: Path, metrics: dict[str, float], count: int) -> None:
    out.parent.mkdir(exist_ok=True)
    torch.save({"net": net.state_dict(), "step": count, "validation": metrics}, out)
    print(json.dumps({"checkpoint": count, **{k: round(v, 4) for k, v in metrics.items()}}), flush=True)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--minutes", type=float, default=60)
    p.add_argument("--out", type=Path, default=RUNS / "deepsd.pt")
    p.add_argument("--resume", type=Path)
    p.add_argument("--outfits", type=Path, default=DATA / "outfits")
    p.add_argument("--relaxed", type=Path, default=DATA / "relaxed", help="targets made by `python -m relax`")
    p.add_argument(
        "--simulated", type=Path, help="outfits and targets made by `python -m teacher.training_set` instead"
    )
    p.add_argument("--limit", type=int, help="use only this many outfits (smoke runs)")
    p.add_argument("--start", type=float, default=0.0, help="progress (0 to 1) at which a resumed run goes on")
    p.add_argument("--rate", type=float, default=2e-3)
    p.add_argument("--seed", type=int, default=0)
    a = p.parse_args()
    torch.manual_seed(0)
    net = DeePSD(Sizes())
    if a.resume:
        net.load_state_dict(torch.load(a.resume)["net"])
    train = OutfitPool(a.simulated / "outfits" if a.simulated else a.outfits / "train", a.limit)
    validation = load_samples(a.outfits / "validation")[: a.limit or VALIDATION_OUTFITS]
    bank = BodyBank.for_training()
    targets = TargetPool(a.simulated or a.relaxed, train, bank)
    data = Data(train, bank, targets, validation, BodyBank(6, 12, 2))
    print(f"{len(train.samples)} training and {len(validation)} validation outfits", flush=True)
    # What stands still may be off in its folds: from simulated cloth there is no copying without the energies.
    shares = Settings(0, copied=0.0, aimed=0.8, contact=4.0) if a.simulated else Settings(0)
    learn(net, data, replace(shares, minutes=a.minutes, rate=a.rate, start=a.start, seed=a.seed), a.out)


if __name__ == "__main__":
    main()
