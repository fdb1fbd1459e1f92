"""Energies of cloth as training losses: pure functions of posed vertices. Metres, joules per square metre.

x: (P, N, 3) posed vertices of P poses. All energies are (P,), one for each pose: area-weighted sums over the outfit
divided by its area, so they compare across outfits and resolutions. Tables of the rest mesh are of one body, or of one
for each pose with P in front.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from fabric import Fabric


@dataclass(frozen=True)
class RestMesh:
    """Constant tables of one outfit on one body shape; on several, P stands before all but `edges` and `hinges`."""

    edges: Tensor  # (E, 2)
    length: Tensor  # (E,)
    edge_area: Tensor  # (E,) m2, a third of the two triangles
    hinges: Tensor  # (H, 4) shared edge a, b and the two opposite vertices
    angle: Tensor  # (H,) rest dihedral, radians
    hinge_weight: Tensor  # (H,) |e|^2 / area
    area: Tensor  # (N,) m2


def edge_lengths(x: Tensor, edges: Tensor) -> Tensor:
    """(P, N, 3) -> (P, E)."""
    return (x[:, edges[:, 0]] - x[:, edges[:, 1]]).square().sum(-1).add(1e-12).sqrt()


def stretch(x: Tensor, mesh: RestMesh, distance: Tensor, fabric: Fabric) -> Tensor:
    """Edge term: equation 10 of DeePSD as springs that lock when long and buckle when short.

    Cloth under compression folds at a constant load, the smaller the longer its folds: small where it hangs
    free, larger on the skin. Folds finer than a node cannot be drawn by the network, so their shortening is left
    to the edges (tension field theory). distance (N,): of each vertex to the skin at rest.
    """
    room = torch.exp(-distance.clamp(min=0)[mesh.edges].mean(1) / fabric.room)
    buckling = fabric.buckling + (fabric.confined - fabric.buckling) * room
    strain = edge_lengths(x, mesh.edges) / mesh.length - 1
    longer, shorter = strain.clamp(min=0), (-strain).clamp(min=0)
    bent = torch.minimum(shorter, buckling)
    tension = 0.5 * longer.square() + 0.5 * fabric.stiffening * (longer - fabric.limit).clamp(min=0).square()
    pressure = fabric.compression * bent * (shorter - 0.5 * bent)
    pressure = pressure + 0.5 * (shorter - fabric.crumple).clamp(min=0).square()
    return (fabric.stretch * (tension + pressure) * mesh.edge_area).sum(1) / mesh.area.sum(-1)


def dihedral(x: Tensor, hinges: Tensor) -> Tensor:
    """Signed dihedral angles at the shared edges, (P, H), zero when flat."""
    a, b, c, d = (x[:, hinges[:, k]] for k in range(4))
    edge = b - a
    left = torch.linalg.cross(edge, c - a)
    right = torch.linalg.cross(d - a, edge)
    unit = edge / edge.square().sum(-1, keepdim=True).add(1e-12).sqrt()
    sine = (torch.linalg.cross(left, right) * unit).sum(-1)
    cosine = (left * right).sum(-1)
    return torch.atan2(sine, cosine + 1e-12)


def bending(x: Tensor, mesh: RestMesh, fabric: Fabric) -> Tensor:
    """Bend relative to the rest dihedral, so that pleats are not ironed flat (equation 11, discrete shells)."""
    turn = dihedral(x, mesh.hinges) - mesh.angle
    turn = torch.remainder(turn + torch.pi, 2 * torch.pi) - torch.pi
    return (0.5 * fabric.bending * turn.square() * mesh.hinge_weight).sum(1) / mesh.area.sum(-1)


def clearance(x: Tensor, points: Tensor, normals: Tensor) -> Tensor:
    """Signed distance of each vertex along the normal of its nearest surface point, (P, N)."""
    return ((x - points) * normals).sum(-1)


def contact(distance: Tensor, margin: Tensor, area: Tensor, fabric: Fabric, share: Tensor | float = 1.0) -> Tensor:
    """Collision term, equation 12 squared: distance (P, N) below margin (N,) is penalised, linearly beyond `deep`.

    share (P, N): how much each vertex counts.
    """
    depth = (margin - distance).clamp(min=0)
    near = depth.clamp(max=fabric.deep)
    return (fabric.contact * near * (2 * depth - near) * share * area).sum(1) / area.sum(-1)


def weight_change(x: Tensor, up: Tensor, borne: Tensor, area: Tensor, fabric: Fabric) -> Tensor:
    """Potential of gravity beyond what the rest pose already bears.

    up (P, N, 3): where skinning turns each vertex's rest +Y; borne (N,): share of its weight that the skin
    under it carries at rest. Cloth on the body is drawn lying there: what bore it along its own up still bears
    gravity's component along it, so that an upright shirt does not sag further and a raised one falls.
    Cloth that hangs free feels gravity whole.
    """
    support = borne[..., None] * up[..., 1:2].clamp(min=0) * up
    load = x.new_tensor([0.0, 1.0, 0.0]) - support
    return (fabric.density * fabric.gravity * (load * x).sum(-1) * area).sum(1) / area.sum(-1)


def friction(slip: Tensor, normals: Tensor, distance: Tensor, area: Tensor, fabric: Fabric) -> Tensor:
    """Cloth that rests on the body stays where it lies: a lap carries a skirt, shoulders carry a shirt.

    slip (P, N, 3): displacement from where skinning puts the cloth; normals (P, N, 3) and distance (P, N) of the
    skin nearest to that place. The pressure of cloth on skin grows with the upward share of the normal and fades with
    distance; only slip along the skin counts.
    """
    along = slip - (slip * normals).sum(-1, keepdim=True) * normals
    pressure = normals[..., 1].clamp(min=0) * torch.exp(-distance.clamp(min=0) / fabric.resting)
    return (fabric.friction * pressure * along.square().sum(-1) * area).sum(1) / area.sum(-1)


def hold(offset: Tensor, grip: Tensor, area: Tensor) -> Tensor:
    """Friction's stand-in: cloth near the skin keeps its place. offset (P, N, 3), grip (N,) N/m3."""
    return (grip * offset.square().sum(-1) * area).sum(1) / area.sum(-1)
