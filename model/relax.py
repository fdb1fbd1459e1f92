"""Relax hanging cloth to its equilibrium, as targets for training: `python -m relax --minutes 60`.

Training by energies alone finds drapes near plain skinning; a skirt over a lap is far from it. Here the cloth of
a drawn outfit, body and pose is moved itself, without a network, to the least energy while the body bends: a
quasi-Newton method whose first metric is the outfit's stretch stiffness (after Liu, Bouaziz and Kavan,
Quasi-Newton Methods for Real-Time Simulation of Hyperelastic Materials, 2017). B drapes of one outfit are relaxed
at once, each with its own memory and length of step. Results lie under data/relaxed, where a training run finds
them while it runs.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

import cloth_energy
from cloth_energy import Posed
from energies import RestMesh
from fabric import Fabric
from garment.binding import garment_joint_names
from nets.deepsd import skin, top_four
from posed_bodies import Bodies, bent
from training_data import DATA, BodyBank, Sample, ShapedPoses, carry, load_samples

Floats = NDArray[np.float64]

#: Steps of a relaxation and pairs of differences that the metric remembers.
STEPS, MEMORY = 80, 8
#: Steps after which what the cloth touches is looked up anew.
LOOKED_UP = 3
#: Shares of a pose at which cloth is relaxed on the way there, and steps at each.
ON_THE_WAY, FEW = (0.25, 0.5, 0.75), 15
#: m, the longest move of a vertex in one step.
LONGEST = 0.05
#: Lengths of a step that are tried, each a share of the one before.
TRIES, SHORTER = 5, 0.25
#: J/m4, stiffness against absolute movement in the first metric.
ANCHOR = 2000.0
#: Cosine of a thigh's turn from which a pose bends deeply.
BENT = 0.6
#: Vertices of an outfit at most, for the time that it takes.
LARGEST = 2200
#: m from the skin where cloth counts as hanging.
FAR = 0.06
#: Share of an outfit that counts as hanging at least, where outfits are drawn the oftener the more of them hangs.
LITTLE = 0.3
#: J/m2 per m2, stiffness that keeps waistbands where they are.
FIRM = 1e6
#: m from where skinning puts it: what lies farther has fallen off, as a bow that nothing holds.
FALLEN = 0.6


@dataclass(frozen=True)
class Worn:
    """One outfit on B bodies in the A-pose: (B, N, 3), and its tables there."""

    rest: Tensor
    mesh: RestMesh

    @classmethod
    def of(cls, sample: Sample, bank: BodyBank, entry: ShapedPoses, count: int) -> Worn:
        """The same body for all of `count` drapes."""
        return cls.stacked([carry(sample, bank, entry)] * count)

    @classmethod
    def stacked(cls, carried: list[tuple[Tensor, RestMesh]]) -> Worn:
        """One body for each drape, from `carry`."""
        first = carried[0][1]
        own = {k: torch.stack([getattr(m, k) for _, m in carried]) for k in ("length", "edge_area", "angle")}
        own |= {k: torch.stack([getattr(m, k) for _, m in carried]) for k in ("hinge_weight", "area")}
        return cls(torch.stack([rest for rest, _ in carried]), replace(first, **own))


def softness(mesh: RestMesh, held: Tensor) -> Tensor:
    """Inverse of the rest mesh's stiffness against stretch and movement, (N, N), of the mean energy.

    The mean over the bodies of `mesh`; waistbands do not move.
    """
    area, n = mesh.area.sum(-1, keepdim=True), mesh.area.shape[-1]
    pull = (Fabric().stretch * mesh.edge_area / mesh.length.square() / area).double().mean(0)
    a, b = mesh.edges.T
    stiffness = pull.new_zeros(n, n)
    for i, j in ((a, b), (b, a)):
        stiffness.index_put_((i, j), -pull, accumulate=True)
    own = ANCHOR * (mesh.area / area).double().mean(0) - stiffness.sum(1)
    own[held] += FIRM
    return torch.cholesky_inverse(torch.linalg.cholesky(stiffness + own.diag())).float()


@dataclass(frozen=True)
class Point:
    """Cloth x (B, N, 3), its energy (B,) and slope (B, N, 3), zero where cloth is held."""

    x: Tensor
    value: Tensor
    slope: Tensor


@dataclass(frozen=True)
class Pair:
    """Differences of places and slopes, (B, N, 3), and one over their product, (B, 1, 1), 0 for none."""

    moved: Tensor
    turned: Tensor
    inverse: Tensor

    @classmethod
    def between(cls, here: Point, there: Point) -> Pair:
        moved, turned = there.x - here.x, there.slope - here.slope
        product = inner(moved, turned)
        return cls(moved, turned, torch.where(product > 1e-14, 1 / product.clamp(min=1e-14), 0))


def inner(a: Tensor, b: Tensor) -> Tensor:
    """Products of each drape, (B, 1, 1)."""
    return (a * b).sum((1, 2), keepdim=True)


#: Energy of cloth (B, N, 3), (B,).
Energy = Callable[[Tensor], Tensor]


def relax(
    sample: Sample, mesh: RestMesh, start: Posed, bank: BodyBank, bodies: Bodies, soft: Tensor, steps: int
) -> Tensor:
    """Positions of least energy near `start`, (B, N, 3) world, or as far as `steps` go. soft: of `softness`.

    What the cloth touches is looked up every `LOOKED_UP` steps: in between, the energy is smooth.
    """
    on = cloth_energy.touching(start, sample, bank, bodies)

    def energy(x: Tensor) -> Tensor:
        near = cloth_energy.clearances(x, on, sample, bodies)
        terms = cloth_energy.of_each(replace(start, posed=x), x - start.skinned, mesh, near, sample)
        # Holding cloth back is for networks that have not learned yet; here friction does it.
        return torch.stack([value for name, value in terms.items() if name != "hold"]).sum(0)

    here, pairs = point(energy, start.posed, sample.held), []
    best, lowest = start.posed, torch.full_like(here.value, torch.inf)
    still = torch.zeros_like(here.value, dtype=torch.bool)
    for k in range(steps + 1):
        if k % LOOKED_UP == 0 or k == steps:
            on = cloth_energy.touching(replace(start, posed=here.x), sample, bank, bodies, before=on)
            here = point(energy, here.x, sample.held)
            better = here.value < lowest
            best, lowest = torch.where(better[:, None, None], here.x, best), torch.minimum(here.value, lowest)
            if k == steps or still.all():
                break
        there, went = search(energy, here, -two_loops(here.slope, pairs, soft), sample.held, still)
        remembers = torch.stack([p.inverse[:, 0, 0] > 0 for p in pairs]).any(0) if pairs else torch.zeros_like(still)
        still = still | ~(went | remembers)
        kept = [replace(p, inverse=p.inverse * went[:, None, None]) for p in pairs]
        pairs, here = [*kept, Pair.between(here, there)][-MEMORY:], there
    return best


def point(energy: Energy, x: Tensor, held: Tensor) -> Point:
    x = x.detach().requires_grad_()
    return with_slope(x, energy(x), held)


def with_slope(x: Tensor, value: Tensor, held: Tensor) -> Point:
    (slope,) = torch.autograd.grad(value.sum(), x)
    slope[:, held] = 0
    return Point(x.detach(), value.detach(), slope)


def search(energy: Energy, here: Point, move: Tensor, held: Tensor, still: Tensor) -> tuple[Point, Tensor]:
    """The first of ever shorter steps along a move that lowers each energy enough, and which drapes (B,) went.

    Others stay where they are, and so do those that are `still`.
    """
    share = (LONGEST / move.abs().amax((1, 2)).clamp(min=1e-12)).clamp(max=1.0) * ~still
    descent = inner(here.slope, move)[:, 0, 0]
    for tried in range(TRIES + 1):
        x = (here.x + share[:, None, None] * move).requires_grad_()
        value = energy(x)
        went = value <= here.value + 1e-4 * share * descent
        if went.all() or tried == TRIES:
            break
        share = torch.where(went, share, share * SHORTER if tried < TRIES - 1 else 0)
    return with_slope(x, value, held), share > 0


def two_loops(slope: Tensor, pairs: list[Pair], soft: Tensor) -> Tensor:
    """The inverse metric after the remembered pairs, applied to a slope (B, N, 3)."""
    q, shares = slope, []
    for p in reversed(pairs):
        shares.append(inner(p.moved, q) * p.inverse)
        q = q - shares[-1] * p.turned
    z = applied(soft, q)
    for p, share in zip(pairs, reversed(shares), strict=True):
        z = z + p.moved * (share - inner(p.turned, z) * p.inverse)
    return z


def applied(soft: Tensor, q: Tensor) -> Tensor:
    """A symmetric matrix (N, N) times each of q (B, N, 3), in one product: one each would read it B times."""
    flat = q.transpose(1, 2).reshape(-1, len(soft))
    return (flat @ soft).unflatten(0, (len(q), 3)).transpose(1, 2)


@torch.no_grad()
def skinned(sample: Sample, rest: Tensor, transforms: Tensor) -> Posed:
    """Plain skinning of rest (B, N, 3) by the diffused weights of the body."""
    x, up = skin(rest, *influences(sample), transforms)
    return Posed(x, x, up)


@torch.no_grad()
def influences(sample: Sample) -> tuple[Tensor, Tensor]:
    """Diffused weights of the body at each vertex, (N, 4), and their joints, (N, 4)."""
    return top_four(sample.at_vertices(sample.prior))


def relaxed(sample: Sample, bank: BodyBank, entry: ShapedPoses, poses: Tensor, steps: int = STEPS) -> Tensor:
    """An outfit on one body, relaxed in several poses, (P, N, 3) world."""
    return follow(sample, Worn.of(sample, bank, entry, len(poses)), bank, Bodies.of(entry, poses), steps)


def worn_still(sample: Sample, bank: BodyBank, entry: ShapedPoses, poses: Tensor, x: Tensor) -> Tensor:
    """Which drapes x (P, N, 3) have no piece that fell off, (P,)."""
    start = skinned(sample, carry(sample, bank, entry)[0].expand_as(x), entry.transforms[poses])
    return (x - start.skinned).norm(dim=-1).amax(1) < FALLEN


def follow(sample: Sample, worn: Worn, bank: BodyBank, bodies: Bodies, steps: int = STEPS) -> Tensor:
    """An outfit relaxed on B bodies, (B, N, 3) world, while each bends from the A-pose to its pose.

    Skinned into a deep bend at once it would lie inside the limbs, and the nearest way out is often the wrong one.
    """
    soft = softness(worn.mesh, sample.held)
    away = torch.zeros_like(worn.rest)  # from where skinning puts the cloth, in rest axes
    for share in (*ON_THE_WAY, 1.0):
        there = bent(bodies, bank, share) if share < 1 else bodies
        start, turn = skinned(sample, worn.rest, there.transforms), turns(sample, there.transforms)
        start = replace(start, posed=start.skinned + (turn @ away[..., None])[..., 0])
        x = relax(sample, worn.mesh, start, bank, there, soft, FEW if share < 1 else steps)
        away = (turn.transpose(-2, -1) @ (x - start.skinned)[..., None])[..., 0]
    return x


def turns(sample: Sample, transforms: Tensor) -> Tensor:
    """How skinning turns each vertex, (B, N, 3, 3), not quite rotations."""
    weight, joint = influences(sample)
    return (transforms[:, joint, :, :3] * weight[..., None, None]).sum(2)


def chances(transforms: Floats) -> Floats:
    """How often each pose (P, J, 3, 4) is drawn, (P,): every other draw has a leg bent far at the hip."""
    names = garment_joint_names()
    legs = [names.index("upperleg01.L"), names.index("upperleg01.R")]
    deep = transforms[:, legs, 1, 1].min(1) < BENT
    share = np.where(deep, 1 / max(deep.sum(), 1), 1 / max((~deep).sum(), 1))
    return share / share.sum()


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--minutes", type=float, default=60)
    p.add_argument("--outfits", type=Path, default=DATA / "outfits" / "train")
    p.add_argument("--out", type=Path, default=DATA / "relaxed")
    p.add_argument("--poses", type=int, default=4, help="of each outfit on one body")
    p.add_argument("--steps", type=int, default=STEPS, help="in the pose itself; more are sharper, and fewer outfits")
    p.add_argument("--seed", type=int, default=0)
    p.add_argument("--limit", type=int, help="stop after this many outfits (smoke runs)")
    a = p.parse_args()
    bank, rng, started = BodyBank.for_training(), np.random.default_rng(a.seed), time.time()
    samples = [s for s in load_samples(a.outfits) if len(s.vertices) <= LARGEST]
    free = np.array([LITTLE + float((s.distance > FAR).float().mean()) for s in samples])
    a.out.mkdir(parents=True, exist_ok=True)
    count = 0
    while time.time() - started < 60 * a.minutes and count < (a.limit or 10**9):
        sample, k = samples[rng.choice(len(samples), p=free / free.sum())], int(rng.integers(len(bank.entries)))
        entry = bank.entries[k]
        chance = chances(entry.transforms.numpy())
        poses = torch.as_tensor(rng.choice(len(entry.vertices), a.poses, replace=False, p=chance))
        path = a.out / f"{sample.name}_{k}_{a.seed}.npz"
        if path.exists():
            continue
        x = relaxed(sample, bank, entry, poses, a.steps)
        worn = worn_still(sample, bank, entry, poses, x)
        if not worn.any():
            continue
        x, poses = x[worn], poses[worn]
        part = path.with_suffix(".part.npz")
        np.savez(part, outfit=sample.name, entry=k, poses=poses.numpy(), transforms=entry.transforms[poses], x=x)
        part.rename(path)
        count += 1
        print(json.dumps({"relaxed": count, "seconds": round(time.time() - started)}), flush=True)


if __name__ == "__main__":
    main()
