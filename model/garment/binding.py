"""How an outfit holds on to the body: limbs, prior weights, collision candidates, other body shapes.

All in `rest` space on the reference body, metres. The server computes the same tables
(`toile-drape/src/binding.rs`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.spatial import cKDTree

from body.anny_body import AnnyBody, vertex_normals
from garment.graph import OutfitGraph

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Which part of the body a cloth vertex may touch: its own limb, never the arm beside it.
TRUNK, ARM_LEFT, ARM_RIGHT, LEG_LEFT, LEG_RIGHT = range(5)
ARM_PARTS = ("upperarm01", "upperarm02", "lowerarm01", "lowerarm02", "wrist")
LEG_PARTS = ("upperleg01", "upperleg02", "lowerleg01", "lowerleg02", "foot")
CANDIDATES = 16
CANDIDATE_POOL = 160
SHAPE_SUPPORTS = 24
PRIOR_ROUNDS = 80


@dataclass(frozen=True)
class BodySurface:
    """The reference body as the binding sees it."""

    vertices: Floats  # (V, 3)
    normals: Floats  # (V, 3)
    skin: Floats  # (V, 36)
    touches: list[NDArray[np.bool_]]  # per limb, (V,) body vertices that its cloth may touch
    arm: Floats  # (V, 2) weight of the left, right arm
    leg: Floats  # (V, 2)


def limb_weights(skin: Floats, names: list[str], parts: tuple[str, ...]) -> Floats:
    """Total weight of a limb's joints, left and right, (N, 2)."""
    return np.stack([skin[:, [names.index(f"{p}.{s}") for p in parts]].sum(1) for s in "LR"], 1)


@lru_cache(1)
def reference_surface() -> BodySurface:
    body = AnnyBody.load()
    vertices = body.shape().apose_vertices
    skin = body.garment_skin
    names = [body.joint_names[j] for j in body.garment_joints]
    arm, leg = limb_weights(skin, names, ARM_PARTS), limb_weights(skin, names, LEG_PARTS)
    hand = limb_weights(skin, names, ("wrist",)).sum(1) > 0.5
    no_arm = arm.sum(1) < 0.6
    shoulder = limb_weights(skin, names, ("clavicle", "shoulder01")) > 0.15
    touches = [no_arm]
    touches += [((arm[:, s] > 0.15) | (shoulder[:, s] & no_arm)) & ~hand for s in range(2)]
    touches += [no_arm & (leg[:, 1 - s] < 0.5) for s in range(2)]
    return BodySurface(vertices, vertex_normals(vertices, body.triangles), skin, touches, arm, leg)


@dataclass(frozen=True)
class Binding:
    """Tables of one outfit."""

    prior: Floats  # (M, 36) diffused skin weights of the nodes
    limb: Ints  # (N,) limb of each vertex
    candidates: Ints  # (N, CANDIDATES) body vertices to test for collisions
    shape: csr_matrix  # (N, V) displacement of a vertex from displacements of the body's


def node_prior(graph: OutfitGraph, surface: BodySurface) -> Floats:
    """Skin weights of the nearest body vertex, diffused over the graph where cloth is far from the skin.

    DeePSD §6 takes the nearest vertex and smooths; nearest alone tears skirts. (M, 36)
    """
    allowed = np.flatnonzero(~hands_and_head(surface))
    distance, hit = cKDTree(surface.vertices[allowed]).query(graph.nodes.positions)
    start = surface.skin[allowed[hit]]
    hold = np.exp(-((distance / 0.02) ** 2))[:, None] * 0.5 + 0.004
    weights = start.copy()
    for _ in range(PRIOR_ROUNDS):
        around = np.einsum("mk,mkj->mj", graph.near_weight, weights[graph.near])
        around = np.where(graph.near_weight.sum(1, keepdims=True) > 0, around, weights)
        weights = (hold * start + around) / (hold + 1)
    return weights / weights.sum(1, keepdims=True)


def hands_and_head(surface: BodySurface) -> NDArray[np.bool_]:
    """Body vertices that never carry cloth: fingers. (V,)"""
    names = garment_joint_names()
    return surface.skin[:, [names.index("wrist.L"), names.index("wrist.R")]].sum(1) > 0.95


def garment_joint_names() -> list[str]:
    body = AnnyBody.load()
    return [body.joint_names[j] for j in body.garment_joints]


def vertex_limbs(prior: Floats) -> Ints:
    """Limb of each vertex from its diffused weights (N, 36): an arm above one half, a leg when clear of the other."""
    names = garment_joint_names()
    arm, leg = limb_weights(prior, names, ARM_PARTS), limb_weights(prior, names, LEG_PARTS)
    limb = np.zeros(len(prior), dtype=np.int64)
    for side in range(2):
        limb[(leg[:, side] > 0.3) & (leg[:, 1 - side] < 0.02)] = LEG_LEFT + side
        limb[arm[:, side] > 0.5] = ARM_LEFT + side
    return limb


def collision_candidates(vertices: Floats, limb: Ints, surface: BodySurface) -> Ints:
    """Body vertices spread around each vertex: every tenth of the nearest ones that its limb may touch, (N, K)."""
    out = np.zeros((len(vertices), CANDIDATES), dtype=np.int64)
    stride = CANDIDATE_POOL // CANDIDATES
    for code, touch in enumerate(surface.touches):
        mine = np.flatnonzero(limb == code)
        if len(mine):
            allowed = np.flatnonzero(touch)
            hit = cKDTree(surface.vertices[allowed]).query(vertices[mine], CANDIDATE_POOL)[1]
            out[mine] = allowed[hit[:, ::stride]]
    return out


def shape_binding(vertices: Floats, limb: Ints, surface: BodySurface) -> csr_matrix:
    """Gaussian average of the body's displacements around each vertex, wider the farther it hangs, (N, V)."""
    rows, cols, values = [], [], []
    for code, touch in enumerate(surface.touches):
        mine = np.flatnonzero(limb == code)
        if len(mine):
            allowed = np.flatnonzero(touch)
            distance, hit = cKDTree(surface.vertices[allowed]).query(vertices[mine], SHAPE_SUPPORTS * 3)
            distance, hit = distance[:, ::3], hit[:, ::3]
            spread = np.maximum(0.02, 0.5 * distance[:, :1])
            weight = np.exp(-0.5 * ((distance - distance[:, :1]) / spread) ** 2)
            rows.append(mine.repeat(SHAPE_SUPPORTS))
            cols.append(allowed[hit].ravel())
            values.append((weight / weight.sum(1, keepdims=True)).ravel())
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(cols)))
    return coo_matrix(entries, (len(vertices), len(surface.vertices))).tocsr()


def bind(vertices: Floats, graph: OutfitGraph) -> Binding:
    """All tables of an outfit in rest pose on the reference body. vertices (N, 3)."""
    surface = reference_surface()
    prior = node_prior(graph, surface)
    vertex_prior = np.einsum("nk,nkj->nj", graph.vertex_from_node_weight, prior[graph.vertex_from_node])
    limb = vertex_limbs(vertex_prior)
    return Binding(prior, limb, collision_candidates(vertices, limb, surface), shape_binding(vertices, limb, surface))
