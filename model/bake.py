"""Refine what the networks say of one outfit: `python -m bake ID --server http://127.0.0.1:8080`.

The outfit is relaxed on random bodies in random poses (`relax`), its basis is fitted to that cloth by least squares,
and basis and blend weights then follow the losses of training; the coefficients stay those of the shared network. The
service takes the result in place of the networks' answers and drapes as fast as before. Other outfits are as they were.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from safetensors.numpy import load, save
from scipy.sparse import coo_matrix, identity
from scipy.sparse.linalg import splu
from torch import Tensor

import cloth_energy
import energies
from nets.deepsd import JOINTS
from posed_bodies import Bodies
from relax import relaxed
from rig import Rig, Scene, coefficients, drape, measure, read, with_riders
from service import Service
from training_data import BodyBank, Sample, carry

ARTIFACTS = Path(__file__).parent / "artifacts"
#: Bodies that a bake learns from, bodies that it is judged on, and poses of each.
BODIES, JUDGES, POSES = 16, 4, 4
#: Further poses of each body in which only the energies count, and the share of steps that aim at relaxed cloth.
FREE, AIMED = 12, 0.5
SEED = 60_000
#: Of the least squares: what a coefficient's square counts against a drape's.
RIDGE = 30.0
#: Of a node's own movement against that of its vertices.
STILL = 1e-2
#: N/m3, how cloth is drawn to its relaxed place beside the energies.
PULL = 4000.0
#: Of the blend weights' logarithms; a basis moves by `BASIS_UNIT` metres of it.
RATE, BASIS_UNIT = 4e-3, 0.03
STEPS = 400
#: J/m2 per unit of divergence of the blend weights from the network's.
KEEP_WEIGHTS = 0.3
#: Methods of the service in the order in which it hashes their networks.
METHODS = ("deepsd", "deepsd-concat")


def fitted(rig: Rig, scenes: list[Scene]) -> Tensor:
    """The basis (R, M, 3) that comes nearest to relaxed cloth with the coefficients as they are.

    What each drape lacks is first brought from the vertices to the nodes, then shared among the basis vectors by ridge
    regression over the drapes.
    """
    count, nodes = len(rig.index), rig.basis.shape[1]
    rows = np.repeat(np.arange(count), rig.index.shape[1])
    spread = coo_matrix((rig.share.flatten().numpy(), (rows, rig.index.flatten().numpy())), (count, nodes)).tocsc()
    to_nodes = splu((spread.T @ spread + STILL * identity(nodes)).tocsc()).solve
    lacks, used = [], []
    for s in scenes:
        turn = torch.einsum("nj,pjkl->pnkl", dense(rig), s.entry.transforms[s.relaxed, :, :, :3])
        missed = s.x - drape(rig, s, s.relaxed, rig.basis, rig.weight).posed
        missed = torch.linalg.solve(turn, missed[..., None])[..., 0]
        lacks += [to_nodes(spread.T @ m.double().numpy()) for m in missed]
        used.append(s.coefficients[s.relaxed])
    c = torch.cat(used).double().numpy()  # (D, R)
    shares = np.linalg.solve(c.T @ c + RIDGE * np.eye(c.shape[1]), c.T)  # (R, D)
    change = np.einsum("rd,dmk->rmk", shares, np.stack(lacks))
    return rig.basis + torch.as_tensor(change, dtype=torch.float32)


def dense(rig: Rig) -> Tensor:
    """Blend weights of the vertices over all joints, (N, J)."""
    return torch.zeros(len(rig.joint), JOINTS).scatter_add(1, rig.joint, rig.weight)


@dataclass(frozen=True)
class Drawn:
    """What a step drapes: a scene in some of its poses, those with relaxed cloth or some of the others."""

    scene: Scene
    poses: Tensor  # (P,)
    aim: Tensor | None  # (P, N, 3) world, relaxed cloth


def draw(scenes: list[Scene], rng: np.random.Generator) -> Drawn:
    """Every other draw has no cloth to aim at: the energies alone judge poses that no relaxed cloth shows."""
    s = scenes[rng.integers(len(scenes))]
    first, count = len(s.x), len(s.coefficients)
    if count == first or rng.random() < AIMED:
        return Drawn(s, s.relaxed, s.x)
    return Drawn(
        s, torch.as_tensor(rng.choice(np.arange(first, count), min(POSES, count - first), replace=False)), None
    )


def losses(rig: Rig, it: Drawn, sample: Sample, bank: BodyBank, basis: Tensor, weight: Tensor) -> dict[str, Tensor]:
    """Energies of the cloth, its distance to relaxed cloth, and that of the blend weights to the network's, by name."""
    s, d = it.scene, drape(rig, it.scene, it.poses, basis, weight)
    near = cloth_energy.contacts(d, sample, bank, Bodies.of(s.entry, it.poses))
    terms = cloth_energy.terms(d, d.posed - d.skinned, s.mesh, near, sample)
    if it.aim is not None:
        terms.pop("hold")  # relaxed cloth is held by its waistband and by friction
        firmness = torch.full_like(sample.distance, PULL)
        terms["target"] = energies.hold(d.posed - it.aim, firmness, s.mesh.area).mean()
    divergence = (weight * (weight.clamp(min=1e-6).log() - rig.weight.clamp(min=1e-6).log())).sum(1)
    terms["weights"] = KEEP_WEIGHTS * divergence.mean()
    return terms


