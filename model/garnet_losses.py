"""GarNet++'s losses (Gundogdu et al. 2020, sections 3.3 and 3.4) and measures (section 4.1): pure functions.

x: (P, N, 3) vertices of P drapes of one garment, metres, world space; `truth` are simulated ones. Every loss is a mean
over the drapes. Neighbourhoods are tables of the garment, made once from its rest mesh.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.spatial import cKDTree
from torch import Tensor

import energies

Ints = NDArray[np.int64]

#: m, distance from its simulated place within which a vertex is asked to be outside the body (section 3.5).
TOLERANCE = 0.05
#: Of the mean edge length: how far matched body points move out along their normals (section 3.5).
EXTENSION = 0.2
#: Cotangents beyond this are cut off: slivers would outweigh everything (section 3.4.2).
STEEPEST = 20.0


def vertices(x: Tensor, truth: Tensor) -> Tensor:
    """Mean distance to the simulated place, metres (equation 4; E_dist, equation 17)."""
    return (x - truth).norm(dim=-1).mean()


def interpenetration(x: Tensor, truth: Tensor, body: Tensor, body_normals: Tensor, edge: float) -> Tensor:
    """Depth behind the nearest body point, metres (equation 5).

    body, body_normals (P, M, 3); edge: mean edge length of the garment, metres. Vertices farther than `TOLERANCE` from
    their simulated place do not count: early in training the constraint would be spurious.
    """
    depth = (EXTENSION * edge - clearance(x, body, body_normals)).clamp(min=0)
    return (depth * ((x - truth).detach().norm(dim=-1) < TOLERANCE)).mean()


#: Vertices whose nearest body point is looked for at once.
SEARCHED = 128


def clearance(x: Tensor, body: Tensor, body_normals: Tensor) -> Tensor:
    """Signed distance of each vertex to the plane of the nearest body point, (P, N), metres."""
    # The least squared distance, by what depends on the point alone. Few rows at a time stay in cache.
    half, across = 0.5 * body.square().sum(-1)[:, None], body.transpose(1, 2)
    near = torch.cat([(part @ across).sub_(half).argmax(-1) for part in x.detach().split(SEARCHED, 1)], 1)
    near = near[..., None].expand(-1, -1, 3)
    return energies.clearance(x, body.gather(1, near), body_normals.gather(1, near))


def face_normals(x: Tensor, triangles: Tensor) -> Tensor:
    """Unit normals of the triangles, (P, F, 3)."""
    a, b, c = (x[:, triangles[:, k]] for k in range(3))
    normal = torch.linalg.cross(b - a, c - a)
    return normal / normal.square().sum(-1, keepdim=True).add(1e-20).sqrt()


def normals(x: Tensor, truth: Tensor, triangles: Tensor) -> Tensor:
    """Mean squared lack of cosine between facet normals (equation 6)."""
    cosine = (face_normals(x, triangles) * face_normals(truth, triangles)).sum(-1)
    return (1 - cosine).square().mean()


def normal_angle(x: Tensor, truth: Tensor, triangles: Tensor) -> Tensor:
    """E_norm: mean angle between facet normals, degrees (equation 18)."""
    a, b = face_normals(x, triangles), face_normals(truth, triangles)
    return torch.rad2deg(torch.atan2(torch.linalg.cross(a, b).norm(dim=-1), (a * b).sum(-1))).mean()


def two_edges_apart(triangles: Ints) -> Ints:
    """Pairs of vertices whose shortest path has two edges, (E2, 2), each once: N2 of equation 7."""
    count = int(triangles.max()) + 1
    a, b, c = triangles.T
    ends = np.concatenate([a, b, c, b, c, a]), np.concatenate([b, c, a, a, b, c])
    one = (coo_matrix((np.ones(len(ends[0])), ends), (count, count)).tocsr() > 0).astype(np.int64)
    two = (one @ one).tocoo()
    apart = (two.row < two.col) & (np.asarray(one[two.row, two.col]).ravel() == 0)
    return np.stack([two.row[apart], two.col[apart]], 1).astype(np.int64)


def bending(x: Tensor, truth: Tensor, pairs: Tensor) -> Tensor:
    """Mean change of the distance between vertices two edges apart, metres (equation 7)."""
    distance = [(y[:, pairs[:, 0]] - y[:, pairs[:, 1]]).square().sum(-1).add(1e-16).sqrt() for y in (x, truth)]
    return (distance[0] - distance[1]).abs().mean()


def neighbourhoods(rest: NDArray[np.floating], count: int) -> Ints:
    """The `count` vertices nearest to each vertex of a rest mesh (N, 3), itself left out: (N, count)."""
    return cKDTree(rest).query(rest, count + 1)[1][:, 1:].astype(np.int64)


def rayleigh(x: Tensor, near: Tensor) -> tuple[Tensor, Tensor]:
    """Least and greatest Rayleigh quotient of each neighbourhood's covariance, (P, N) twice, m2 (equations 10 to 12).

    near (N, K): the neighbourhood of each vertex. They bound the extreme eigenvalues from inside without a
    decomposition, so that flat cloth has gradients.
    """
    around = x[:, near]
    around = around - around.mean(2, keepdim=True)
    covariance = around.transpose(2, 3) @ around / near.shape[1]
    quotient = ((around @ covariance) * around).sum(-1) / around.square().sum(-1).clamp(min=1e-12)
    return quotient.amin(-1), quotient.amax(-1)


def rayleigh_curvature(x: Tensor, truth: Tensor, near: Tensor) -> Tensor:
    """Difference of the curvature statistics, m4 (equation 13)."""
    (low, high), (true_low, true_high) = rayleigh(x, near), rayleigh(truth, near)
    return ((low - true_low).square() + (high - true_high).square()).mean()


def mean_curvature_normal(x: Tensor, triangles: Tensor) -> Tensor:
    """Mean curvature normals, (P, N, 3), 1/m (equation 9), over the mixed areas of Meyer et al. 2003."""
    corners = [x[:, triangles[:, k]] for k in range(3)]
    total, area = torch.zeros_like(x), x.new_zeros(x.shape[:2])
    cotangents, doubled = _cotangents(corners)
    obtuse = torch.stack([c < 0 for c in cotangents]).any(0)
    for k in range(3):
        i, j = triangles[:, (k + 1) % 3], triangles[:, (k + 2) % 3]
        edge = corners[(k + 2) % 3] - corners[(k + 1) % 3]
        pull = cotangents[k][..., None] * edge
        total = total.index_add(1, i, pull).index_add(1, j, -pull)
        voronoi = torch.where(obtuse, 0.0, cotangents[k] * edge.square().sum(-1) / 8)
        area = area.index_add(1, i, voronoi).index_add(1, j, voronoi)
        share = torch.where(cotangents[k] < 0, 0.25, 0.125) * doubled
        area = area.index_add(1, triangles[:, k], torch.where(obtuse, share, 0.0))
    return total / area.clamp(min=1e-9)[..., None]


def _cotangents(corners: list[Tensor]) -> tuple[list[Tensor], Tensor]:
    """Cotangent of the angle at each corner, three times (P, F), and twice the areas, (P, F)."""
    a, b, c = corners
    doubled = torch.linalg.cross(b - a, c - a).square().sum(-1).add(1e-20).sqrt()
    out = []
    for k in range(3):
        here, left, right = corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]
        out.append((((left - here) * (right - here)).sum(-1) / doubled).clamp(-STEEPEST, STEEPEST))
    return out, doubled


def mean_curvature(x: Tensor, truth: Tensor, triangles: Tensor) -> Tensor:
    """Difference of the mean curvature normals, 1/m2 (equation 14)."""
    difference = mean_curvature_normal(x, triangles) - mean_curvature_normal(truth, triangles)
    return difference.square().sum(-1).mean()
