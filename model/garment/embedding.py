"""Cloth wrapped tight on the body and held by its triangles (Jin et al. 2020, section 5). Rest space, metres.

A vertex starts at the skin nearest to it that its limb may touch; then cloth evens out along the skin. As the body
moves the places move with its triangles, whatever the way it is skinned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody
from garment.binding import LEG_LEFT, LEG_RIGHT, TRUNK, bind, reference_surface
from garment.graph import build, mesh_edges, open_sides
from garment.refine import refined

Floats = NDArray[np.floating]
Ints = NDArray[np.integer]

#: Rounds of evening out, share of the way to the neighbours' middle in each, and body vertices looked around.
ROUNDS, SHARE, LOOKED = 40, 0.5, 3
#: m below the hips from which a garment moves with the legs.
REACH = 0.12
#: m by which one leg is nearer than the other where cloth over both lies on the nearer alone.
BETWEEN = 0.1


@dataclass(frozen=True)
class Embedding:
    """Where N vertices of cloth lie on a body: each in K = 3 corners of a triangle, or of K / 3 that share it."""

    corners: Ints  # (N, K) body vertices
    weight: Floats  # (N, K) barycentric, rows sum to 1

    def places(self, body: Floats) -> Floats:
        """On a body (V, 3) in any pose, (N, 3)."""
        return (self.weight[..., None] * body[self.corners]).sum(1)

    def normals(self, normals: Floats) -> Floats:
        """Unit normals of the skin there (N, 3), from those of its vertices (V, 3)."""
        mixed = (self.weight[..., None] * normals[self.corners]).sum(1)
        return mixed / np.linalg.norm(mixed, axis=1, keepdims=True)


class Skin:
    """The body as cloth of each limb may touch it."""

    def __init__(self, vertices: Floats, triangles: Ints, touches: list[NDArray[np.bool_]]) -> None:
        self.vertices = vertices
        self.limbs = [_Patch(vertices, triangles[touch[triangles].all(1)]) for touch in touches]

    def nearest(self, points: Floats, limb: Ints) -> Embedding:
        """The nearest places to points (N, 3) of cloth whose limbs (N,) index `touches`."""
        corners, weight = np.zeros((len(points), 3), np.int64), np.zeros((len(points), 3))
        for code in np.unique(limb):
            mine = limb == code
            corners[mine], weight[mine] = self.limbs[code].nearest(points[mine])
        return Embedding(corners, weight)


class _Patch:
    """Some triangles of the skin."""

    def __init__(self, vertices: Floats, triangles: Ints) -> None:
        self.vertices, self.triangles = vertices, triangles
        self.used = np.unique(triangles)
        self.tree = cKDTree(vertices[self.used])
        order = np.argsort(triangles.ravel(), kind="stable")
        owners, first = np.unique(triangles.ravel()[order], return_index=True)
        widest = int(np.diff(np.append(first, order.size)).max())
        self.around = np.full((len(vertices), widest), -1)
        for owner, mine in zip(owners, np.split(order // 3, first[1:]), strict=True):
            self.around[owner, : len(mine)] = mine

    def nearest(self, points: Floats) -> tuple[Ints, Floats]:
        """Corners and weights (N, 3) of the nearest places, among the triangles around the nearest vertices."""
        seen = self.used[self.tree.query(points, LOOKED)[1]]
        choice = self.around[seen].reshape(len(points), -1)
        corners = self.vertices[self.triangles[choice]]
        weight = closest(points[:, None].repeat(choice.shape[1], 1).reshape(-1, 3), corners.reshape(-1, 3, 3))
        weight = weight.reshape(*choice.shape, 3)
        away = np.linalg.norm((weight[..., None] * corners).sum(2) - points[:, None], axis=-1)
        best = np.where(choice < 0, np.inf, away).argmin(1)
        rows = np.arange(len(points))
        return self.triangles[choice[rows, best]], weight[rows, best]


def closest(points: Floats, corners: Floats) -> Floats:
    """Barycentric weights (M, 3) of the point of each triangle (M, 3, 3) that is nearest to each point (M, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    area = np.maximum((normal**2).sum(1), 1e-30)
    inner = np.stack([(np.cross(q - p, points - p) * normal).sum(1) / area for p, q in ((b, c), (c, a), (a, b))], 1)
    best, least = inner, np.where((inner >= 0).all(1), 0.0, np.inf)
    for k, (p, q) in enumerate(((a, b), (b, c), (c, a))):
        along = q - p
        t = np.clip(((points - p) * along).sum(1) / np.maximum((along**2).sum(1), 1e-30), 0, 1)
        away = ((p + t[:, None] * along - points) ** 2).sum(1)
        weight = np.zeros_like(inner)
        weight[:, k], weight[:, (k + 1) % 3] = 1 - t, t
        nearer = away < least
        best = np.where(nearer[:, None], weight, best)
        least = np.where(nearer, away, least)
    return best


def worn_tight(vertices: Floats, triangles: Ints) -> Embedding:
    """A garment (N, 3), as it is drawn on the reference body, tight on that body.

    Cloth that hangs over both legs lies on both: carried by the nearer one alone, it would part between them.
    """
    fine, surface = refined(vertices, triangles), reference_surface()
    graph = build(fine.vertices, fine.triangles, np.zeros(len(fine.vertices), np.int64))
    limb = bind(fine.vertices, graph).limb[: len(vertices)]
    skin = Skin(surface.vertices, AnnyBody.load().triangles, surface.touches)
    is_shared = limb == TRUNK
    if not vertices[is_shared, 1].min(initial=np.inf) < hips() - REACH:
        return wrapped(vertices, triangles, limb, skin)
    left, right = (wrapped(vertices, triangles, np.where(is_shared, leg, limb), skin) for leg in (LEG_LEFT, LEG_RIGHT))
    share = _of_the_right(vertices, skin)[:, None]
    return Embedding(
        np.concatenate([left.corners, right.corners], 1),
        np.concatenate([(1 - share) * left.weight, share * right.weight], 1),
    )


def _of_the_right(vertices: Floats, skin: Skin) -> Floats:
    """Share of the right leg in carrying cloth (N, 3) that hangs over both, (N,)."""
    on_leg = (skin.nearest(vertices, np.full(len(vertices), leg)) for leg in (LEG_LEFT, LEG_RIGHT))
    left, right = (np.linalg.norm(found.places(skin.vertices) - vertices, axis=1) for found in on_leg)
    return np.clip(0.5 + (left - right) / (2 * BETWEEN), 0, 1)


def hips() -> float:
    """Height of the reference body's hip joints, m."""
    body = AnnyBody.load()
    return float(body.shape().joints[body.joint_names.index("upperleg01.L"), 1])


def wrapped(vertices: Floats, triangles: Ints, limb: Ints, skin: Skin) -> Embedding:
    """Cloth (N, 3) tight on the skin. limb (N,): which part of the body each vertex may touch."""
    found = skin.nearest(vertices, limb)
    middle = _neighbours(vertices, triangles)
    for _ in range(ROUNDS):
        places = found.places(skin.vertices)
        found = skin.nearest(places + SHARE * (middle @ places - places), limb)
    return found


def _neighbours(vertices: Floats, triangles: Ints) -> csr_matrix:
    """Middle of each vertex's neighbours, nearer ones counting for more; those of a rim are on the rim, (N, N)."""
    edges, rim = mesh_edges(triangles), open_sides(triangles)[0]
    both, along_rim = (np.concatenate([e, e[:, ::-1]]) for e in (edges, rim))
    both = np.concatenate([both[~np.isin(both[:, 0], rim)], along_rim])
    weight = 1 / np.linalg.norm(vertices[both[:, 0]] - vertices[both[:, 1]], axis=1)
    out = coo_matrix((weight, both.T), (len(vertices), len(vertices))).tocsr()
    return diags(1 / np.asarray(out.sum(1)).ravel()) @ out
