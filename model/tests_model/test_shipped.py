"""The shipped graphs become the network again."""

from export import ARTIFACTS, check, example, specs
from nets.deepsd import ConcatenatedPsi, Sizes
from shipped import shipped


def test_the_recovered_network_answers_as_its_graphs_do() -> None:
    sizes = Sizes()
    for spec in specs(shipped().eval(), ConcatenatedPsi(sizes), sizes):
        if spec.method == "deepsd":
            extents = {d: 50 for p in spec.inputs for d in p.shape if isinstance(d, str)}
            check(spec, ARTIFACTS / spec.method / f"{spec.name}.onnx", example(spec.inputs, extents, 3))
