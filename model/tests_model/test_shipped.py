"""The shipped graphs become the network again."""

import torch
from safetensors.numpy import load_file

import export_garnet
from export import ARTIFACTS, check, example, specs
from export_pixel import folded
from nets.deepsd import ConcatenatedPsi, Sizes
from pixel_poses import POSE
from shipped import shipped, shipped_garnet, shipped_tee


def test_the_recovered_network_answers_as_its_graphs_do() -> None:
    sizes = Sizes()
    for spec in specs(shipped().eval(), ConcatenatedPsi(sizes), sizes):
        if spec.method == "deepsd":
            extents = {d: 50 for p in spec.inputs for d in p.shape if isinstance(d, str)}
            check(spec, ARTIFACTS / spec.method / f"{spec.name}.onnx", example(spec.inputs, extents, 3))


def test_the_recovered_tee_has_the_shipped_weights_and_can_learn_on() -> None:
    poses = torch.eye(3).flatten().repeat(4, POSE // 9) + 0.1 * torch.randn(4, POSE, generator=torch.manual_seed(0))
    net, _ = shipped_tee(poses)
    kept = load_file(ARTIFACTS / "pixel_cloth" / "tee.safetensors")
    for name, value in folded(net).items():
        assert torch.allclose(value, torch.as_tensor(kept[name]), rtol=1e-4, atol=1e-6), name
    with torch.no_grad():
        said, learning = net(poses), net.train()(poses)
    assert torch.allclose(said, learning, atol=1e-4), "normalised by what these poses have"


def test_a_recovered_garnet_answers_as_its_graph_does() -> None:
    jeans = export_garnet.spec("jeans", shipped_garnet("jeans").eval())
    extents = {d: 50 for p in jeans.inputs for d in p.shape if isinstance(d, str)}
    check(jeans, ARTIFACTS / "garnet" / "jeans.onnx", example(jeans.inputs, extents, 3))
