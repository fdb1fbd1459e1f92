"""The tailor's measurements, after ISO 8559-1:2017: where each tape lies on the body.

Every tape is laid once, on the reference body at rest, and kept as points of the surface (an edge's two
vertices and how far along it), so that its length is a smooth function of the shape. A ring is a plane
cut of the trunk or of one limb, arms left out; a taut tape bridges hollows, so it keeps the points that
lie on the cut's convex hull on most adults. Landmarks and tapes follow the definitions of ISO 8559-1 as
nearly as a body with arms and legs apart allows. Positions: rest space, metres.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from body.anny_body import AnnyBody

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
UP = np.array([0.0, 1.0, 0.0])
ARM = ("upperarm", "lowerarm", "wrist", "metacarpal", "finger")
LEG = ("upperleg", "lowerleg", "foot", "toe")
TAPE_SPACING = 0.006  # metres between a ring's kept points, about the width of a tape
UNDERBUST_DROP, THIGH_DROP = 0.065, 0.05  # below the bust points and below the crotch, on the reference body
KILOGRAMS_PER_M3 = 980.0  # a body's mean density, lungs half full


@dataclass(frozen=True)
class Points:
    """Points of the surface: vertices[k, 0] * (1 - t[k]) + vertices[k, 1] * t[k]."""

    vertices: Indices  # (P, 2)
    t: Array  # (P,)

    def at(self, positions: Array) -> Array:
        """Their positions, (P, 3), for vertex positions (V, 3)."""
        a, b = positions[self.vertices[:, 0]], positions[self.vertices[:, 1]]
        return a + (b - a) * self.t[:, None]


@dataclass(frozen=True)
class Measurement:
    """One measurement; `low` and `high` are plausible for adults, in cm or kg."""

    name: str
    label: str
    kind: str  # ring: closed tape; polyline: open tape; height: of the first point above the others; weight
    low: float
    high: float
    description: str
    place: Callable[[Reference], Points]


class Reference:
    """Landmarks and plane cuts of the reference body at rest."""

    def __init__(self, body: AnnyBody) -> None:
        self.body, shaped = body, body.shape()
        self.vertices, self.heads = shaped.rest_vertices, shaped.rest_heads
        self.owner = np.array(body.joint_names)[body.dense_skin.argmax(1)]
        self.skin = main_component(body)

    @cached_property
    def edges(self) -> Indices:
        """Edges of the skin, (E, 2)."""
        t = self.body.triangles[self.skin[self.body.triangles[:, 0]]]
        return np.unique(np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), 1), axis=0)

    def joint(self, name: str) -> Array:
        return self.heads[self.body.joint_names.index(name)]

    def part(self, starts: tuple[str, ...], side: str = "") -> NDArray[np.bool_]:
        """Skin vertices that mostly follow joints with these names, (V,)."""
        named = np.array([n.startswith(starts) and n.endswith(side) for n in self.owner])
        return self.skin & named

    def extreme(self, direction: Array, among: NDArray[np.bool_]) -> int:
        """The vertex furthest along a direction."""
        candidates = np.flatnonzero(among)
        return int(candidates[np.argmax(self.vertices[candidates] @ direction)])

    def near(self, point: Array, radius: float) -> NDArray[np.bool_]:
        return self.skin & (np.linalg.norm(self.vertices - point, axis=1) < radius)

    @cached_property
    def crown(self) -> int:
        return self.extreme(UP, self.skin)

    @cached_property
    def soles(self) -> list[int]:
        return [self.extreme(-UP, self.part(("foot", "toe"), side)) for side in (".L", ".R")]

    @cached_property
    def crotch(self) -> int:
        trunk = self.part(("root", "pelvis", "upperleg", "spine"))
        return self.extreme(-UP, trunk & (np.abs(self.vertices[:, 0]) < 0.002))

    @cached_property
    def bust_level(self) -> float:
        """Height of the bust points: the most forward of the chest."""
        chest = self.part(("spine", "breast", "clavicle")) & (np.abs(self.vertices[:, 0]) > 0.04)
        return float(self.vertices[self.extreme(np.array([0.0, 0, 1]), chest), 1])

    @cached_property
    def buttock_level(self) -> float:
        """Height of the greatest prominence of the buttocks."""
        seat = self.part(("root", "pelvis", "upperleg", "spine05"))
        return float(self.vertices[self.extreme(np.array([0.0, 0, -1]), seat), 1])

    @cached_property
    def waist_level(self) -> float:
        """Height of the smallest girth between the ribs and the hip bones."""
        levels = np.arange(self.buttock_level + 0.08, self.bust_level - 0.08, 0.005)
        girths = [hull_length(self.cut([0, y, 0]).at(self.vertices), UP) for y in levels]
        return float(levels[int(np.argmin(girths))])

    def shoulder_point(self, side: str) -> int:
        """The acromion: top of the shoulder over its joint."""
        around = self.vertices - self.joint(f"upperarm01.{side}")
        return self.extreme(UP, self.skin & (np.hypot(around[:, 0], around[:, 2]) < 0.015))

    def elbow_point(self, side: str) -> int:
        """The olecranon: the point of the bent elbow."""
        elbow = self.joint(f"lowerarm01.{side}")
        ends = [self.joint(f"{name}.{side}") - elbow for name in ("upperarm01", "wrist")]
        outwards = -sum(end / np.linalg.norm(end) for end in ends)
        return self.extreme(outwards, self.near(elbow, 0.08))

    def wrist_point(self, side: str) -> int:
        """The prominence of the wrist on the little finger's side."""
        wrist = self.joint(f"wrist.{side}")
        return self.extreme(self.joint(f"finger5-1.{side}") - self.joint(f"finger2-1.{side}"), self.near(wrist, 0.04))

    def cut(self, point: Array | list, normal: Array = UP, part: NDArray[np.bool_] | None = None) -> Points:
        """Cut by a plane, in order around its centre; without the arms unless a part is named."""
        part = self.skin & ~self.part(ARM) if part is None else part
        edges = self.edges[part[self.edges].all(1)]
        above = (self.vertices - np.asarray(point)) @ normal
        a, b = above[edges[:, 0]], above[edges[:, 1]]
        crossing = (a < 0) != (b < 0)
        found = Points(edges[crossing], a[crossing] / (a - b)[crossing])
        flat = in_plane(found.at(self.vertices), normal)
        x, y = (flat - (flat.min(0) + flat.max(0)) / 2).T
        order = np.argsort(np.arctan2(y, x))
        return Points(found.vertices[order], found.t[order])


