"""A detector's ONNX file in ONNX Runtime: loaded, checked against its card, and run."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.detector.card import DetectorCard
from snapfit.models.errors import DetectorError
from snapfit.tracking.detection.parameters import CPU
from snapfit.tracking.errors import TrackingError

_TYPES = {"tensor(float)": np.float32, "tensor(float16)": np.float16}


class OnnxModel:
    """A network in the public layout of Ultralytics' YOLOv8 and YOLO11 pose models.

    Attributes:
        path: of the file.
        card: what its classes and keypoints are.
        input_size: width and height that the file fixes, px; None where they are free.
        provider: of ONNX Runtime that runs it.
    """

    def __init__(
        self,
        path: Path,
        card: DetectorCard,
        *,
        providers: Sequence[str] = (CPU,),
        threads: int = 0,
    ) -> None:
        """Loads the network.

        Args:
            path: of the `.onnx` file.
            card: its `detector.json`.
            providers: of ONNX Runtime; those that are not there are passed over.
            threads: of the CPU; 0: one a core.

        Raises:
            DetectorError: the file is missing, no ONNX, or of another layout than the card says.
            TrackingError: none of the providers is there.
        """
        self.path, self.card = path, card
        self._session = _session(path, providers, threads)
        self.provider: str = self._session.get_providers()[0]
        self._input, self.input_size = self._checked_input()
        self._check_output()

    def run(self, blob: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """(rows, A) of an input (1, 3, H, W): 4 of the box, classes, 3 for each keypoint.

        Raises:
            DetectorError: the network cannot run, or its output is of another shape.
        """
        try:
            given = {self._input.name: blob.astype(_TYPES[self._input.type], copy=False)}
            output = self._session.run(None, given)[0]
        except _runtime_errors() as error:
            raise DetectorError(self.path, f"does not run: {_first_line(error)}") from error
        if output.ndim != 3 or len(output) != 1:
            raise DetectorError(self.path, _layout_problem(list(output.shape), self.card))
        self._check_rows(output.shape)
        rows: npt.NDArray[np.float32] = output[0].astype(np.float32, copy=False)
        return rows

    def _checked_input(self) -> tuple[Any, tuple[int, int] | None]:
        inputs = self._session.get_inputs()
        if len(inputs) != 1 or len(inputs[0].shape) != 4 or inputs[0].shape[1] not in (3, None):
            shapes = [each.shape for each in inputs]
            problem = f"takes {shapes}: a detector takes one image [1, 3, height, width]"
            raise DetectorError(self.path, problem)
        if inputs[0].type not in _TYPES:
            problem = f"takes {inputs[0].type}: a detector takes float or float16"
            raise DetectorError(self.path, problem)
        height, width = inputs[0].shape[2:]
        is_fixed = isinstance(height, int) and isinstance(width, int)
        return inputs[0], (width, height) if is_fixed else None

    def _check_output(self) -> None:
        shape = self._session.get_outputs()[0].shape
        if len(shape) != 3:
            raise DetectorError(self.path, _layout_problem(shape, self.card))
        self._check_rows(shape)

    def _check_rows(self, shape: Sequence[Any]) -> None:
        if isinstance(shape[1], int) and shape[1] != self.card.n_rows:
            raise DetectorError(self.path, _layout_problem(list(shape), self.card))


def _session(path: Path, providers: Sequence[str], threads: int) -> Any:
    try:
        import onnxruntime
    except ImportError as error:
        problem = f"finding parts needs ONNX Runtime, which cannot be loaded: {error}"
        raise TrackingError(problem) from error
    there = onnxruntime.get_available_providers()
    chosen = [name for name in providers if name in there]
    if not chosen:
        problem = f"ONNX Runtime has no {' or '.join(providers)} here; it has {', '.join(there)}"
        raise TrackingError(problem)
    if not path.is_file():
        problem = "is missing: snapfit train makes one, or put an exported YOLOv8-pose there"
        raise DetectorError(path, problem)
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads or os.cpu_count() or 1
    # Threads that spin between two images would take the cores from the tracker.
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    options.log_severity_level = 3
    wanted = list(dict.fromkeys([*chosen, CPU]))
    try:
        return onnxruntime.InferenceSession(str(path), options, providers=wanted)
    except _runtime_errors() as error:
        raise DetectorError(path, f"is no ONNX file that runs: {_first_line(error)}") from error


def _runtime_errors() -> tuple[type[Exception], ...]:
    """What ONNX Runtime raises; its errors have no common base but `Exception`."""
    from onnxruntime.capi import onnxruntime_pybind11_state as state

    names = (
        "EPFail",
        "Fail",
        "InvalidArgument",
        "InvalidGraph",
        "InvalidProtobuf",
        "NoModel",
        "NotImplemented",
        "RuntimeException",
    )
    return (ValueError, *(getattr(state, name) for name in names))


def _layout_problem(shape: Sequence[Any], card: DetectorCard) -> str:
    n_classes, n_keypoints = len(card.classes), card.n_keypoints
    rows = f"4 + {n_classes} classes + 3 x {n_keypoints} keypoints = {card.n_rows}"
    problem = f"its output is {list(shape)}, by detector.json it is [1, {rows}, anchors]"
    if len(shape) != 3:
        return f"{problem}: is it a pose network in the layout of YOLOv8 or YOLO11?"
    if shape[2] == 6 + 3 * n_keypoints:
        return f"{problem}: export it without NMS and not end to end"
    if isinstance(shape[1], int):
        over = shape[1] - 4 - 3 * n_keypoints
        if over > 0:
            return f"{problem}; with as many keypoints it would have {over} classes"
    return f"{problem}: give it the detector.json of its own training set"


def _first_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[0][:200] if lines else type(error).__name__
