"""The whole energy of posed cloth: what training lowers and relaxation minimises. World space, J/m2."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

import energies
from energies import RestMesh
from fabric import Fabric
from garment import nearest
from posed_bodies import Bodies
from training_data import BodyBank, Sample

#: Share of the contact that counts in a fold of the body, which the resolve opens.
PINCHED = 0.02
#: N/m3, resistance to offsets of cloth on the body; a tenth of it where cloth hangs free.
KEEP = 15.0
#: N/m3, resistance to offsets of cloth on the skin, and how far (m) the skin grips.
GRIP, GRIP_REACH = 400.0, 0.008
#: N/m3, how firmly waistbands hold.
WAISTBAND = 5000.0


@dataclass(frozen=True)
class Posed:
    """Cloth in several poses of one body."""

    posed: Tensor  # (P, N, 3) world
    skinned: Tensor  # (P, N, 3) world, where skinning alone puts it
    up: Tensor  # (P, N, 3) where the rest +Y of each vertex turns to


@dataclass(frozen=True)
class Touching:
    """Which surface is nearest to the cloth, (P poses, N vertices); it does not move with the cloth."""

    body: Tensor  # (P, N) body vertex nearest to each vertex
    lap: Tensor  # (P, N, 3) normal of the skin under each vertex where skinning puts it
    lap_distance: Tensor  # (P, N) distance to it
    inner: Tensor | None = None  # (P, Q) vertex of an inner garment nearest to each outer vertex
    inner_normal: Tensor | None = None  # (P, Q, 3)


@dataclass(frozen=True)
class Contacts:
    """How far the cloth is from what it touches, (P poses, N vertices)."""

    body: Tensor  # (P, N) clearance to the skin
    pinched: Tensor  # (P, N) nearest to a fold of the body that leaves cloth no room
    lap: Tensor  # (P, N, 3) as in `Touching`
    lap_distance: Tensor  # (P, N)
    layer: Tensor | None = None  # (P, Q) clearance of outer garments to inner ones


def contacts(d: Posed, sample: Sample, bank: BodyBank, bodies: Bodies) -> Contacts:
    """Clearances to the nearest points of the bodies and of inner garments."""
    return clearances(d.posed, touching(d, sample, bank, bodies), sample, bodies)


@torch.no_grad()
def touching(d: Posed, sample: Sample, bank: BodyBank, bodies: Bodies, before: Touching | None = None) -> Touching:
    """What the cloth touches; `before`: the same, of cloth that skinning puts at the same place."""
    surface, normals = bodies.vertices, bodies.normals
    body = nearest.nearest(d.posed, surface, sample.candidates, bank.ring)
    if before is None:
        under = nearest.nearest(d.skinned, surface, sample.candidates, bank.ring)
        lap = nearest.surface_at(normals, under)
        lap_distance = energies.clearance(d.skinned, nearest.surface_at(surface, under), lap)
    else:
        lap, lap_distance = before.lap, before.lap_distance
    if not len(sample.outer):
        return Touching(body, lap, lap_distance)
    inner = nearest.best_of(d.posed[:, sample.outer], d.posed, sample.inner[None].expand(len(surface), -1, -1))
    cloth_normals = nearest.vertex_normals(d.posed, sample.tables[2])
    return Touching(body, lap, lap_distance, inner, nearest.surface_at(cloth_normals, inner))


def clearances(x: Tensor, on: Touching, sample: Sample, bodies: Bodies) -> Contacts:
    """Signed distances of cloth x (P, N, 3) to what it touches."""
    points = nearest.surface_at(bodies.vertices, on.body)
    body = energies.clearance(x, points, nearest.surface_at(bodies.normals, on.body))
    layer = None
    if on.inner is not None and on.inner_normal is not None:
        layer = energies.clearance(x[:, sample.outer], nearest.surface_at(x, on.inner), on.inner_normal)
    return Contacts(body, bodies.pinched.gather(1, on.body), on.lap, on.lap_distance, layer)


def borne(sample: Sample) -> Tensor:
    """Share of each vertex's weight that the skin under it carries at rest, (N,): 1 on the skin, 0 far from it."""
    return torch.exp(-sample.distance.clamp(min=0) / Fabric.hang)


def terms(d: Posed, offset: Tensor, mesh: RestMesh, near: Contacts, sample: Sample) -> dict[str, Tensor]:
    """Every energy of cloth by name, its mean over the poses; arguments as of `of_each`."""
    return {name: value.mean() for name, value in of_each(d, offset, mesh, near, sample).items()}


def of_each(d: Posed, offset: Tensor, mesh: RestMesh, near: Contacts, sample: Sample) -> dict[str, Tensor]:
    """Every energy of cloth by name, (P,). offset (P, N, 3): from where skinning puts it, in any rotated frame."""
    fabric = Fabric()
    on_skin = borne(sample)
    margin = sample.distance.clamp(fabric.least, fabric.thickness)
    grip = KEEP * (0.1 + on_skin) + GRIP * torch.exp(-sample.distance.clamp(min=0) / GRIP_REACH)
    grip = grip.index_fill(0, sample.held, WAISTBAND)
    share = torch.where(near.pinched, PINCHED, 1.0)
    out = {
        "stretch": energies.stretch(d.posed, mesh, sample.distance, fabric),
        "bend": energies.bending(d.posed, mesh, fabric),
        "contact": energies.contact(near.body, margin, mesh.area, fabric, share),
        "gravity": energies.weight_change(d.posed, d.up, on_skin, mesh.area, fabric),
        "hold": energies.hold(offset, grip, mesh.area),
        "friction": energies.friction(d.posed - d.skinned, near.lap, near.lap_distance, mesh.area, fabric),
    }
    if near.layer is not None:
        gap, covered = sample.layer_gap.clamp(max=0.003), mesh.area[..., sample.outer]
        share_covered = covered.sum(-1) / mesh.area.sum(-1)
        out["layer"] = energies.contact(near.layer, gap, covered, fabric) * share_covered
    return out
