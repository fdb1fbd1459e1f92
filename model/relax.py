"""Relax hanging cloth to its equilibrium, as targets for training: `python -m relax --minutes 60`.

Training by energies alone finds drapes near plain skinning; a skirt over a lap is far from it. Here the cloth of
a drawn outfit, body and pose is moved itself, without a network, to the least energy while the body bends: a
quasi-Newton method whose first metric is the outfit's stretch stiffness (after Liu, Bouaziz and Kavan,
Quasi-Newton Methods for Real-Time Simulation of Hyperelastic Materials, 2017). Results lie under data/relaxed,
where a training run finds them while it runs.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix, diags
from scipy.sparse.linalg import splu
from torch import Tensor

import cloth_energy
from bending import bent
from cloth_energy import Posed
from energies import RestMesh
from fabric import Fabric
from garment.binding import garment_joint_names
from nets.deepsd import gather_mean, skin, top_four
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


def metric(mesh: RestMesh, held: Tensor) -> csc_matrix:
    """Stiffness of the rest mesh against stretch and movement, (N, N), of the mean energy; waistbands do not move."""
    area, n = float(mesh.area.sum()), len(mesh.area)
    stiffness = (Fabric().stretch * mesh.edge_area / mesh.length.square() / area).double().numpy()
    a, b = mesh.edges.numpy().T
    pairs = (np.concatenate([a, b]), np.concatenate([b, a]))
    off = coo_matrix((np.tile(-stiffness, 2), pairs), (n, n)).tocsr()
    own = -np.asarray(off.sum(1)).ravel() + ANCHOR * mesh.area.double().numpy() / area
    own[held.numpy()] += FIRM
    return (off + diags(own)).tocsc()


def relax(
    sample: Sample, mesh: RestMesh, start: Posed, bank: BodyBank, entry: ShapedPoses, pose: Tensor, steps: int
) -> Tensor:
    """Positions of least energy near `start`, (1, N, 3) world, or as far as `steps` go. pose (1,): of the entry's.

    What the cloth touches is looked up every `LOOKED_UP` steps: in between, the energy is smooth.
    """
    on = cloth_energy.touching(start, sample, bank, entry, pose)

    def energy(x: Tensor) -> Energy:
        x = x.clone().requires_grad_()
        d = replace(start, posed=x)
        near = cloth_energy.clearances(x, on, sample, entry, pose)
        terms = cloth_energy.terms(d, x - d.skinned, mesh, near, sample)
        # Holding cloth back is for networks that have not learned yet; here friction does it.
        return Energy(x, torch.stack([value for name, value in terms.items() if name != "hold"]).sum(), sample.held)

    solve = splu(metric(mesh, sample.held)).solve
    here, pairs = energy(start.posed), []
    best, lowest = start.posed, np.inf
    for k in range(steps + 1):
        if k % LOOKED_UP == 0 or k == steps:
            on = cloth_energy.touching(replace(start, posed=here.x.detach()), sample, bank, entry, pose, before=on)
            here = energy(here.x.detach())
            if here.value < lowest:
                best, lowest = here.x.detach(), here.value
            if k == steps:
                break
        move = -two_loops(here.slope, pairs, solve)
        there = search(energy, here, move)
        if there is None and not pairs:
            break
        pairs = [] if there is None else remembered(pairs, here, there)
        here = there or here
    return best


class Energy:
    """An energy at x (1, N, 3) and, when asked for, its slope (N, 3), zero where cloth is held."""

    def __init__(self, x: Tensor, total: Tensor, held: Tensor) -> None:
        self.x, self.total, self.held, self.value = x, total, held, total.item()

    @cached_property
    def slope(self) -> Floats:
        (slope,) = torch.autograd.grad(self.total, self.x)
        slope[:, self.held] = 0
        return slope[0].double().numpy()


def search(energy: Callable[[Tensor], Energy], here: Energy, move: Floats) -> Energy | None:
    """The first of ever shorter steps along a move that lowers the energy enough, if one does."""
    share, descent = min(1.0, LONGEST / np.abs(move).max()), float((here.slope * move).sum())
    for _ in range(10):
        there = energy(here.x.detach() + torch.as_tensor(share * move, dtype=here.x.dtype)[None])
        if there.value <= here.value + 1e-4 * share * descent:
            return there
        share /= 2
    return None


def remembered(pairs: list[tuple[Floats, Floats]], here: Energy, there: Energy) -> list[tuple[Floats, Floats]]:
    """Differences of places and slopes, the newest last."""
    moved = (there.x - here.x).detach()[0].double().numpy()
    pairs = [*pairs, (moved, there.slope - here.slope)][-MEMORY:]
    return [(s, y) for s, y in pairs if (s * y).sum() > 1e-14]


def two_loops(slope: Floats, pairs: list[tuple[Floats, Floats]], solve: object) -> Floats:
    """The inverse metric after the remembered pairs, applied to a slope (N, 3)."""
    q, shares = slope.copy(), []
    for s, y in reversed(pairs):
        shares.append((s * q).sum() / (s * y).sum())
        q -= shares[-1] * y
    z = solve(q)  # type: ignore[operator]
    for (s, y), share in zip(pairs, reversed(shares), strict=True):
        z += s * (share - (y * z).sum() / (s * y).sum())
    return z


@torch.no_grad()
def skinned(sample: Sample, rest: Tensor, entry: ShapedPoses, poses: Tensor) -> Posed:
    """Plain skinning by the diffused weights of the body."""
    x, up = skin(rest.expand(len(poses), -1, -1), *influences(sample), entry.transforms[poses])
    return Posed(x, x, up)


def influences(sample: Sample) -> tuple[Tensor, Tensor]:
    """Diffused weights of the body at each vertex, (N, 4), and their joints, (N, 4)."""
    return top_four(gather_mean(sample.prior, sample.vertex_from_node, sample.vertex_from_node_weight))


def relaxed(sample: Sample, bank: BodyBank, entry: ShapedPoses, poses: Tensor) -> Tensor:
    """An outfit on one body, relaxed in several poses, (P, N, 3) world."""
    rest, mesh = carry(sample, bank, entry)
    return torch.cat([follow(sample, rest, mesh, bank, entry, int(p)) for p in poses])


def follow(
    sample: Sample, rest: Tensor, mesh: RestMesh, bank: BodyBank, entry: ShapedPoses, pose: int, steps: int = STEPS
) -> Tensor:
    """An outfit (N, 3) relaxed in one pose, (1, N, 3) world, while the body bends there from the A-pose.

    Skinned into a deep bend at once it would lie inside the limbs, and the nearest way out is often the wrong one.
    """
    away = torch.zeros_like(rest)  # from where skinning puts the cloth, in rest axes
    for share in (*ON_THE_WAY, 1.0):
        there, at = (bent(entry, bank, pose, share), 0) if share < 1 else (entry, pose)
        start, turn = skinned(sample, rest, there, torch.tensor([at])), turns(sample, there, at)
        start = replace(start, posed=start.skinned + (turn @ away[..., None])[None, ..., 0])
        x = relax(sample, mesh, start, bank, there, torch.tensor([at]), FEW if share < 1 else steps)
        away = (turn.transpose(1, 2) @ (x - start.skinned)[0][..., None])[..., 0]
    return x


def turns(sample: Sample, entry: ShapedPoses, pose: int) -> Tensor:
    """How skinning turns each vertex in one pose, (N, 3, 3), not quite rotations."""
    weight, joint = influences(sample)
    return (entry.transforms[pose, :, :, :3][joint] * weight[..., None, None]).sum(1)


def chances(entry: ShapedPoses) -> Floats:
    """How often each pose is drawn, (P,): every other draw has a leg bent far at the hip."""
    names = garment_joint_names()
    legs = [names.index("upperleg01.L"), names.index("upperleg01.R")]
    deep = (entry.transforms[:, legs, 1, 1].min(1).values < BENT).numpy()
    share = np.where(deep, 1 / max(deep.sum(), 1), 1 / max((~deep).sum(), 1))
    return share / share.sum()


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--minutes", type=float, default=60)
    p.add_argument("--outfits", type=Path, default=DATA / "outfits" / "train")
    p.add_argument("--out", type=Path, default=DATA / "relaxed")
    p.add_argument("--poses", type=int, default=4, help="of each outfit on one body")
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
        poses = torch.as_tensor(rng.choice(len(entry.vertices), a.poses, replace=False, p=chances(entry)))
        path = a.out / f"{sample.name}_{k}_{a.seed}.npz"
        if path.exists():
            continue
        x = relaxed(sample, bank, entry, poses)
        part = path.with_suffix(".part.npz")
        np.savez(part, outfit=sample.name, entry=k, poses=poses.numpy(), transforms=entry.transforms[poses], x=x)
        part.rename(path)
        count += 1
        print(json.dumps({"relaxed": count, "seconds": round(time.time() - started)}), flush=True)


if __name__ == "__main__":
    main()
