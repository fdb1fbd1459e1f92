"""What training draws from: prepared outfits and a bank of posed bodies."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from copy import copy
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from scipy.spatial import cKDTree
from torch import Tensor

from body.anny_body import AnnyBody, ShapedBody, vertex_normals
from body.humanoid import Rotations, joint_rotations
from body.pose_sampling import DEMANDING, sample_poses
from energies import RestMesh
from garment import features, folds, nearest
from garment.binding import bind, reference_surface
from garment.carry import MARGIN, blend, joint_maps, push_out, smoothed
from garment.graph import build, mesh_edges
from garment.ornaments import ride
from garment.refine import refined
from garment.rest_mesh import rest_mesh, topology
from garment.waistbands import held
from nets.deepsd import Graph, gather_mean, top_four

DATA = Path(__file__).parent / "data"
LAYER_CANDIDATES = 8


@dataclass(frozen=True)
class Sample:
    """One prepared outfit; all on the reference body in rest space."""

    name: str
    vertices: Tensor  # (N, 3)
    tables: tuple[Tensor, Tensor, Tensor]  # edges, hinges, triangles
    features: Tensor  # (M, features)
    prior: Tensor  # (M, 36)
    graph: Graph
    vertex_from_node: Tensor  # (N, 8)
    vertex_from_node_weight: Tensor
    candidates: Tensor  # (N, 16)
    shape_index: Tensor  # (N, 24) body vertices
    shape_weight: Tensor
    distance: Tensor  # (N,) signed distance to the body at rest
    outer: Tensor  # (Q,) vertices that lie over an inner garment
    inner: Tensor  # (Q, 8) vertices of that garment
    layer_gap: Tensor  # (Q,) rest distance to it
    held: Tensor  # (H,) vertices of waistbands

    def at_vertices(self, field: Tensor) -> Tensor:
        """A field of the nodes (M, F) at the vertices (N, F)."""
        return gather_mean(field, self.vertex_from_node, self.vertex_from_node_weight)


def prepare(mesh: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """All tables of an outfit as arrays (see `Sample`), from its vertices, triangles and the garment of each vertex."""
    v, t, garment = (
        mesh["vertices"].astype(np.float64),
        mesh["triangles"].astype(np.int64),
        mesh["garment"].astype(np.int64),
    )
    fine = refined(v, t)
    graph = ride(build(fine.vertices, fine.triangles, garment[fine.origin]).of_first(len(v)), v, t, garment)
    binding = bind(v, graph)
    surface = reference_surface()
    normals = vertex_normals(fine.vertices, fine.triangles)
    out = {"vertices": v, "triangles": t, "prior": binding.prior, "candidates": binding.candidates}
    out["features"] = features.node_features(graph, normals, binding.prior, garment[fine.origin], surface)
    for name in Graph.__dataclass_fields__ | {"vertex_from_node": 0, "vertex_from_node_weight": 0}:
        out[name] = getattr(graph, name)
    shape = binding.shape
    out["shape_index"], out["shape_weight"] = shape.indices.reshape(len(v), -1), shape.data.reshape(len(v), -1)
    hit = cKDTree(surface.vertices).query(v)[1]
    out["distance"] = ((v - surface.vertices[hit]) * surface.normals[hit]).sum(1)
    out["held"] = held(v, t, garment, surface.vertices)
    out["outer"], out["inner"], out["layer_gap"] = layer_tables(v, vertex_normals(v, t), garment)
    return out


def layer_tables(v: np.ndarray, normals: np.ndarray, garment: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices lying over an inner garment (within 8 cm), its nearest vertices there, and the gap along its normal."""
    outer, inner, gap = [], [], []
    for layer in range(1, int(garment.max()) + 1):
        below = np.flatnonzero(garment < layer)
        mine = np.flatnonzero(garment == layer)
        distance, hit = cKDTree(v[below]).query(v[mine], LAYER_CANDIDATES)
        offset = ((v[mine] - v[below[hit[:, 0]]]) * normals[below[hit[:, 0]]]).sum(1)
        keep = (distance[:, 0] < 0.08) & (offset > 0) & (offset > 0.5 * distance[:, 0])
        outer.append(mine[keep])
        inner.append(below[hit[keep]])
        gap.append(offset[keep])
    if not outer:
        return np.zeros(0, np.int64), np.zeros((0, LAYER_CANDIDATES), np.int64), np.zeros(0)
    return np.concatenate(outer), np.concatenate(inner), np.concatenate(gap)


def load_sample(path: Path) -> Sample:
    """A prepared outfit, computed once and kept beside the file."""
    kept = path.with_suffix(".prepared.npz")
    if not kept.exists() or kept.stat().st_mtime < path.stat().st_mtime:
        part = path.with_suffix(f".part{os.getpid()}.npz")
        np.savez(part, **prepare(np.load(path)))
        part.rename(kept)
    return as_sample(path.stem, np.load(kept))