def main_component(body: AnnyBody) -> NDArray[np.bool_]:
    """The skin without eyes, teeth and tongue: vertices of the largest connected part, (V,)."""
    t, count = body.triangles, len(body.skin_joints)
    pairs = np.concatenate([t[:, [0, 1]], t[:, [1, 2]]])
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (count, count))
    labels = connected_components(graph, directed=False)[1]
    return labels == np.bincount(labels).argmax()


def in_plane(points: Array, normal: Array) -> Array:
    """Coordinates (P, 2) of points (P, 3) in the plane with this normal."""
    across = np.cross(normal, [0.0, 0, 1] if abs(normal[2]) < 0.9 else UP)
    across /= np.linalg.norm(across)
    return np.stack([points @ across, points @ np.cross(normal, across)], 1)


def hull_length(points: Array, normal: Array) -> float:
    """Length of the convex hull of points (P, 3) in the plane with this normal."""
    return float(ConvexHull(in_plane(points, normal)).area)


def taut(ring: Points, reference: Array, adults: list[Array]) -> Points:
    """The points of a ring that a tape touches on at least half of the adults' vertices (V, 3), thinned.

    Each body is seen along the ring's own normal, the direction in which it extends least.
    """
    votes = np.zeros(len(ring.t))
    for vertices in adults:
        at = ring.at(vertices)
        normal = np.linalg.svd(at - at.mean(0))[2][2]
        votes[ConvexHull(in_plane(at, normal)).vertices] += 1
    touched = np.flatnonzero(votes >= len(adults) / 2)
    at = ring.at(reference)
    kept = [touched[0]]
    for k in touched[1:]:
        if min(np.linalg.norm(at[k] - at[kept[-1]]), np.linalg.norm(at[k] - at[kept[0]])) >= TAPE_SPACING:
            kept.append(k)
    return Points(ring.vertices[kept], ring.t[kept])


