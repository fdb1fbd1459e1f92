"""How far every method is from the simulated demo outfits, as the page shows it: `python -m teacher.compare_shown`.

Beside `teacher.compare`, which judges the shared network on unseen outfits: these have networks of their own as well.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray
from safetensors import safe_open

from body.anny_body import AnnyBody
from export import ARTIFACTS
from training_data import DATA

from .compare import Figures, Scene
from .drapes import draped
from .shown import OUTFITS, ask

#: Ways to drape them all, and those of some beside.
ALL = ("skinning", "deepsd", "garnet")
OWN = {"hero-t-shirt": ("pixel_cloth",)}


def simulated(name: str) -> dict[str, NDArray]:
    """Cloth (N, 3) of a demo outfit by preset pose."""
    with safe_open(ARTIFACTS / "simulated" / f"{name}.safetensors", "np") as file:
        poses = [on["pose"]["id"] for on in json.loads(file.metadata()["drapes"])]
        return dict(zip(poses, file.get_tensor("cloth"), strict=True))


def compare(name: str) -> Iterator[tuple[str, Figures]]:
    """Figures of every way to drape an outfit, and of the simulation itself, in every pose that was simulated."""
    scratch, outfit, truths = DATA / "shown" / name, ARTIFACTS / "gallery" / f"{name}.glb", simulated(name)
    ask(scratch, tuple(truths))
    ways = {method: draped(scratch, method, outfit) for method in (*ALL, *OWN.get(name, ()))}
    first, faces = ways[ALL[0]], AnnyBody.load().triangles
    for k, truth in enumerate(truths.values()):
        scene = Scene(first["rest"][0], first["triangles"].astype(np.int64), first["body"][0, k], faces)
        for method, way in ways.items():
            yield f"{method}, before the resolve", scene.figures(way["draped"][0, k], truth)
            if method != ALL[0]:
                yield f"{method}, after the resolve", scene.figures(way["resolved"][0, k], truth)
        yield "simulation", scene.figures(truth, truth)


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("outfits", nargs="*", default=OUTFITS, help="names of demo outfits")
    for name in p.parse_args().outfits:
        found: dict[str, list[Figures]] = {}
        for way, figures in compare(name):
            found.setdefault(way, []).append(figures)
        print(f"\n| {name} | error mm | edge mm | edge % | bend | inside % | drapes |")
        print("|---|---:|---:|---:|---:|---:|---:|")
        for way, rows in found.items():
            error, edge, percent, bend, inside = np.mean([astuple(row) for row in rows], 0)
            figures = f"{error:.1f} | {edge:.2f} | {percent:.1f} | {bend:.4f} | {inside:.2f}"
            print(f"| {way} | {figures} | {len(rows)} |")


if __name__ == "__main__":
    main()
