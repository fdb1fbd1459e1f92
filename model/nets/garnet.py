"""GarNet++ (Gundogdu et al. 2020): a garment draped on any body, seen as points.

Two streams (section 3.2): the body's points after PointNet, the garment's mesh after mesh convolutions (FeaStNet,
Verma et al. 2018), fused into a translation of every node from where dual-quaternion skinning puts it (equation 1).
The variants of section 4.2: `naive` without mesh convolutions, `global` with them, `local` with the features of the
nearest body points as well. World space, metres. P drapes of one garment over M body points.

Beyond the paper, a node also says where it lies in the garment's rest pose, so that a network of few drapes knows which
part of the garment it is, and how skinning turns it: which way is up, and for `local` the way to the body around it,
are told in the frame that turns with the cloth, and the translation is answered in it. So a sleeve need not be learned
anew for every way that an arm points.

The garment's points are the N nodes of its canonical graph (`garment.graph`), not its vertices: an answer then does
not depend on the mesh's resolution, and a fine mesh costs what a coarse one does. Translations are read at vertices.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import torch
from torch import Tensor, nn
from torch.nn import functional

Variant = Literal["naive", "global", "local"]

#: Slope of the leaky rectifiers (section 3.5).
LEAK = 0.1
#: Body points that a garment node pools (section 3.5).
POOLED = 15
#: Points that a thinned body point averages, and how many become one (section 3.5).
AVERAGED, THINNED = 16, 10
#: m, units of the positions that the network sees and of its translations, so that all layers work near one.
LENGTH_UNIT, OFFSET_UNIT = 0.25, 0.03


@dataclass(frozen=True)
class Sizes:
    """Widths of the network; the paper's whole is 512, PointNet's others 64, (512, 256, 128), 1024 and 256."""

    variant: Variant = "local"
    point: int = 32  # features of a point and of a patch
    whole: int = 128  # features of a whole body or garment
    fused: tuple[int, int, int] = (128, 96, 64)  # of the fusion network's first three blocks
    aligner: int = 128  # of the spatial transformers before their maximum
    aligner_head: int = 64
    blocks: int = 6  # residual blocks of mesh convolutions
    steers: int = 2  # weight matrices of a mesh convolution


@dataclass(frozen=True)
class Neighbours:
    """Tables of gathers. Rows are padded with their first entry at weight 0."""

    ring: Tensor  # (N, K) each node and those that touch it
    ring_weight: Tensor  # (N, K) rows sum to 1
    thinned: Tensor  # (M', AVERAGED) body points that each thinned point averages
    pooled: Tensor  # (P, N, POOLED) thinned points nearest to each garment node


def rectified(x: Tensor) -> Tensor:
    return functional.leaky_relu(x, LEAK)


class Shared(nn.Module):
    """An MLP block shared by all points: (..., widths[0]) -> (..., widths[-1])."""

    def __init__(self, *widths: int, last: bool = False) -> None:
        super().__init__()
        self.layers = nn.ModuleList(nn.Linear(a, b) for a, b in pairwise(widths))
        self.last = last  # without a rectifier at the end

    def forward(self, x: Tensor) -> Tensor:
        for i, layer in enumerate(self.layers):
            x = layer(x)
            if not self.last or i + 1 < len(self.layers):
                x = rectified(x)
        return x


class SpatialTransformer(nn.Module):
    """PointNet's alignment of points by a matrix that they predict themselves, the identity at first."""

    def __init__(self, width: int, sizes: Sizes) -> None:
        super().__init__()
        self.width = width
        self.points = Shared(width, sizes.point, sizes.aligner)
        self.head = Shared(sizes.aligner, sizes.aligner_head, width * width, last=True)
        nn.init.zeros_(self.head.layers[-1].weight)
        nn.init.zeros_(self.head.layers[-1].bias)

    def forward(self, x: Tensor) -> Tensor:
        """(P, M, width) -> the same, aligned."""
        turn = self.head(self.points(x).amax(1)).unflatten(1, (self.width, self.width))
        return x @ (turn + torch.eye(self.width, device=x.device))