def landmarks(*vertices: int) -> Points:
    return Points(np.array(vertices, dtype=np.int64)[:, None].repeat(2, 1), np.zeros(len(vertices)))


def neck_ring(r: Reference) -> Points:
    base, top = r.joint("neck01"), r.joint("head")
    neck = r.skin & ~r.part(ARM) & (r.vertices[:, 1] > base[1] - 0.06)
    return r.cut(r.joint("neck02"), (top - base) / np.linalg.norm(top - base), neck)


def thigh_ring(r: Reference) -> Points:
    return r.cut([0, r.vertices[r.crotch, 1] - THIGH_DROP, 0], UP, r.part((*LEG, "pelvis"), ".R"))


def level(height: Callable[[Reference], float]) -> Callable[[Reference], Points]:
    """A horizontal ring around the trunk at a height."""
    return lambda r: r.cut([0, height(r), 0])


def arm_tape(r: Reference) -> Points:
    return landmarks(r.shoulder_point("R"), r.elbow_point("R"), r.wrist_point("R"))


MEASUREMENTS = [
    Measurement("height", "Height", "height", 145, 205, "Crown to soles, barefoot",
                lambda r: landmarks(r.crown, *r.soles)),
    Measurement("weight", "Weight", "weight", 40, 140, "Body mass, from the volume at 980 kg/m3",
                lambda _: landmarks()),
    Measurement("chest", "Chest or bust", "ring", 74, 140,
                "Level girth over the bust points, under the arms", level(lambda r: r.bust_level)),
    Measurement("underbust", "Underbust", "ring", 62, 125, "Level girth just below the breasts",
                level(lambda r: r.bust_level - UNDERBUST_DROP)),
    Measurement("waist", "Waist", "ring", 54, 135, "Level girth at the natural waist",
                level(lambda r: r.waist_level)),
    Measurement("hip", "Hip", "ring", 76, 145, "Level girth over the fullest part of the seat",
                level(lambda r: r.buttock_level)),
    Measurement("inseam", "Inseam", "height", 62, 100, "Crotch to soles, straight down",
                lambda r: landmarks(r.crotch, *r.soles)),
    Measurement("shoulder_width", "Shoulder width", "polyline", 30, 50,
                "Shoulder point to shoulder point, straight",
                lambda r: landmarks(r.shoulder_point("L"), r.shoulder_point("R"))),
    Measurement("arm_length", "Arm length", "polyline", 44, 74,
                "Shoulder point over the bent elbow to the wrist", arm_tape),
    Measurement("neck", "Neck", "ring", 28, 50, "Girth of the mid neck, square to its axis", neck_ring),
    Measurement("thigh", "Thigh", "ring", 40, 85, "Level girth of the thigh, 5 cm under the crotch",
                thigh_ring),
]  # fmt: skip


def tapes(body: AnnyBody, adults: list[Array]) -> list[Points]:
    """The surface points of every measurement, in the order of MEASUREMENTS.

    adults: rest vertices (V, 3) of bodies that the rings should be taut on.
    """
    reference = Reference(body)
    placed = [m.place(reference) for m in MEASUREMENTS]
    return [
        taut(points, reference.vertices, adults) if m.kind == "ring" else points
        for m, points in zip(MEASUREMENTS, placed, strict=True)
    ]
