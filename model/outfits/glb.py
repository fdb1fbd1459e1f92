"""Write outfits as binary glTF 2.0: one node and mesh per garment, textures embedded, KHR_materials_sheen."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .fabrics import Fabric, texture
from .mesh import GarmentMesh, vertex_normals

FLOAT, U16, U32 = 5126, 5123, 5125
VERTEX_BUFFER, INDEX_BUFFER = 34962, 34963


class _Document:
    """glTF JSON and its one buffer, growing together."""

    def __init__(self, name: str) -> None:
        self.blob = bytearray()
        self.json: dict = {
            "asset": {"version": "2.0", "generator": "Toile outfits"},
            "extensionsUsed": ["KHR_materials_sheen"],
            "scene": 0,
            "scenes": [{"name": name, "nodes": []}],
            **{k: [] for k in ("nodes", "meshes", "accessors", "bufferViews", "materials", "textures", "images")},
            "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}],
        }
        self.materials: dict[Fabric, int] = {}

    def add(self, key: str, item: dict) -> int:
        self.json[key].append(item)
        return len(self.json[key]) - 1

    def view(self, data: bytes, target: int | None = None) -> int:
        self.blob.extend(b"\0" * (-len(self.blob) % 4))
        item = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data)}
        self.blob.extend(data)
        return self.add("bufferViews", item | ({"target": target} if target else {}))

    def accessor(self, values: NDArray, kind: str, component: int, bounds: bool = False) -> int:
        target = INDEX_BUFFER if kind == "SCALAR" else VERTEX_BUFFER
        item = {
            "bufferView": self.view(values.tobytes(), target),
            "componentType": component,
            "count": len(values),
            "type": kind,
        }
        if bounds:
            item |= {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
        return self.add("accessors", item)


def write_glb(garments: list[GarmentMesh], path: Path, name: str) -> None:
    """Write garments (each with `uv` and a Fabric under material["fabric"]) to `path`."""
    document = _Document(name)
    for garment in garments:
        mesh = document.add("meshes", {"name": garment.name, "primitives": [_primitive(document, garment)]})
        node = document.add("nodes", {"name": garment.name, "mesh": mesh, "extras": {"layer": garment.layer}})
        document.json["scenes"][0]["nodes"].append(node)
    document.blob.extend(b"\0" * (-len(document.blob) % 4))
    document.json["buffers"] = [{"byteLength": len(document.blob)}]
    text = json.dumps(document.json, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + len(document.blob)
    header = struct.pack("<4sII", b"glTF", 2, size)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(document.blob), b"BIN\0")
    path.write_bytes(header + chunks + bytes(document.blob))


def _primitive(document: _Document, garment: GarmentMesh) -> dict:
    corner = np.zeros(len(garment.uv), np.int64)
    corner[garment.uv_triangles.ravel()] = garment.triangles.ravel()
    fabric: Fabric = garment.material["fabric"]
    normals = vertex_normals(garment.vertices, garment.triangles)[corner]
    uv = garment.uv / fabric.tile
    uv = uv - np.floor(uv.min(0))
    small = len(corner) < 65535
    attributes = {
        "POSITION": document.accessor(garment.vertices[corner].astype("<f4"), "VEC3", FLOAT, True),
        "NORMAL": document.accessor(normals.astype("<f4"), "VEC3", FLOAT),
        "TEXCOORD_0": document.accessor(uv.astype("<f4"), "VEC2", FLOAT),
    }
    indices = garment.uv_triangles.ravel().astype("<u2" if small else "<u4")
    return {
        "attributes": attributes,
        "indices": document.accessor(indices, "SCALAR", U16 if small else U32),
        "material": _material(document, fabric),
    }


def _material(document: _Document, fabric: Fabric) -> int:
    if fabric not in document.materials:
        image = document.add("images", {"bufferView": document.view(texture(fabric)), "mimeType": "image/jpeg"})
        base = document.add("textures", {"sampler": 0, "source": image})
        tint = [float(0.35 * fabric.sheen + 0.65 * fabric.sheen * c) for c in fabric.colours[0]]
        material = {
            "name": fabric.weave,
            "doubleSided": True,
            "pbrMetallicRoughness": {
                "baseColorTexture": {"index": base},
                "metallicFactor": 0.0,
                "roughnessFactor": fabric.roughness,
            },
            "extensions": {"KHR_materials_sheen": {"sheenColorFactor": tint, "sheenRoughnessFactor": 0.5}},
        }
        document.materials[fabric] = document.add("materials", material)
    return document.materials[fabric]
