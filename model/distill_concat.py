"""Distil the basis form of DeePSD into the printed form (paper section 4.2.2), for the comparison.

    python -m distill_concat --checkpoint runs/deepsd.pt --minutes 10

The printed network sees the frozen descriptors of the shipped static pass with pose and shape on every
vertex, and learns to give the same offsets.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import numpy as np
import torch
from torch import nn

import optimisers
from nets.deepsd import ConcatenatedPsi, Sizes, pose_features
from train_deepsd import RUNS, DeePSD
from training_data import DATA, BodyBank, Sample, load_samples

RATE = 4e-3
#: First and last matrix.
OUTER = ("net.0.weight", "net.6.weight")


@torch.no_grad()
def target(net: DeePSD, sample: Sample, pose: torch.Tensor, shape: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Descriptors (N, width) and the basis form's offsets (P, N, 3) of an outfit in P poses."""
    _, *nodes = net.static(sample.features, sample.prior, sample.graph)
    return sample.at_vertices(nodes[1]), net.offsets(sample, tuple(nodes), pose, shape)


def learn(net: DeePSD, concat: ConcatenatedPsi, samples: list[Sample], bank: BodyBank, minutes: float) -> float:
    """Muon and Adam on the mean squared offset error; returns the mean relative error of the last hundred steps."""
    rng = np.random.default_rng(0)
    tools = optimisers.muon_and_adam(concat, RATE, OUTER)
    started, errors = time.time(), []
    while (progress := (time.time() - started) / (60 * minutes)) < 1:
        optimisers.set_rate(tools, RATE * (0.02 + 0.98 * 0.5 * (1 + np.cos(np.pi * progress))))
        sample, entry = samples[rng.integers(len(samples))], bank.entries[rng.integers(len(bank.entries))]
        poses = torch.as_tensor(rng.choice(len(entry.vertices), 4, replace=False))
        # The A-pose last: random poses never come near it, and cloth must lie still there.
        pose = nn.functional.pad(pose_features(entry.transforms[poses], bank.parents), (0, 0, 0, 1))
        descriptors, offsets = target(net, sample, pose, entry.shape)
        rows = torch.as_tensor(rng.choice(len(descriptors), min(1024, len(descriptors)), replace=False))
        got = torch.stack([concat(descriptors[rows], p[None], entry.shape[None]) for p in pose])
        loss = (got - offsets[:, rows]).square().mean()
        (loss * 1e4).backward()
        optimisers.step(tools)
        errors.append((loss / offsets.square().mean().clamp(min=1e-8)).sqrt().item())
        if len(errors) % 100 == 0:
            print(
                json.dumps({"step": len(errors), "relative_error": round(float(np.mean(errors[-100:])), 4)}), flush=True
            )
    return float(np.mean(errors[-100:]))


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--checkpoint", type=Path, default=RUNS / "deepsd.pt")
    p.add_argument("--out", type=Path, default=RUNS / "deepsd_concat.pt")
    p.add_argument("--outfits", type=Path, default=DATA / "outfits")
    p.add_argument("--minutes", type=float, default=10)
    p.add_argument("--limit", type=int)
    a = p.parse_args()
    torch.manual_seed(0)
    sizes = Sizes()
    net, concat = DeePSD(sizes), ConcatenatedPsi(sizes)
    net.load_state_dict(torch.load(a.checkpoint)["net"])
    net.eval()
    samples = load_samples(a.outfits / "train")[: a.limit]
    error = learn(net, concat, samples, BodyBank(12, 24, 3), a.minutes)
    torch.save({"net": concat.state_dict(), "relative_error": error}, a.out)


if __name__ == "__main__":
    main()
