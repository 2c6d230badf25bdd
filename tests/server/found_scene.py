"""A recording without first poses, of parts whose network says where they are."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import fake_network
import numpy as np

from snapfit.models.asset import find_asset
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.sequence_writer import SequenceWriter
from snapfit.tracking.frame import Frame

PARTS, POSES, CAMERA = fake_network.PARTS, fake_network.POSES, fake_network.RGBD
FOUND = tuple(part.name for part in PARTS)
UNKNOWN_TO_THE_NETWORK = "bolt"


def colored_frame(name: str = "000000") -> Frame:
    """The fake network's frame, its parts in their colours before a noisy wall."""
    rng = np.random.default_rng(4)
    frame = fake_network.frame(name=name)
    seen = render(CAMERA.color, [(p.mesh, POSES[p.name]) for p in PARTS], normals=True)
    assert seen.normal is not None
    colors = np.array([(0, 0, 0), *(part.color_rgb[::-1] for part in PARTS)], dtype=np.float64)
    body = colors[seen.part_id] * (0.5 + 0.5 * np.abs(seen.normal[..., 2:]))
    wall = rng.integers(100, 160, (*seen.depth.shape, 1)) * np.ones(3)
    color = np.where(seen.part_id[..., None] > 0, body, wall) + rng.normal(0, 3, body.shape)
    pixels = np.ascontiguousarray(np.clip(color, 0, 255).astype(np.uint8))
    return replace(frame, color=pixels)


def write_bundle(folder: Path) -> Path:
    """The clamp's bundle with a network that finds two of its three parts."""
    shutil.copytree(find_asset("hobby-corner-clamp").directory, folder)
    return fake_network.write_detector(folder)


def write_recording(folder: Path, initial_poses: dict[str, Pose] | None = None) -> Path:
    """Two equal frames; no first poses unless they are given.

    Ten frames a second: who asks often sees the first one, in which nothing has been found yet.
    """
    writer = SequenceWriter(
        folder,
        CAMERA,
        frame_rate_hz=10.0,
        asset="hobby-corner-clamp",
        initial_poses=initial_poses or {},
    )
    with writer:
        for name in ("000000", "000001"):
            frame = colored_frame(name)
            writer.write(name, frame.color, frame.depth)
    return folder


def write_network_that_breaks(folder: Path) -> None:
    """A network that runs on a black image, as when it is tried, and on no other."""
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    rows = fake_network.output()
    arrays = [
        numpy_helper.from_array(np.asarray(rows, dtype=np.float32), "rows"),
        numpy_helper.from_array(np.array(7000, dtype=np.int64), "far"),
        numpy_helper.from_array(np.zeros(1, dtype=np.int64), "first"),
    ]
    nodes = [
        helper.make_node("ReduceMax", ["images"], ["brightest"], keepdims=0),
        helper.make_node("Ceil", ["brightest"], ["one"]),
        helper.make_node("Cast", ["one"], ["place"], to=TensorProto.INT64),
        helper.make_node("Mul", ["place", "far"], ["beyond"]),
        helper.make_node("Gather", ["rows", "beyond"], ["row"], axis=0),
        helper.make_node("Unsqueeze", ["row", "first"], ["output0"]),
    ]
    width, height = fake_network.INPUT
    graph = helper.make_graph(
        nodes,
        "breaks",
        [helper.make_tensor_value_info("images", TensorProto.FLOAT, [1, 3, height, width])],
        [helper.make_tensor_value_info("output0", TensorProto.FLOAT, list(rows.shape))],
        arrays,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    model.ir_version = 8
    onnx.save(model, folder / "detector.onnx")
