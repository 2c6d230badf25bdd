"""Azure Kinect by pyk4a: colour and depth apart, as the factory calibrated them."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.tracking.errors import SourceError
from snapfit.tracking.sources.address import Address
from snapfit.tracking.sources.driver import CameraLostError, Images, LensedCamera, load_driver

_COLOR_SIZES = {
    (1280, 720): "RES_720P",
    (1920, 1080): "RES_1080P",
    (2560, 1440): "RES_1440P",
    (2048, 1536): "RES_1536P",
    (3840, 2160): "RES_2160P",
}
_RATES = (5, 15, 30)
# Of the depth mode NFOV_UNBINNED: the most exact one, up to 3.9 m.
_DEPTH_SIZE = (640, 576)


class AzureKinect:
    """A `CameraDriver`; the first camera that is found, or the one with a serial number."""

    def __init__(self, address: Address) -> None:
        """Loads the library.

        Raises:
            SourceError: it is not installed, or the camera has no such mode.
        """
        self._k4a = load_driver("pyk4a", "kinect", "pyk4a")
        self._size = (address.width or 1280, address.height or 720)
        self._fps = address.fps or 30
        if self._size not in _COLOR_SIZES or self._fps not in _RATES:
            sizes = ", ".join(f"{width}x{height}" for width, height in _COLOR_SIZES)
            raise SourceError(f"{address.text}: an Azure Kinect has {sizes}, at 5, 15 or 30 fps")
        self._serial = address.where
        self._device: Any = None

    def open(self) -> LensedCamera:
        """As in `CameraDriver`."""
        k4a = self._k4a
        config = k4a.Config(
            color_resolution=getattr(k4a.ColorResolution, _COLOR_SIZES[self._size]),
            color_format=k4a.ImageFormat.COLOR_BGRA32,
            depth_mode=k4a.DepthMode.NFOV_UNBINNED,
            camera_fps=getattr(k4a.FPS, f"FPS_{self._fps}"),
            synchronized_images_only=True,
        )
        for number in range(k4a.connected_device_count()):
            device = k4a.PyK4A(config, device_id=number)
            try:
                device.open()
                if self._serial in ("", device.serial):
                    device.start()
                    self._device = device
                    return self._described(device)
                device.close()
            except k4a.K4AException as error:
                raise CameraLostError(f"Azure Kinect {number} does not start: {error!r}") from error
        raise CameraLostError(f"there is no Azure Kinect {self._serial}")

    def read(self, timeout_s: float) -> Images | None:
        """As in `CameraDriver`."""
        try:
            capture = self._device.get_capture(timeout=round(1e3 * timeout_s))
        except self._k4a.K4ATimeoutException:
            return None
        except self._k4a.K4AException as error:
            raise CameraLostError(f"does not answer: {error!r}") from error
        if capture.color is None:
            return None
        color = np.ascontiguousarray(capture.color[..., :3], dtype=np.uint8)
        depth = capture.depth
        return Images(color, None if depth is None else np.array(depth, dtype=np.uint16))

    def close(self) -> None:
        """As in `CameraDriver`."""
        device, self._device = self._device, None
        if device is not None:
            with suppress(self._k4a.K4AException):  # a camera that is gone cannot be stopped
                device.stop()

    def _described(self, device: Any) -> LensedCamera:
        kinds, calibration = self._k4a.CalibrationType, device.calibration

        def lens(kind: Any, size: tuple[int, int]) -> tuple[PinholeCamera, tuple[float, ...]]:
            k = calibration.get_camera_matrix(kind)
            coefficients = calibration.get_distortion_coefficients(kind)
            numbers = (float(k[0][0]), float(k[1][1]), float(k[0][2]), float(k[1][2]))
            return PinholeCamera(*size, *numbers), tuple(float(each) for each in coefficients)

        color, color_distortion = lens(kinds.COLOR, self._size)
        depth, depth_distortion = lens(kinds.DEPTH, _DEPTH_SIZE)
        return LensedCamera(
            f"Azure Kinect {device.serial}",
            color,
            float(self._fps),
            color_distortion,
            depth,
            depth_distortion,
            0.001,
            _color_from_depth(calibration),
        )


def _color_from_depth(calibration: Any) -> Pose:
    """From where the calibration puts four points, mm."""
    corners = [(0.0, 0.0, 1000.0), (1000.0, 0.0, 1000.0), (0.0, 1000.0, 1000.0), (0.0, 0.0, 2000.0)]
    at = np.array([calibration.depth_to_color_3d(corner) for corner in corners]) / 1000.0
    rotation = (at[1:] - at[0]).T
    u, _, vt = np.linalg.svd(rotation)
    turned = u @ vt
    return Pose.from_rotation_translation(turned, at[0] - turned @ np.array([0.0, 0.0, 1.0]))