def as_sample(name: str, raw: Mapping[str, np.ndarray]) -> Sample:
    """Prepared tables as tensors."""
    value = {
        k: torch.as_tensor(raw[k].astype(np.float32) if raw[k].dtype.kind == "f" else raw[k].astype(np.int64))
        for k in raw
    }
    graph = Graph(**{name: value.pop(name) for name in Graph.__dataclass_fields__})
    return Sample(name=name, tables=topology(raw["triangles"].astype(np.int64)), graph=graph,
                  **{k: v for k, v in value.items() if k != "triangles"})  # fmt: skip


def load_samples(folder: Path) -> list[Sample]:
    paths = sorted(p for p in folder.glob("*.npz") if p.name.count(".") == 1)
    with ProcessPoolExecutor(2) as pool:
        list(pool.map(_warm, paths, chunksize=8))
    return [load_sample(p) for p in paths]


class OutfitPool:
    """Outfits to draw from; files that appear in the folder while training runs are taken in by `refresh`."""

    def __init__(self, folder: Path, limit: int | None = None) -> None:
        self.folder, self.limit = folder, limit
        self.samples = load_samples(folder)[:limit]
        self._known = {s.name for s in self.samples}

    def refresh(self) -> None:
        """Loads outfits that are new in the folder and already prepared."""
        for kept in sorted(self.folder.glob("*.prepared.npz")):
            name = kept.name.removesuffix(".prepared.npz")
            if name not in self._known and len(self.samples) < (self.limit or 10**9):
                self.samples.append(load_sample(self.folder / f"{name}.npz"))
                self._known.add(name)


@dataclass(frozen=True)
class Target:
    """An outfit relaxed on one body (`relax.py`)."""

    sample: Sample
    entry: int
    poses: Tensor  # (P,)
    x: Tensor  # (P, N, 3) world
    rest: Tensor  # (N, 3) of the outfit on that body
    mesh: RestMesh


class TargetPool:
    """Relaxed outfits; files that appear while training runs are taken in by `refresh`."""

    def __init__(self, folder: Path, outfits: OutfitPool, bank: BodyBank) -> None:
        self.folder, self.bank, self.targets = folder, bank, []
        self._sample = {s.name: s for s in outfits.samples}
        self._known: set[str] = set()
        self.refresh()

    def refresh(self) -> None:
        """Loads results that are new, of outfits and bodies that this run has."""
        for path in sorted(self.folder.glob("*.npz")):
            if path.name in self._known or path.name.count(".") > 1:
                continue
            self._known.add(path.name)
            raw = np.load(path)
            sample, entry = self._sample.get(str(raw["outfit"])), int(raw["entry"])
            poses = torch.as_tensor(raw["poses"])
            if sample is None or not len(poses) or not self._same_bodies(entry, poses, raw["transforms"]):
                continue
            on_body = carry(sample, self.bank, self.bank.entries[entry])
            self.targets.append(Target(sample, entry, poses, torch.as_tensor(raw["x"]), *on_body))

    def _same_bodies(self, entry: int, poses: Tensor, transforms: np.ndarray) -> bool:
        if entry >= len(self.bank.entries) or int(poses.max()) >= len(self.bank.entries[entry].transforms):
            return False
        return np.allclose(self.bank.entries[entry].transforms[poses], transforms, atol=1e-4)


def _warm(path: Path) -> None:
    torch.set_num_threads(1)
    load_sample(path)


@dataclass(frozen=True)
class ShapedPoses:
    """One body shape in many poses."""

    shape: Tensor  # (26,) network input
    apose: Tensor  # (V, 3)
    apose_normals: Tensor  # (V, 3)
    maps: Tensor  # (36, 3, 4) affine map of each joint from the reference body
    missed: Tensor  # (V, 3) what those maps miss of this body
    joints: Tensor  # (36, 3) in the A-pose
    transforms: Tensor  # (P, 36, 3, 4) world from A-pose
    vertices: Tensor  # (P, V, 3)
    normals: Tensor  # (P, V, 3)
    pinched: Tensor  # (P, V) where the body meets itself and leaves cloth no room


#: Phenotypes and local changes by name.
ShapeValues = tuple[dict[str, float], dict[str, float]]
#: Bodies, poses of each, and seed of the bank that networks are trained on.
TRAINING_BANK = (40, 40, 1)


