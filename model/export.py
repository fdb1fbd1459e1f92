"""Export the trained networks to ONNX with a manifest and goldens, checked against PyTorch.

    python -m export --checkpoint runs/deepsd.pt --concat runs/deepsd_concat.pt

Writes artifacts/deepsd/{static,dynamic}.onnx, artifacts/deepsd-concat/dynamic.onnx, a manifest.json
beside each, and artifacts/golden/deepsd.safetensors, which the Rust tests replay. Every graph is run in
onnxruntime and must agree with PyTorch within 1e-4 of the output's largest value.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnxruntime
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from nets.deepsd import JOINTS, POSE, SHAPE, Coefficients, ConcatenatedPsi, Graph, Sizes, StaticPass
from train_deepsd import DeePSD

ARTIFACTS = Path(__file__).parent / "artifacts"
TOLERANCE = 1e-4
OPSET = 18


@dataclass(frozen=True)
class Port:
    """One input or output of a graph; a string in the shape is a dimension that varies."""

    name: str
    shape: tuple[int | str, ...]
    unit: str
    space: str = "none"
    dtype: str = "float32"


@dataclass(frozen=True)
class GraphSpec:
    """A graph to export."""

    method: str
    name: str
    module: nn.Module
    inputs: list[Port]
    outputs: list[Port]


class ExportedStatic(nn.Module):
    """StaticPass with flat arguments, in the order of the manifest."""

    def __init__(self, net: StaticPass) -> None:
        super().__init__()
        self.net = net

    def forward(self, features: Tensor, prior: Tensor, *tables: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        return self.net(features, prior, Graph(*tables))


class ExportedDynamic(nn.Module):
    """Coefficients times basis: offsets (T, 3 N) of T poses, metres, `rest` space."""

    def __init__(self, net: Coefficients) -> None:
        super().__init__()
        self.net = net

    def forward(self, pose: Tensor, shape: Tensor, basis: Tensor) -> Tensor:
        return self.net(pose, shape.expand(pose.shape[0], -1)) @ basis


def static_ports(sizes: Sizes) -> tuple[list[Port], list[Port]]:
    """Ports of the static pass; the tables are those of `garment.graph.OutfitGraph`."""
    tables = {
        "near": ("nodes", 8),
        "members": ("patches", 16),
        "patch_near": ("patches", 8),
        "node_from_patch": ("nodes", 8),
    }
    inputs = [Port("features", ("nodes", sizes.features), "mixed", "rest"), Port("prior", ("nodes", JOINTS), "1")]
    for name, shape in tables.items():
        inputs += [Port(name, shape, "index", dtype="int64"), Port(f"{name}_weight", shape, "1")]
    outputs = [
        Port("weights", ("nodes", JOINTS), "1"),
        Port("basis", ("nodes", 3 * sizes.basis), "m", "rest"),
        Port("descriptors", ("nodes", sizes.width), "1"),
    ]
    return inputs, outputs


def specs(net: DeePSD, concat: ConcatenatedPsi, sizes: Sizes) -> list[GraphSpec]:
    pose, shape = Port("pose", ("frames", POSE), "1", "joint"), Port("shape", (1, SHAPE), "1")
    one = Port("pose", (1, POSE), "1", "joint")
    return [
        GraphSpec("deepsd", "static", ExportedStatic(net.static), *static_ports(sizes)),
        GraphSpec(
            "deepsd", "dynamic", ExportedDynamic(net.coefficients),
            [pose, shape, Port("basis", (sizes.basis, "offsets"), "m", "rest")],
            [Port("offsets", ("frames", "offsets"), "m", "rest")],
        ),
        GraphSpec(
            "deepsd-concat", "dynamic", concat,
            [Port("descriptors", ("vertices", sizes.width), "1"), one, shape],
            [Port("offsets", ("vertices", 3), "m", "rest")],
        ),
    ]  # fmt: skip


def example(ports: Sequence[Port], extents: dict[str, int], seed: int) -> tuple[Tensor, ...]:
    """Random inputs; indices stay below every extent in use, weights are positive."""
    g = torch.Generator().manual_seed(seed)
    limit = min(extents.values(), default=1)
    out = []
    for port in ports:
        shape = tuple(extents[d] if isinstance(d, str) else d for d in port.shape)
        if port.dtype == "int64":
            out.append(torch.randint(0, limit, shape, generator=g))
        elif port.name.endswith("weight") or port.name == "prior":
            out.append(torch.rand(shape, generator=g) / shape[-1])
        else:
            out.append(torch.randn(shape, generator=g) * 0.5)
    return tuple(out)


@torch.no_grad()
def export_graph(spec: GraphSpec, folder: Path) -> Path:
    """Writes one graph, with the plain gather instead of its form for training; checks it against PyTorch twice."""
    path = folder / f"{spec.name}.onnx"
    path.parent.mkdir(parents=True, exist_ok=True)
    extents = {
        d: 40 + 7 * i for i, d in enumerate(sorted({d for p in spec.inputs for d in p.shape if isinstance(d, str)}))
    }
    spec.module.eval()
    axes = {p.name: {i: d for i, d in enumerate(p.shape) if isinstance(d, str)} for p in [*spec.inputs, *spec.outputs]}
    torch.onnx.export(
        spec.module, example(spec.inputs, extents, 0), str(path), dynamo=False, opset_version=OPSET,
        input_names=[p.name for p in spec.inputs], output_names=[p.name for p in spec.outputs], dynamic_axes=axes,
    )  # fmt: skip
    for seed, factor in ((1, 1), (2, 3)):
        check(spec, path, example(spec.inputs, {k: v * factor for k, v in extents.items()}, seed))
    return path


def run_onnx(path: Path, inputs: dict[str, NDArray]) -> list[NDArray]:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    return onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"]).run(None, inputs)


def check(spec: GraphSpec, path: Path, inputs: tuple[Tensor, ...]) -> None:
    with torch.no_grad():
        expected = spec.module(*inputs)
    expected = expected if isinstance(expected, tuple) else (expected,)
    got = run_onnx(path, {p.name: x.numpy() for p, x in zip(spec.inputs, inputs, strict=True)})
    for port, a, b in zip(spec.outputs, expected, got, strict=True):
        worst = float(np.abs(a.numpy() - b).max() / max(np.abs(b).max(), 1e-6))
        if worst > TOLERANCE:
            raise SystemExit(
                f"{spec.method}/{spec.name}: {port.name} differs by {worst:.1e} between PyTorch and onnxruntime"
            )
        print(f"{spec.method}/{spec.name} {port.name}: {worst:.1e} relative")


def manifest(method: str, graphs: list[tuple[GraphSpec, Path]]) -> dict:
    """What Rust checks before it starts."""
    return {
        "format": "toile-networks/1",
        "method": method,
        "graphs": [
            {
                "name": spec.name,
                "file": path.name,
                "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
                "inputs": [vars(p) for p in spec.inputs],
                "outputs": [vars(p) for p in spec.outputs],
            }
            for spec, path in graphs
        ],
    }


def export_method(method: str, graphs: list[GraphSpec], out: Path) -> None:
    """Graphs of one way to drape, and their manifest."""
    written = [(spec, export_graph(spec, out / method)) for spec in graphs]
    (out / method / "manifest.json").write_text(json.dumps(manifest(method, written), indent=1) + "\n")


def export_all(net: DeePSD, concat: ConcatenatedPsi, sizes: Sizes, out: Path) -> None:
    """Both forms of DeePSD."""
    graphs = specs(net, concat, sizes)
    for method in sorted({spec.method for spec in graphs}):
        export_method(method, [spec for spec in graphs if spec.method == method], out)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--checkpoint", type=Path, default=Path("runs/deepsd.pt"))
    p.add_argument("--concat", type=Path, default=Path("runs/deepsd_concat.pt"))
    p.add_argument("--out", type=Path, default=ARTIFACTS)
    a = p.parse_args()
    sizes = Sizes()
    net, concat = DeePSD(sizes), ConcatenatedPsi(sizes)
    net.load_state_dict(torch.load(a.checkpoint)["net"])
    concat.load_state_dict(torch.load(a.concat)["net"])
    export_all(net, concat, sizes, a.out)


if __name__ == "__main__":
    main()
