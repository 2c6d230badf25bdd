"""`yolov8pose` as a method of its own: each frame by itself, nothing is remembered."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from snapfit.models.asset import Part
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.detection.detector import Detection, Detector
from snapfit.tracking.detection.parameters import DetectorParameters, RangeParameters
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame, fitting_frames
from snapfit.tracking.result import PartEstimate, Status, TrackingResult


class FrameByFrame:
    """Finds all parts anew in every frame, by the members of a tracker.

    Attributes:
        names: of the parts, in order.
        camera: where the frames come from.
        cameras: the same: of several, only the first is looked at.
    """

    def __init__(self, names: tuple[str, ...], camera: RgbdCamera, detector: Detector) -> None:
        """A method that needs no start.

        Raises:
            TrackingError: the detector knows none of the parts.
        """
        if not set(names) & set(detector.names):
            raise TrackingError(f"the detector finds {', '.join(detector.names)}: none is wanted")
        self.names, self.camera, self.cameras = names, camera, (camera,)
        self._detector = detector

    def start(
        self, frame: Frame, camera_from_body: Mapping[str, Pose], *others: Frame | None
    ) -> None:
        """Does nothing with the poses: they are found in the frame itself.

        Raises:
            TrackingError: a part that is not tracked.
        """
        del frame, others
        for name in camera_from_body:
            if name not in self.names:
                known = ", ".join(self.names)
                raise TrackingError(f"there is no part {name!r} to start; the parts are {known}")

    def set_state(self, state: str) -> None:
        """Does nothing: the assembly state is not looked at."""

    def track(self, frame: Frame | None, *others: Frame | None) -> TrackingResult:
        """Finds the parts; those that are not found are `searching`. One camera is looked at.

        Raises:
            FrameError: the frame does not fit the camera.
            TrackingError: there is no frame.
        """
        del others
        begin = time.perf_counter()
        frames, _ = fitting_frames((frame,), self.cameras)
        shown = frames[0]
        if shown is None:
            raise TrackingError("the camera has no frame")
        found = self._detector.detect(shown).best()
        parts = tuple(_estimate(name, found.get(name)) for name in self.names)
        duration_ms = 1e3 * (time.perf_counter() - begin)
        return TrackingResult(shown.name, shown.captured_at_ns, parts, duration_ms)


def open_frame_by_frame(
    folder: Path, parts: Sequence[Part], camera: RgbdCamera, *, uses_depth: bool
) -> FrameByFrame:
    """The method with the network in a folder.

    Args:
        folder: that holds `detector.onnx` and `detector.json`.
        parts: that are to be found.
        camera: where the frames come from.
        uses_depth: whether measured depth fixes a part's distance.

    Raises:
        DetectorError: a file is missing, damaged, or does not fit the other.
        TrackingError: the network knows none of the parts, or ONNX Runtime cannot be used.
    """
    parameters = DetectorParameters(range=RangeParameters() if uses_depth else None)
    detector = Detector(folder, parts, camera, parameters)
    return FrameByFrame(tuple(part.name for part in parts), camera, detector)


def _estimate(name: str, found: Detection | None) -> PartEstimate:
    if found is None:
        return PartEstimate(name, Status.SEARCHING, 0.0, None)
    return PartEstimate(
        name,
        Status.TRACKED,
        found.confidence,
        found.camera_from_body,
        visibility=float(np.mean(found.is_inlier)),
    )