class BodyBank:
    """Random adult shapes, each in random poses. Seeded."""

    def __init__(self, shapes: int, poses: int, seed: int) -> None:
        body = AnnyBody.load()
        self.triangles = torch.as_tensor(body.triangles)
        self.ring = nearest.ring_table(len(body.skin_joints), mesh_edges(body.triangles))
        self.reference = torch.as_tensor(reference_surface().vertices, dtype=torch.float32)
        self.skin = torch.as_tensor(body.garment_skin, dtype=torch.float32)
        parents = body.parents[body.garment_joints]
        self.parents = torch.as_tensor(np.where(parents < 0, -1, body.garment_joint[parents]))
        self.entries = [self.random_entry(body, *one) for one in random_bodies(shapes, poses, seed)]

    @classmethod
    def for_training(cls) -> BodyBank:
        """The bank that training, relaxation and simulation share."""
        return cls(*TRAINING_BANK)

    def to(self, device: str) -> BodyBank:
        """The same with its tables on a device; the bodies stay where they are."""
        out = copy(self)
        for name in ("triangles", "ring", "reference", "skin"):
            setattr(out, name, getattr(self, name).to(device))
        return out

    def random_entry(self, body: AnnyBody, values: ShapeValues, poses: list[Rotations]) -> ShapedPoses:
        shaped = body.shape(*values)
        worlds = [body.world_from_apose(shaped, joint_rotations(body, pose)) for pose in poses]
        return self.entry(body, values, shaped, worlds)

    def entry(self, body: AnnyBody, values: ShapeValues, shaped: ShapedBody, worlds: list[np.ndarray]) -> ShapedPoses:
        """The body shaped by `values` in the poses of given world transforms of all joints."""
        transforms = [body.garment_transforms(shaped, world) for world in worlds]
        vertices = torch.as_tensor(np.stack([body.pose(shaped, world).astype(np.float32) for world in worlds]))
        normals = nearest.vertex_normals(vertices, self.triangles)
        pinched = [folds.pinched(v, n) for v, n in zip(vertices.numpy(), normals.numpy(), strict=True)]
        apose = torch.as_tensor(shaped.apose_vertices, dtype=torch.float32)
        maps = joint_maps(self.reference, apose, self.skin)
        return ShapedPoses(
            shape_vector(body, *values), apose, nearest.vertex_normals(apose[None], self.triangles)[0],
            maps, apose - blend(maps, self.reference, self.skin),
            torch.as_tensor(shaped.joints[body.garment_joints], dtype=torch.float32),
            torch.as_tensor(np.stack(transforms), dtype=torch.float32), vertices,
            normals, torch.as_tensor(np.stack(pinched)),
        )  # fmt: skip


def random_bodies(shapes: int, poses: int, seed: int) -> list[tuple[ShapeValues, list[Rotations]]]:
    """Random adults, each with its random poses, of which every other one is demanding."""
    rng, all_poses = np.random.default_rng(seed), sample_poses(shapes * poses, seed, DEMANDING)
    return [(random_shape(rng, i), all_poses[i * poses : (i + 1) * poses]) for i in range(shapes)]


def random_shape(rng: np.random.Generator, index: int) -> ShapeValues:
    """Phenotypes and local changes of a random adult; the first is the reference body."""
    if index == 0:
        return {}, {}
    body = AnnyBody.load()
    phenotypes = {name: float(rng.uniform(0.05, 0.95)) for name in body.phenotypes if name != "age"}
    phenotypes |= {"age": float(rng.uniform(0.6, 0.9)), "height": float(rng.uniform(0.1, 0.75))}
    local = {name: float(np.clip(rng.normal(0, 0.15), -0.6, 0.6)) for name in body.local_changes}
    return phenotypes, local


def shape_vector(body: AnnyBody, phenotypes: dict[str, float], local: dict[str, float]) -> Tensor:
    """Network input of a shape, (26,), zero for the reference body: phenotypes less their default, doubled; changes."""
    reference = dict.fromkeys(body.phenotypes, 0.5) | {"age": body.meta["reference_age"]}
    first = [2 * (phenotypes.get(p, reference[p]) - reference[p]) for p in body.phenotypes]
    return torch.tensor(first + [local.get(name, 0.0) for name in body.local_changes])


@torch.no_grad()
def carry(sample: Sample, bank: BodyBank, entry: ShapedPoses) -> tuple[Tensor, RestMesh]:
    """The outfit on another body shape, pushed out where the carried cloth would enter the skin: (N, 3), tables."""
    prior = sample.at_vertices(sample.prior)
    weight, joint = top_four(prior)
    kept = torch.zeros_like(prior).scatter(1, joint, weight)
    field = (sample.vertex_from_node, sample.vertex_from_node_weight, sample.graph.near, sample.graph.near_weight)
    followed = (entry.missed[sample.shape_index] * sample.shape_weight[..., None]).sum(1)
    v = blend(entry.maps, sample.vertices, kept) + smoothed(followed, *field)
    skin = (entry.apose, entry.apose_normals)
    v = push_out(v, sample.distance.clamp(0.001, MARGIN), skin, sample.candidates, bank.ring, field)
    return v, rest_mesh(v, sample.tables)


if __name__ == "__main__":  # prepare every outfit beforehand, so that several runs can start together
    for part in ("train", "validation"):
        load_samples(DATA / "outfits" / part)
