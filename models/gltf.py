"""Writes a mesh as binary glTF 2.0: one file, metres, glTF's own axes.

glTF is right-handed with y up. A body whose axes are OpenCV's (x right, y down, z forward) becomes
x right, y up, z backward: y and z are negated, which is half a turn about x and no mirror.
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.mesh import Mesh

GLTF_FROM_BODY = np.diag([1.0, -1.0, -1.0])
"""(3, 3): glTF's components of a point in the body frame."""

_MAGIC, _VERSION = 0x46546C67, 2
_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942
_FLOAT, _UNSIGNED_INT = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_SMOOTH_BELOW_RAD = np.radians(30)
_ROUGHNESS = 0.6


def glb(name: str, mesh: Mesh, color_rgb: tuple[int, int, int]) -> bytes:
    """The file.

    Args:
        name: of the node.
        mesh: metres, body frame.
        color_rgb: sRGB, 0 to 255.
    """
    vertices, normals, faces = _shaded(mesh)
    pieces = [
        np.ascontiguousarray(each, dtype).tobytes()
        for each, dtype in ((vertices, "<f4"), (normals, "<f4"), (faces, "<u4"))
    ]
    views, at = [], 0
    for piece, target in zip(pieces, (_VERTICES, _VERTICES, _INDICES), strict=True):
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(piece), "target": target})
        at += len(piece)
    document = {
        "asset": {"version": "2.0", "generator": "snapfit"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0}],
        "meshes": [{"name": name, "primitives": [_PRIMITIVE]}],
        "materials": [_material(color_rgb)],
        "accessors": [
            _accessor(0, _FLOAT, "VEC3", len(vertices), vertices),
            _accessor(1, _FLOAT, "VEC3", len(normals)),
            _accessor(2, _UNSIGNED_INT, "SCALAR", faces.size),
        ],
        "bufferViews": views,
        "buffers": [{"byteLength": at}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    chunks = _chunk(_JSON_CHUNK, text, b" ") + _chunk(_BINARY_CHUNK, b"".join(pieces), b"\0")
    return struct.pack("<III", _MAGIC, _VERSION, 12 + len(chunks)) + chunks


_PRIMITIVE = {"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}


def _shaded(
    mesh: Mesh,
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], npt.NDArray[np.int64]]:
    """Vertices and normals in glTF's axes, and faces; sharp edges are split, others smooth."""
    import trimesh  # here, because what only knows about meshes must not pay for it

    whole = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    smooth = trimesh.graph.smooth_shade(whole, angle=_SMOOTH_BELOW_RAD)
    turn = GLTF_FROM_BODY.T
    normals = smooth.vertex_normals @ turn
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(lengths > 0, normals / np.maximum(lengths, 1e-12), (0.0, 0.0, 1.0))
    return (
        (smooth.vertices @ turn).astype(np.float32),
        normals.astype(np.float32),
        np.asarray(smooth.faces, dtype=np.int64),
    )


def _material(color_rgb: tuple[int, int, int]) -> dict[str, Any]:
    linear = [_linear(value / 255) for value in color_rgb]
    surface = {"baseColorFactor": [*linear, 1.0], "metallicFactor": 0.0}
    return {"pbrMetallicRoughness": {**surface, "roughnessFactor": _ROUGHNESS}}


def _linear(value: float) -> float:
    """From sRGB to the linear colour that glTF's factors are."""
    linear = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
    return round(linear, 6)


def _accessor(
    view: int, component: int, kind: str, count: int, values: npt.NDArray[np.float32] | None = None
) -> dict[str, Any]:
    accessor = {"bufferView": view, "componentType": component, "type": kind, "count": count}
    if values is None:
        return accessor
    bounds = {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
    return {**accessor, **bounds}


def _chunk(kind: int, content: bytes, padding: bytes) -> bytes:
    content += padding * (-len(content) % 4)
    return struct.pack("<II", len(content), kind) + content
