"""GarNet's drapes on scans of test bodies beside those on the bodies themselves: `python -m evaluate_scans`.

A running server (`make run`) drapes the four garments on test bodies of `garnet_data`, once by the bodies' parameters
and once as scans: every second triangle alone, turned by 40 degrees, with 2 mm of noise. E_dist (Gundogdu et al. 2020,
equation 17) of both to the relaxed drapes, after the resolve.
"""

from __future__ import annotations

import argparse
import io
import json
import urllib.request
import uuid
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from body.anny_body import AnnyBody
from body.humanoid import Rotations
from body.pose_sampling import DEMANDING, sample_poses
from garnet_data import RELAXED, SPLITS, Split, samples
from outfits.garnet_garments import PATTERNS
from teacher.checks import good
from training_data import ShapeValues, random_shape

Floats = NDArray[np.floating]

NOISE, TURN = 0.002, np.radians(40)


class Service:
    """A running server."""

    def __init__(self, address: str, method: str) -> None:
        self.address, self.method = address, method

    def post(self, path: str, body: bytes, kind: str) -> bytes:
        request = urllib.request.Request(f"{self.address}{path}", body, {"content-type": kind})
        with urllib.request.urlopen(request) as answer:
            return answer.read()

    def upload(self, path: str, file: bytes, metadata: dict) -> dict:
        """Sends an OBJ as a form; the answer."""
        boundary = uuid.uuid4().hex
        parts = (
            ('name="metadata"', json.dumps(metadata).encode()),
            ('name="file"; filename="mesh.obj"', file),
        )
        head = "--{}\r\ncontent-disposition: form-data; {}\r\n\r\n"
        body = b"".join(head.format(boundary, name).encode() + part + b"\r\n" for name, part in parts)
        form = body + f"--{boundary}--\r\n".encode()
        return json.loads(self.post(path, form, f"multipart/form-data; boundary={boundary}"))

    def drape(self, outfit: str, body: dict, rotations: Rotations) -> dict[str, Floats]:
        """Positions of every node of a drape."""
        joints = {name: [float(x) for x in q] for name, q in rotations.items()}
        request = {
            "outfit": outfit, "body": body, "pose": {"kind": "joints", "rotations": joints},
            "output": {"include": ["outfit", "body"], "method": self.method},
        }  # fmt: skip
        glb = self.post("/v1/drapes", json.dumps(request).encode(), "application/json")
        scene = trimesh.load(io.BytesIO(glb), file_type="glb", process=False)
        return {name: np.asarray(scene.geometry[scene.graph[name][1]].vertices) for name in scene.graph.nodes_geometry}


def obj(vertices: Floats, triangles: NDArray, name: str) -> bytes:
    lines = [f"o {name}", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices)]
    return "\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in triangles + 1), ""]).encode()


def scanned(body: AnnyBody, values: ShapeValues, seed: int) -> bytes:
    """A body in the A-pose as a scan would have it."""
    rng = np.random.default_rng(seed)
    corners = body.shape(*values).apose_vertices[body.triangles[::2]].reshape(-1, 3)
    c, s = np.cos(TURN), np.sin(TURN)
    turned = corners @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) + rng.normal(0, NOISE, corners.shape)
    return obj(turned, np.arange(len(corners)).reshape(-1, 3), "scan")


def bodies_and_poses(split: Split) -> tuple[list[ShapeValues], list[list[Rotations]]]:
    """What the split's bank was made of."""
    rng, poses = np.random.default_rng(split.seed), sample_poses(split.bodies * split.poses, split.seed, DEMANDING)
    shapes = [random_shape(rng, i) for i in range(split.bodies)]
    return shapes, [poses[i * split.poses : (i + 1) * split.poses] for i in range(split.bodies)]


def distance(draped: dict[str, Floats], garment: str, truth: Floats, skin: Floats) -> float:
    """Mean distance of the vertices, cm, the bodies' means laid on each other: the service's stand on the floor."""
    moved = draped[garment] + skin.mean(0) - draped["body"].mean(0)
    return 100 * float(np.linalg.norm(moved - truth, axis=1).mean())


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--server", default="http://127.0.0.1:8080")
    p.add_argument("--method", default="garnet", help="or deepsd, skinning: to compare with")
    p.add_argument("--drapes", type=Path, default=RELAXED.folder)
    p.add_argument("--poses", type=int, default=2, help="of each body")
    a = p.parse_args()
    service, body, split, garments = Service(a.server, a.method), AnnyBody.load(), SPLITS[2], samples(a.drapes)
    (shapes, poses), bank = bodies_and_poses(split), split.bank()
    found: dict[str, list[tuple[float, float]]] = {kind: [] for kind in PATTERNS}
    ids = {}
    for kind, sample in garments.items():
        mesh = obj(sample.vertices.numpy(), sample.tables[2].numpy(), kind)
        ids[kind] = service.upload("/v1/outfits", mesh, {"kinds": {kind: kind}})["id"]
    for k in split.worn:
        known = {"kind": "phenotypes", "values": shapes[k][0] | shapes[k][1]}
        scan = service.upload("/v1/bodies", scanned(body, shapes[k], k), {})["shape"]
        for kind in PATTERNS:
            for pose in range(a.poses):
                truth = good(a.drapes / kind / split.name / f"{k:03d}_{pose:02d}.npz")
                if truth is None:
                    continue
                skin = bank.entries[k].vertices[pose].numpy()
                drapes = (service.drape(ids[kind], whose, poses[k][pose]) for whose in (known, scan))
                found[kind].append(tuple(distance(d, kind, truth, skin) for d in drapes))
    print("| | by parameters, cm | by its scan, cm | ratio | drapes |\n|---|---:|---:|---:|---:|")
    for kind, rows in found.items():
        one, two = np.mean(rows, axis=0)
        print(f"| {kind} | {one:.2f} | {two:.2f} | {two / one:.2f} | {len(rows)} |")


if __name__ == "__main__":
    main()
