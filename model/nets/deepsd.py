"""DeePSD (Bertiche et al. 2021) with a static pose-space-deformation basis.

Equation 4 of the paper, t' = sum_k w_k(phi) G_k (t + psi(phi, theta)), in two forms of psi:
`basis`   psi = B(phi) c(theta, beta): B is static, (3, R) a vertex; c is a tiny network (shipped default);
`concat`  psi = MLP([phi, theta, beta]) on every vertex, as printed (section 4.2.2), for comparison.

Phi runs on the canonical graph (`garment.graph`), so resolution and triangulation do not matter.
Spaces: features and basis in `rest`, metres. F descriptors, R basis vectors, J = 36 garment joints.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional

JOINTS = 36
SHAPE = 26
POSE = JOINTS * 12
#: Offsets are predicted in this unit, so that the heads work near one.
OFFSET_UNIT = 0.03
#: Where the features have the distance to the skin, decimetres, and the distance (m) from which offsets are free: cloth
#: on the skin moves with it, also where an outfit is unlike those of training.
DISTANCE, FREE = 9, 0.008

torch.sparse.check_sparse_tensor_invariants.disable()
warnings.filterwarnings("ignore", message="Sparse CSR tensor support is in beta")


@dataclass(frozen=True)
class Sizes:
    """Widths of the networks."""

    features: int = 62
    width: int = 192
    layers: int = 4
    basis: int = 64
    pose_width: int = 256


@dataclass(frozen=True)
class Graph:
    """Index tables of one outfit as tensors; see `garment.graph.OutfitGraph` for shapes."""

    near: Tensor
    near_weight: Tensor
    members: Tensor
    members_weight: Tensor
    patch_near: Tensor
    patch_near_weight: Tensor
    node_from_patch: Tensor
    node_from_patch_weight: Tensor


def gather_mean(values: Tensor, index: Tensor, weight: Tensor) -> Tensor:
    """Weighted rows: out[i] = sum_k weight[i, k] values[index[i, k]]. values (M, F) -> (N, F)."""
    if torch.is_grad_enabled():
        with torch.autocast("cpu", enabled=False):  # sparse products have no half precision
            return WeightedRows.apply(values.float(), index, weight)
    rows = values.index_select(0, index.reshape(-1)).reshape(*index.shape, values.shape[1])
    return torch.bmm(weight.unsqueeze(1), rows).squeeze(1)


class WeightedRows(torch.autograd.Function):
    """`gather_mean` as products with a sparse matrix, for training; the plain form is what gets exported."""

    @staticmethod
    def forward(ctx: Any, values: Tensor, index: Tensor, weight: Tensor) -> Tensor:  # noqa: ANN401
        ctx.index, ctx.weight, ctx.count = index, weight, len(values)
        ends = torch.arange(0, index.numel() + 1, index.shape[1])
        return _rows(ends, index.reshape(-1), weight.reshape(-1), len(values)) @ values

    @staticmethod
    def backward(ctx: Any, slope: Tensor) -> tuple[Tensor, None, None]:  # noqa: ANN401
        """The transposed product, its rows by a sort; `index_add`, the gather's own gradient, is far slower."""
        flat = ctx.index.reshape(-1)
        order = flat.argsort()
        ends = torch.cat([flat.new_zeros(1), flat.bincount(minlength=ctx.count).cumsum(0)])
        rows = _rows(ends, order // ctx.index.shape[1], ctx.weight.reshape(-1)[order], len(slope))
        return rows @ slope, None, None


def _rows(ends: Tensor, columns: Tensor, values: Tensor, width: int) -> Tensor:
    """Compressed sparse rows, (len(ends) - 1, width)."""
    return torch.sparse_csr_tensor(ends, columns, values, (len(ends) - 1, width))


class GraphConvolution(nn.Module):
    """One layer of Phi: own features, the mean of the neighbours, and the patch around the node."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.own = nn.Linear(width, width)
        self.near = nn.Linear(width, width, bias=False)
        self.pooled = nn.Linear(width, width)
        self.around = nn.Linear(width, width, bias=False)
        self.patch = nn.Linear(width, width, bias=False)
        self.norm = nn.LayerNorm(width)

    def forward(self, h: Tensor, g: Graph) -> Tensor:
        pooled = gather_mean(h, g.members, g.members_weight)
        patch = functional.relu(
            self.pooled(pooled) + self.around(gather_mean(pooled, g.patch_near, g.patch_near_weight))
        )
        update = self.own(h) + self.near(gather_mean(h, g.near, g.near_weight))
        update = update + gather_mean(self.patch(patch), g.node_from_patch, g.node_from_patch_weight)
        return h + functional.relu(self.norm(update))


class StaticPass(nn.Module):
    """Phi, Omega and the basis form of Psi: once per outfit."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.sizes = sizes
        self.inlet = nn.Linear(sizes.features, sizes.width)
        self.phi = nn.ModuleList(GraphConvolution(sizes.width) for _ in range(sizes.layers))
        self.omega = nn.Sequential(nn.Linear(sizes.width, 128), nn.ReLU(), nn.Linear(128, JOINTS))
        self.psi = nn.Sequential(nn.Linear(sizes.width, 256), nn.ReLU(), nn.Linear(256, 3 * sizes.basis))
        nn.init.zeros_(self.omega[2].weight)
        nn.init.zeros_(self.omega[2].bias)
        nn.init.normal_(self.psi[2].weight, std=0.02)

    def descriptors(self, features: Tensor, g: Graph) -> Tensor:
        """Phi (equation 5): (M, features) -> (M, width)."""
        h = functional.relu(self.inlet(features))
        for layer in self.phi:
            h = layer(h, g)
        return h

    def forward(self, features: Tensor, prior: Tensor, g: Graph) -> tuple[Tensor, Tensor, Tensor]:
        """Skin weights (M, J) summing to 1, basis (M, 3 R) metres, descriptors (M, width) of the nodes.

        prior (M, J): diffused weights of the body, the starting point of Omega (section 6).
        """
        h = self.descriptors(features, g)
        weights = torch.softmax(torch.log(prior + 1e-3) + self.omega(h), dim=1)
        free = 1 - torch.exp(-0.1 / FREE * features[:, DISTANCE : DISTANCE + 1].clamp(min=0))
        return weights, self.psi(h) * free * OFFSET_UNIT, h


class Coefficients(nn.Module):
    """Pose and shape to signed coefficients of the basis, zero at rest: (P, POSE), (P, SHAPE) -> (P, R)."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.net = nn.Sequential(
            nn.Linear(POSE + SHAPE, sizes.pose_width),
            nn.ReLU(),
            nn.Linear(sizes.pose_width, sizes.pose_width),
            nn.ReLU(),
            nn.Linear(sizes.pose_width, sizes.basis),
        )

    def forward(self, pose: Tensor, shape: Tensor) -> Tensor:
        at_rest = self.net(torch.cat([torch.zeros_like(pose), shape], 1))
        return self.net(torch.cat([pose, shape], 1)) - at_rest


class ConcatenatedPsi(nn.Module):
    """Psi as printed (section 4.2.2): four fully connected layers on descriptor and pose of every vertex."""

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.net = nn.Sequential(
            nn.Linear(sizes.width + POSE + SHAPE, 256), nn.ReLU(), nn.Linear(256, 256), nn.ReLU(),
            nn.Linear(256, 256), nn.ReLU(), nn.Linear(256, 3),
        )  # fmt: skip

    def forward(self, descriptors: Tensor, pose: Tensor, shape: Tensor) -> Tensor:
        """(N, width), (1, POSE), (1, SHAPE) -> offsets (N, 3), metres, `rest` space."""
        n = descriptors.shape[0]
        return self.net(torch.cat([descriptors, pose.expand(n, -1), shape.expand(n, -1)], 1)) * OFFSET_UNIT


def pose_features(transforms: Tensor, parents: Tensor) -> Tensor:
    """Pose features, zero in the A-pose: (P, J, 3, 4) world-from-A-pose transforms -> (P, POSE).

    Per joint: its rotation relative to its parent minus the identity (9), and the direction of gravity
    in its frame minus that at rest (3).
    """
    rotation = transforms[..., :3]
    parent = rotation.index_select(1, parents.clamp(min=0))
    parent = torch.where((parents < 0)[None, :, None, None], torch.eye(3), parent)
    local = parent.transpose(-1, -2) @ rotation - torch.eye(3)
    down = torch.tensor([0.0, -1.0, 0.0])
    gravity = rotation.transpose(-1, -2) @ down - down
    return torch.cat([local.flatten(2), gravity], 2).flatten(1)


def top_four(weights: Tensor) -> tuple[Tensor, Tensor]:
    """The four largest skin weights of each vertex, renormalised: (N, J) -> (N, 4), (N, 4) joints."""
    value, joint = weights.topk(4, dim=1)
    return value / value.sum(1, keepdim=True), joint


def skin(rest: Tensor, weight: Tensor, joint: Tensor, transforms: Tensor) -> tuple[Tensor, Tensor]:
    """Linear blend skinning, equation 3: rest (P, N, 3), weight and joint (N, 4), transforms (P, J, 3, 4).

    Returns posed vertices (P, N, 3) and where each vertex's rest +Y turns to (P, N, 3), without gradient.
    """
    count, joints = rest.shape[0], transforms.shape[1]
    spread = weight.new_zeros(len(joint), joints).scatter(1, joint, weight)
    blended = spread @ transforms.transpose(0, 1).reshape(joints, -1)
    blended = blended.reshape(len(joint), count, 3, 4).transpose(0, 1)
    return (blended[..., :3] @ rest[..., None])[..., 0] + blended[..., 3], blended[..., 1].detach()