def refine(
    rig: Rig, scenes: list[Scene], sample: Sample, bank: BodyBank, basis: Tensor, steps: int
) -> tuple[Tensor, Tensor]:
    """Basis (R, M, 3) and blend weights (N, 4) of less loss near the given basis: Adam, cosine rate."""
    basis, turn = basis.clone().requires_grad_(), torch.zeros(basis.shape[1], JOINTS, requires_grad=True)
    rates, rng = [RATE * BASIS_UNIT, RATE], np.random.default_rng(0)
    adam = torch.optim.Adam([{"params": [basis]}, {"params": [turn]}], betas=(0.9, 0.98))
    for step in range(steps):
        for group, rate in zip(adam.param_groups, rates, strict=True):
            group["lr"] = rate * (0.02 + 0.98 * 0.5 * (1 + np.cos(np.pi * step / steps)))
        drawn = draw(scenes, rng)
        torch.stack(list(losses(rig, drawn, sample, bank, basis, blended(rig, turn)).values())).sum().backward()
        adam.step()
        adam.zero_grad()
    with torch.no_grad():
        return basis.detach(), blended(rig, turn)


def blended(rig: Rig, turn: Tensor) -> Tensor:
    """The network's blend weights with their logarithms moved by a field over nodes (M, J), (N, 4)."""
    moved = rig.weight.clamp(min=1e-6).log() + rig.spread(turn).gather(1, rig.joint)
    return torch.softmax(moved, 1) * (rig.weight > 0)


def networks_hash(artifacts: Path) -> str:
    """The service's name for a set of networks (`toile-onnx`)."""
    manifests = [json.loads((artifacts / method / "manifest.json").read_text()) for method in METHODS]
    return hashlib.sha256("".join(g["sha256"] for m in manifests for g in m["graphs"]).encode()).hexdigest()


def body_bank() -> BodyBank:
    """Bodies to learn from, then bodies to be judged on; training draws from others."""
    return BodyBank(BODIES + JUDGES, POSES + FREE, SEED)


class Relaxer:
    """What a process needs to relax an outfit, made once."""

    sample: Sample
    bank: BodyBank

    @classmethod
    def start(cls, tensors: dict[str, NDArray]) -> None:
        torch.set_num_threads(1)
        cls.sample, cls.bank = read(tensors)[0], body_bank()

    @classmethod
    def relax(cls, body: int) -> NDArray[np.float32]:
        """In the first poses of a body, (P, N, 3) world."""
        return relaxed(cls.sample, cls.bank, cls.bank.entries[body], torch.arange(POSES)).numpy()


def relaxed_scenes(tensors: dict[str, NDArray], sample: Sample, bank: BodyBank, artifacts: Path) -> Iterator[Scene]:
    """The outfit relaxed on every body of the bank, on two cores."""
    with ProcessPoolExecutor(2, get_context("spawn"), Relaxer.start, (tensors,)) as pool:
        for entry, x in zip(bank.entries, pool.map(Relaxer.relax, range(len(bank.entries))), strict=True):
            yield Scene(
                entry, *carry(sample, bank, entry), coefficients(entry, bank.parents, artifacts), torch.as_tensor(x)
            )


def bake(tensors: dict[str, NDArray], artifacts: Path, steps: int) -> tuple[dict[str, NDArray], dict]:
    """Tensors of the bake and its report, as the service takes them (`toile-drape/src/bake.rs`)."""
    started = time.time()
    (sample, rig), bank, scenes = read(tensors), body_bank(), []
    for scene in relaxed_scenes(tensors, sample, bank, artifacts):
        scenes.append(scene)
        tell(f"relaxed on {len(scenes)} of {len(bank.entries)} bodies", started)
    learned, judges = scenes[:BODIES], scenes[BODIES:]
    figures = {"before": measure(rig, judges, sample, bank, rig.basis, rig.weight)}
    basis = fitted(rig, learned)
    tell(f"fitted: {measure(rig, judges, sample, bank, basis, rig.weight)}", started)
    basis, weight = refine(rig, learned, sample, bank, basis, steps)
    basis = with_riders(rig, basis)
    figures["after"] = measure(rig, judges, sample, bank, basis, weight)
    report = {"minutes": round((time.time() - started) / 60, 1), "drapes": sum(len(s.x) for s in learned)}
    out = {"basis": basis.flatten(1).numpy(), "joints": tensors["joints"].reshape(-1, 4), "weights": weight.numpy()}
    return out, report | {k: asdict(v) for k, v in figures.items()}


def tell(what: str, started: float) -> None:
    print(f"{time.time() - started:5.0f} s  {what}", flush=True)


def metadata(file: bytes) -> dict[str, str]:
    """Of a safetensors file."""
    return json.loads(file[8 : 8 + int.from_bytes(file[:8], "little")]).get("__metadata__", {})


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("outfit", help="its id at the server")
    p.add_argument("--server", default="http://127.0.0.1:8080")
    p.add_argument("--artifacts", type=Path, default=ARTIFACTS, help="those of the server")
    p.add_argument("--steps", type=int, default=STEPS, help="of the losses, after the least squares")
    a = p.parse_args()
    service = Service(a.server, a.outfit)
    file = service.ask("GET", "static.safetensors")
    outfit = load(file)
    if outfit["networks"].tobytes().decode() != networks_hash(a.artifacts):
        raise SystemExit(f"The server has other networks than {a.artifacts}; name its own with --artifacts.")
    tensors, report = bake(outfit, a.artifacts, a.steps)
    service.ask("PUT", "bake", save(tensors, metadata(file) | {"report": json.dumps(report)}))
    print(json.dumps(report))


if __name__ == "__main__":
    main()
