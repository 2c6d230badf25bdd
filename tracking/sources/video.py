"""USB cameras (UVC) and network cameras (RTSP) by OpenCV: colour alone, calibrated by a file."""

from __future__ import annotations

import time
from typing import Any

import cv2
import numpy as np

from snapfit.models.camera_file import CameraFile
from snapfit.tracking.sources.address import Address
from snapfit.tracking.sources.driver import CameraLostError, Images, LensedCamera

_NETWORK_TIMEOUT_MS = 5000
_USUAL_HZ = 30.0
_FASTEST_HZ = 1000.0


class VideoCamera:
    """A `CameraDriver` for what OpenCV's `VideoCapture` opens."""

    def __init__(self, address: Address, calibration: CameraFile) -> None:
        """Takes note of the camera.

        Args:
            address: of kind "uvc" or "rtsp".
            calibration: of this camera, at the size that it is to deliver.
        """
        self._address, self._calibration = address, calibration
        self._capture: Any = None

    def open(self) -> LensedCamera:
        """As in `CameraDriver`."""
        self._capture = capture = open_video(self._address, self._calibration)
        if not capture.isOpened():
            raise CameraLostError(f"{self._address.text}: there is no such camera, or it is in use")
        told_hz = float(capture.get(cv2.CAP_PROP_FPS))
        frame_rate_hz = told_hz if 0 < told_hz <= _FASTEST_HZ else _USUAL_HZ
        file = self._calibration
        return LensedCamera(self._address.text, file.camera, frame_rate_hz, file.distortion)

    def read(self, timeout_s: float) -> Images | None:
        """As in `CameraDriver`; a camera that is gone shows by delivering nothing."""
        begin_s = time.monotonic()
        is_there, image = self._capture.read()
        if is_there and image is not None:
            return Images(np.asarray(image, dtype=np.uint8))
        if not self._capture.isOpened():
            raise CameraLostError("the connection is closed")
        # It failed at once: not to be asked again without a pause.
        time.sleep(max(0.0, min(timeout_s, 0.1) - (time.monotonic() - begin_s)))
        return None

    def close(self) -> None:
        """As in `CameraDriver`."""
        capture, self._capture = self._capture, None
        if capture is not None:
            capture.release()


def open_video(address: Address, calibration: CameraFile | None = None) -> Any:
    """OpenCV's capture of a camera, opened or not.

    Args:
        address: of kind "uvc" or "rtsp".
        calibration: whose size is asked for where the address says none.
    """
    if address.kind == "rtsp":
        timeouts = [
            *(cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, _NETWORK_TIMEOUT_MS),
            *(cv2.CAP_PROP_READ_TIMEOUT_MSEC, _NETWORK_TIMEOUT_MS),
        ]
        return cv2.VideoCapture(address.where, cv2.CAP_FFMPEG, timeouts)
    number = int(address.where) if address.where.isdecimal() else address.where
    capture = cv2.VideoCapture(number)
    width, height = address.width, address.height
    if width is None and calibration is not None:
        width, height = calibration.width, calibration.height
    for key, value in (
        (cv2.CAP_PROP_FRAME_WIDTH, width),
        (cv2.CAP_PROP_FRAME_HEIGHT, height),
        (cv2.CAP_PROP_FPS, address.fps),
        # What waits in a buffer is old.
        (cv2.CAP_PROP_BUFFERSIZE, 1),
    ):
        if value is not None:
            capture.set(key, float(value))
    return capture
