"""What pixel cloth learns from the drapes of `pixel_data`: poses, places and frames of its pixels, offsets in them."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
import torch
from torch import Tensor

from body.anny_body import AnnyBody
from devices import on
from garment import nearest
from garment.binding import reference_surface
from garment.cloth_image import SIZE, Panel, cloth_images
from garment.embedding import worn_tight
from garment.local_frames import Frames, frames
from nets.pixel_cloth import in_images, vertices
from outfits.body_fields import body_fields
from outfits.mesh import GarmentMesh
from outfits.panels import front_and_back, patches
from pixel_data import Drapes
from pixel_poses import JOINTS, pose_matrices
from training_data import Sample

#: The body under the cloth: as it was draped on, or wrong on purpose (section 8.2).
Carrier = Literal["reference", "thin", "thick", "lagging", "rigid"]
#: Joints whose turns a network sees, each against another or the world.
Joints = tuple[tuple[str | None, str], ...]
#: m that a wrong body's skin lies off the true one.
WRONG = {"thin": -0.015, "thick": 0.015}
#: Share of every weight that lies on the joint's parent.
LAG = 0.3
#: Pixels of a patch's side.
PATCH_SIZE = 64
#: Drapes whose frames are made at once.
BATCH = 64


@dataclass(frozen=True)
class Garment:
    """Tables of one garment: Q sites of N vertices in M pixels, as of `ClothImages` and `Frames`."""

    triangles: Tensor  # (F, 3)
    frames: Frames
    vertex: Tensor  # (Q,)
    share: Tensor  # (Q,)
    pixel: Tensor  # (M,)
    site_of_pixel: Tensor  # (M, 3)
    site_weight: Tensor  # (M, 3)
    pixel_of_site: Tensor  # (Q, 4)
    pixel_weight: Tensor  # (Q, 4)
    images: int
    side: int  # pixels of an image's
    joints: Joints = JOINTS  # that the network sees

    @classmethod
    def of(cls, sample: Sample, patched: bool = False) -> Garment:
        """A top cut into front and back, or these into patches with smaller images."""
        v, t, body = sample.vertices.double().numpy(), sample.tables[2].numpy(), AnnyBody.load()
        mesh, shape = GarmentMesh("tee", "tee", 0, v, t), body_fields(body, body.shape())
        panels: list[Panel] = list(front_and_back(mesh, shape))
        return cls.laid(sample, patches(panels, mesh, shape), PATCH_SIZE) if patched else cls.laid(sample, panels)

    @classmethod
    def laid(cls, sample: Sample, panels: list[Panel], side: int = SIZE, joints: Joints = JOINTS) -> Garment:
        """Any garment, by its panels."""
        v, t = sample.vertices.double().numpy(), sample.tables[2].numpy()
        images = cloth_images(panels, len(v), side)
        names = ("vertex", "share", "pixel", "site_of_pixel", "site_weight", "pixel_of_site", "pixel_weight")
        tables = {name: torch.as_tensor(getattr(images, name)) for name in names}
        tables = {name: x.float() if x.is_floating_point() else x for name, x in tables.items()}
        held = frames(panels, worn_tight(v, t))
        return cls(sample.tables[2], held, images=len(panels), side=side, joints=joints, **tables)


@dataclass(frozen=True)
class Scenes:
    """D drapes of one garment."""

    pose: Tensor  # (D, 9 J)
    places: Tensor  # (D, Q, 3) of the sites on the body
    axes: Tensor  # (D, Q, 3, 3)
    offsets: Tensor  # (D, Q, 3) of the cloth from there, in `axes`
    truth: Tensor  # (D, N, 3) world

    def __len__(self) -> int:
        return len(self.pose)

    def pick(self, rows: Tensor) -> Scenes:
        return Scenes(*(getattr(self, f.name)[rows] for f in fields(self)))


@torch.no_grad()
def scenes(garment: Garment, drapes: Drapes, carrier: Carrier, device: str = "cpu") -> Scenes:
    """Drapes on a device, with frames on a body that skins to their poses."""
    rest, skin = (torch.as_tensor(x, dtype=torch.float32) for x in _carrier(carrier))
    triangles = torch.as_tensor(AnnyBody.load().triangles)
    garment, drapes, rest, skin, triangles = on((garment, drapes, rest, skin, triangles), device)
    parts = []
    for rows in torch.arange(len(drapes.x), device=device).split(BATCH):
        moved = (skin @ drapes.transforms[rows].flatten(2)).unflatten(2, (3, 4))
        body = (moved[..., :3] @ rest[..., None])[..., 0] + moved[..., 3]
        parts.append(
            on_body(garment, drapes.transforms[rows], body, nearest.vertex_normals(body, triangles), drapes.x[rows])
        )
    return Scenes(*(torch.cat([getattr(part, f.name) for part in parts]) for f in fields(Scenes)))


def on_body(garment: Garment, transforms: Tensor, body: Tensor, normals: Tensor, x: Tensor) -> Scenes:
    """Drapes x (P, N, 3) on any body: its joints' transforms (P, 36, 3, 4), its vertices and normals (P, V, 3)."""
    places, axes = garment.frames.places(body), garment.frames.axes(body, normals)
    offsets = (axes.transpose(-2, -1) @ (x[:, garment.vertex] - places)[..., None])[..., 0]
    return Scenes(pose_matrices(transforms, garment.joints), places, axes, offsets, x)


def _carrier(carrier: Carrier) -> tuple[np.ndarray, np.ndarray]:
    """A body (V, 3) in the A-pose and its skin weights (V, 36)."""
    surface = reference_surface()
    rest, skin = surface.vertices, surface.skin
    if carrier == "rigid":
        return rest, np.eye(skin.shape[1])[skin.argmax(1)]
    if carrier == "lagging":
        return rest, (1 - LAG) * skin + LAG * skin @ _to_parents()
    return rest + WRONG.get(carrier, 0.0) * surface.normals, skin


def _to_parents() -> np.ndarray:
    """Which garment joint is the parent of each, (36, 36); the root is its own."""
    body = AnnyBody.load()
    parents = body.parents[body.garment_joints]
    return np.eye(len(parents))[np.where(parents < 0, 0, body.garment_joint[parents])]


def draped(offsets: Tensor, garment: Garment, s: Scenes) -> Tensor:
    """Cloth (D, N, 3) world from offsets of the sites, (D, Q, 3)."""
    return vertices(offsets, s.places, s.axes, garment.vertex, garment.share)


def pixels(garment: Garment, s: Scenes) -> Tensor:
    """What the images of drapes say, (D, M, 3)."""
    return in_images(s.offsets, garment.site_of_pixel, garment.site_weight)


def mask(garment: Garment, side: int) -> Tensor:
    """Where the images have cloth or its padding, (K, side, side)."""
    out = torch.zeros(garment.images * side * side, dtype=torch.bool)
    out[garment.pixel] = True
    return out.unflatten(0, (garment.images, side, side))
