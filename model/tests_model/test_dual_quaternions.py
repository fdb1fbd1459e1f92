"""Dual-quaternion skinning: rigid where it should be, and without the collapse of linear blending."""

import numpy as np
import torch
from scipy.spatial.transform import Rotation

from garment.dual_quaternions import blended, warp
from nets.deepsd import skin


def rigid(rotation: Rotation, translation: tuple[float, float, float]) -> np.ndarray:
    return np.column_stack([rotation.as_matrix(), translation])


def test_one_influence_moves_rigidly() -> None:
    rng = np.random.default_rng(0)
    rest = rng.normal(size=(50, 3))
    transforms = np.stack([[rigid(Rotation.random(rng=rng), rng.normal(size=3)) for _ in range(3)] for _ in range(4)])
    joint = rng.integers(3, size=(50, 1))
    expected = skin(
        torch.as_tensor(rest).expand(4, -1, -1), torch.ones(50, 1).double(), torch.as_tensor(joint),
        torch.as_tensor(transforms),
    )[0]  # fmt: skip
    np.testing.assert_allclose(warp(rest, np.ones((50, 1)), joint, transforms), expected.numpy(), atol=1e-9)


def test_joints_that_move_alike_move_cloth_alike_whatever_their_shares() -> None:
    rng = np.random.default_rng(1)
    rest, weight = rng.normal(size=(20, 3)), rng.dirichlet([1, 1, 1], 20)
    together = rigid(Rotation.random(rng=rng), (0.1, 1.2, -0.3))
    out = warp(rest, weight, np.arange(3)[None].repeat(20, 0), np.stack([together] * 3)[None])[0]
    np.testing.assert_allclose(out, rest @ together[:, :3].T + together[:, 3], atol=1e-9)


def test_a_twisted_sleeve_keeps_its_girth() -> None:
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    cuff = np.stack([np.zeros(12), 0.05 * np.cos(angle), 0.05 * np.sin(angle)], 1)
    twist = np.stack([rigid(Rotation.from_rotvec([a, 0, 0]), (0.0, 0.0, 0.0)) for a in (0.0, np.radians(170))])
    weight, joint = np.full((12, 2), 0.5), np.arange(2)[None].repeat(12, 0)
    linear = skin(
        torch.as_tensor(cuff)[None], torch.as_tensor(weight), torch.as_tensor(joint), torch.as_tensor(twist)[None]
    )
    assert np.linalg.norm(linear[0][0].numpy(), axis=1).max() < 0.01
    np.testing.assert_allclose(np.linalg.norm(warp(cuff, weight, joint, twist[None])[0], axis=1), 0.05, rtol=1e-6)


def test_turns_are_what_motions_do_to_small_steps() -> None:
    rng = np.random.default_rng(4)
    rest, weight = rng.normal(size=(30, 3)), rng.dirichlet([1, 1], 30)
    transforms = np.stack([rigid(Rotation.random(rng=rng), rng.normal(size=3)) for _ in range(2)])[None]
    motions = blended(weight, np.arange(2)[None].repeat(30, 0), transforms)
    step = np.array([0.01, -0.02, 0.03])
    moved = motions.move(rest + step) - motions.move(rest)
    np.testing.assert_allclose(moved[0], motions.turns()[0] @ step, atol=1e-9)
