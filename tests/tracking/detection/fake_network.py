"""A scene of two parts, what a perfect network would say of it, and that network as a file."""

from __future__ import annotations

import numpy as np

from snapfit.models.asset import find_asset
from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.detector.card import (
    CARD_NAME,
    ONNX_NAME,
    CardClass,
    DetectorCard,
    write_card,
)
from snapfit.models.keypoints import keypoint_models
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.tracking.detection.letterbox import Letterbox
from snapfit.tracking.frame import Frame

ASSET = find_asset("hobby-corner-clamp")
PARTS = ASSET.tracked_parts[:2]
MODELS = keypoint_models(PARTS)
CAMERA = PinholeCamera(640, 360, 500.0, 500.0, 320.5, 178.0)
RGBD = RgbdCamera(CAMERA, CAMERA, 0.001)
INPUT = 320, 192
N_ANCHORS = 60
POSES = {
    PARTS[0].name: Pose.exp([0.4, -0.5, 0.9, 0, 0, 0]),
    PARTS[1].name: Pose.exp([-1.1, 0.3, 0.2, 0, 0, 0]),
}
POSES = {
    name: Pose.from_rotation_translation(pose.rotation, place)
    for (name, pose), place in zip(
        POSES.items(), [(-0.06, 0.02, 0.55), (0.08, -0.01, 0.62)], strict=True
    )
}


def card(**changes):
    classes = tuple(
        CardClass(part=model.name, keypoints_m=model.points.tolist()) for model in MODELS
    )
    given = {
        "asset": ASSET.name,
        "classes": classes,
        "input_width_px": INPUT[0],
        "input_height_px": INPUT[1],
        **changes,
    }
    return DetectorCard(**given)


def truth_in_input(letterbox=None):
    """By part: keypoints (K, 2) and box (4,) in pixels of the input, its edge at 0."""
    box = letterbox or Letterbox(CAMERA.width, CAMERA.height, *INPUT)
    found = {}
    for part, model in zip(PARTS, MODELS, strict=True):
        pose = POSES[part.name]
        corner = np.array(box.offset)
        factor = np.array(box.size) / (CAMERA.width, CAMERA.height)
        outline = (CAMERA.project(pose.transform(part.mesh.vertices)) + 0.5) * factor + corner
        keypoints = (CAMERA.project(pose.transform(model.points)) + 0.5) * factor + corner
        found[part.name] = keypoints, np.concatenate([outline.min(axis=0), outline.max(axis=0)])
    return found


def output(scores=(0.9, 0.8), n_anchors=N_ANCHORS, n_keypoints=17):
    """(1, rows, anchors): anchor 10 shows the first part, 20 the second, the others nothing."""
    rows = np.zeros((1, 4 + len(PARTS) + 3 * n_keypoints, n_anchors), dtype=np.float32)
    for k, (keypoints, box) in enumerate(truth_in_input().values()):
        column = 10 * (k + 1)
        rows[0, :4, column] = [*(box[:2] + box[2:]) / 2, *(box[2:] - box[:2])]
        rows[0, 4 + k, column] = scores[k]
        places = np.column_stack([keypoints, np.full(len(keypoints), 0.99)])
        rows[0, 4 + len(PARTS) :, column] = places.ravel()
    return rows


def write_network(folder, rows, *, input_shape=(1, 3, INPUT[1], INPUT[0]), free=False):
    """A file whose output is always `rows`."""
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    shape = [1, 3, "height", "width"] if free else list(input_shape)
    arrays = [
        numpy_helper.from_array(np.asarray(rows, dtype=np.float32), "rows"),
        numpy_helper.from_array(np.zeros((), np.float32), "zero"),
    ]
    nodes = [
        helper.make_node("ReduceSum", ["images"], ["sum"], keepdims=0),
        helper.make_node("Mul", ["sum", "zero"], ["nothing"]),
        helper.make_node("Add", ["rows", "nothing"], ["output0"]),
    ]
    out = ["batch", "rows", "anchors"] if free else list(np.shape(rows))
    graph = helper.make_graph(
        nodes,
        "fake",
        [helper.make_tensor_value_info("images", TensorProto.FLOAT, shape)],
        [helper.make_tensor_value_info("output0", TensorProto.FLOAT, out)],
        arrays,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    model.ir_version = 8
    folder.mkdir(parents=True, exist_ok=True)
    onnx.save(model, folder / ONNX_NAME)


def write_detector(folder, rows=None, **options):
    """A folder with a network and its card."""
    write_network(folder, output() if rows is None else rows, **options)
    write_card(card(), folder / CARD_NAME)
    return folder


def frame(depth_factor=1.0, name="000000"):
    """An image of the parts (grey), with depth that is `depth_factor` times the true one."""
    drawn = render(CAMERA, [(part.mesh, POSES[part.name]) for part in PARTS]).depth
    shown = np.where(drawn > 0, drawn, 0.9)
    depth = np.rint(shown * depth_factor / RGBD.depth_scale_m).astype(np.uint16)
    color = np.full((CAMERA.height, CAMERA.width, 3), 90, dtype=np.uint8)
    return Frame(name, 0, color, depth)
