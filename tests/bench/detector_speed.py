"""Time of one detection, beside the public YOLOv8n-pose in turns: make bench, suite `detector`.

Both have first weights: what a convolution takes does not depend on them. The public network is
built with its public widths, for one class and 17 keypoints, and looks at 640x640 pixels.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import beside_speed
import numpy as np
from figure import Figure, at_most

MOST_MS, MOST_SHARE = 60.0, 0.5
N_RUNS = 40


def run() -> list[Figure]:
    """All figures; none where PyTorch is not installed, which makes the networks."""
    try:
        import torch
    except ImportError:
        return [Figure("detector: not measured, PyTorch is not installed", float("nan"), "")]
    torch.manual_seed(0)
    with tempfile.TemporaryDirectory() as folder:
        times = _times(Path(folder))
    whole, public = (statistics.median(times[name]) for name in ("whole", "public"))
    network = statistics.median(times["network"])
    return [
        *beside_speed.run(),
        at_most("one detection, 1280x720, 608x352 input, median", whole, "ms", MOST_MS),
        Figure("of that the network", network, "ms"),
        Figure("the same with eight bits", statistics.median(times["int8"]), "ms"),
        Figure("YOLOv8n-pose at 640x640", public, "ms"),
        at_most("one detection by YOLOv8n-pose", whole / public, "x", MOST_SHARE),
    ]


def _times(folder: Path) -> dict[str, list[float]]:
    """Milliseconds of each, measured in turns."""
    calls = _calls(folder)
    times: dict[str, list[float]] = {name: [] for name in calls}
    for number in range(N_RUNS + 3):
        for name, call in calls.items():
            begin = time.perf_counter()
            call()
            if number >= 3:
                times[name].append(1e3 * (time.perf_counter() - begin))
    return times


def _calls(folder: Path) -> dict[str, Callable[[], object]]:
    from snapfit.models.asset import find_asset
    from snapfit.models.camera import AZURE_KINECT_720P, RgbdCamera
    from snapfit.models.detector.card import (
        CARD_NAME,
        ONNX_NAME,
        CardClass,
        DetectorCard,
        write_card,
    )
    from snapfit.models.detector.export import export_onnx
    from snapfit.models.detector.network import PoseNetwork
    from snapfit.models.detector.quantise import write_int8
    from snapfit.models.detector.recipe import LEAN
    from snapfit.models.detector.size import YOLOV8N
    from snapfit.models.keypoints import keypoint_models
    from snapfit.tracking.detection.detector import Detector
    from snapfit.tracking.detection.onnx_model import OnnxModel
    from snapfit.tracking.frame import Frame

    parts = find_asset("nano-chuck").tracked_parts
    models = keypoint_models(parts)
    classes = tuple(CardClass(part=each.name, keypoints_m=each.points.tolist()) for each in models)
    card = DetectorCard(
        asset="nano-chuck", classes=classes, input_width_px=608, input_height_px=352
    )
    network = PoseNetwork(LEAN, len(parts), 17).eval()
    export_onnx(network, folder / ONNX_NAME)
    write_card(card, folder / CARD_NAME)
    rng = np.random.default_rng(0)
    blob = rng.random((1, 3, 352, 608), dtype=np.float32)
    write_int8(network, folder / "int8.onnx", [blob])
    export_onnx(PoseNetwork(YOLOV8N, 1, 17).eval(), folder / "public.onnx")
    one = card.model_copy(update={"classes": classes[:1]})
    detector = Detector(folder, parts, RgbdCamera(AZURE_KINECT_720P))
    color = rng.integers(0, 255, (720, 1280, 3), dtype=np.uint8)
    square = rng.random((1, 3, 640, 640), dtype=np.float32)
    plain = OnnxModel(folder / ONNX_NAME, card)
    int8 = OnnxModel(folder / "int8.onnx", card)
    public = OnnxModel(folder / "public.onnx", one)
    return {
        "whole": lambda: detector.detect(Frame("0", 0, color)),
        "network": lambda: plain.run(blob),
        "int8": lambda: int8.run(blob),
        "public": lambda: public.run(square),
    }