class BodyStream(nn.Module):
    """Point-wise and global features of the body: (P, M, 3) -> (P, M, point), (P, whole)."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.align = SpatialTransformer(3, sizes)
        self.first = Shared(3, sizes.point, sizes.point)
        self.align_features = SpatialTransformer(sizes.point, sizes)
        # The first transformer's output skips to the second block, or all points end up alike (section 3.5).
        self.second = Shared(sizes.point + 3, sizes.point)
        self.whole = Shared(sizes.point, sizes.whole)

    def forward(self, points: Tensor) -> tuple[Tensor, Tensor]:
        aligned = self.align(points)
        h = self.align_features(self.first(aligned))
        h = self.second(torch.cat([h, aligned], -1))
        return h, self.whole(h).amax(1)


class MeshConvolution(nn.Module):
    """Feature-steered convolution over one-ring neighbours (FeaStNet): (P, N, inlet) -> (P, N, outlet).

    Each neighbour's features go through weight matrices in shares that depend on both ends' features.
    """

    def __init__(self, inlet: int, outlet: int, steers: int) -> None:
        super().__init__()
        self.steer = nn.Linear(inlet, steers, bias=False)
        self.lean = nn.Parameter(torch.zeros(steers))
        self.weight = nn.Linear(steers * inlet, outlet)

    def forward(self, x: Tensor, near: Neighbours) -> Tensor:
        steer = self.steer(x)
        # Softmax of u . (x_i - x_j) + c, which does not change where the garment moves as a whole.
        share = torch.softmax(steer[:, :, None] - steer[:, near.ring] + self.lean, -1) * near.ring_weight[..., None]
        mixed = share.transpose(2, 3) @ x[:, near.ring]
        return self.weight(mixed.flatten(2))


class Residual(nn.Module):
    """Two mesh convolutions beside a skip; the positions enter both (section 3.5)."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.one, self.two = (MeshConvolution(sizes.point + 3, sizes.point, sizes.steers) for _ in range(2))
        # A block begins as its skip, so that six of them train.
        nn.init.zeros_(self.two.weight.weight)
        nn.init.zeros_(self.two.weight.bias)

    def forward(self, h: Tensor, positions: Tensor, near: Neighbours) -> Tensor:
        out = rectified(self.one(torch.cat([h, positions], -1), near))
        return rectified(h + self.two(torch.cat([out, positions], -1), near))


class GarmentStream(nn.Module):
    """Point-wise, patch-wise and global features of the warped garment, together: (P, N, 9) -> (P, N, `width`)."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.align = SpatialTransformer(3, sizes)
        self.points = Shared(9, sizes.point, sizes.point)
        self.meet = Shared(sizes.point + sizes.whole, sizes.point)
        blocks = 0 if sizes.variant == "naive" else sizes.blocks
        self.patches = nn.ModuleList(Residual(sizes) for _ in range(blocks))
        if not blocks:
            self.plain = Shared(sizes.point, sizes.point)
        self.whole = Shared(sizes.point, sizes.whole)
        self.width = 9 + 2 * sizes.point + sizes.whole

    def forward(self, garment: Tensor, body: Tensor, near: Neighbours) -> Tensor:
        """body (P, whole): global features of the body, repeated for each node."""
        count, (warped, own) = garment.shape[1], garment.split((3, 6), -1)
        point = self.points(torch.cat([self.align(warped), own], -1))
        # Convolutions of the body's features, alike at every node, would be most of the work: they are mixed in before.
        h = self.meet(torch.cat([point, body[:, None].expand(-1, count, -1)], -1))
        for block in self.patches:
            h = block(h, warped, near)
        if not self.patches:
            h = self.plain(h)
        whole = self.whole(h).amax(1)
        return torch.cat([garment, point, h, whole[:, None].expand(-1, count, -1)], -1)


class GarNet(nn.Module):
    """Warped garment and body points to translations of the garment's nodes."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.sizes = sizes
        self.body, self.garment = BodyStream(sizes), GarmentStream(sizes)
        local = sizes.point + 6 if sizes.variant == "local" else 0
        self.fusion = Shared(self.garment.width + sizes.whole + local, *sizes.fused, 3, last=True)
        nn.init.zeros_(self.fusion.layers[-1].weight)
        nn.init.zeros_(self.fusion.layers[-1].bias)

    def forward(self, garment: Tensor, turn: Tensor, body: Tensor, near: Neighbours) -> Tensor:
        """Metres: garment (P, N, 6), turn (P, N, 3, 3), body (P, M, 3) -> translations (P, N, 3).

        A node is where it is warped to, less the origin that the body's points have too, and where it is at rest.
        `turn` is what skinning turns it by, world from rest.
        """
        # The world's up, y, in the frame of the node: a row of the world from rest is a column of its inverse.
        garment = torch.cat([garment / LENGTH_UNIT, turn[..., 1, :]], -1)
        body = body / LENGTH_UNIT
        points, whole = self.body(body)
        parts = [self.garment(garment, whole, near), whole[:, None].expand(-1, garment.shape[1], -1)]
        if self.sizes.variant == "local":
            parts += [pooled(points, near), way_to_body(garment[..., :3], turn, body, near)]
        return (turn @ self.fusion(torch.cat(parts, -1))[..., None])[..., 0] * OFFSET_UNIT


def around(points: Tensor, near: Neighbours) -> Tensor:
    """Thinned values of body points (P, M, F) around each garment node, nearest first, (P, N, POOLED, F)."""
    thin = points[:, near.thinned].mean(2)
    drapes = torch.arange(thin.shape[0], device=thin.device)[:, None, None]
    return thin[drapes, near.pooled]


def pooled(points: Tensor, near: Neighbours) -> Tensor:
    """Largest features among the body points around each garment node, (P, N, point) (Figure 5)."""
    return around(points, near).amax(2)


def way_to_body(warped: Tensor, turn: Tensor, body: Tensor, near: Neighbours) -> Tensor:
    """From each node (P, N, 3) to the nearest thinned body point and to the middle of those around it, (P, N, 6).

    In the frame of the node.
    """
    points = around(body, near)
    ways = torch.stack([points[:, :, 0], points.mean(2)], 2) - warped[:, :, None]
    return (ways @ turn).flatten(2)
