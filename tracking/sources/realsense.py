"""Intel RealSense by pyrealsense2: colour and depth apart, as the factory calibrated them."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.tracking.errors import SourceError
from snapfit.tracking.sources.address import Address
from snapfit.tracking.sources.driver import CameraLostError, Images, LensedCamera, load_driver

# librealsense's formulas for these three are OpenCV's, with the same coefficients.
_LIKE_OPENCV = ("brown_conrady", "inverse_brown_conrady", "modified_brown_conrady")
_DEPTH_SIZES = {True: (848, 480), False: (640, 480)}


class RealSense:
    """A `CameraDriver`; the first camera that is found, or the one with a serial number."""

    def __init__(self, address: Address) -> None:
        """Loads the library.

        Raises:
            SourceError: it is not installed.
        """
        self._rs = load_driver("pyrealsense2", "realsense", "pyrealsense2")
        self._address = address
        self._pipeline: Any = None

    def open(self) -> LensedCamera:
        """As in `CameraDriver`."""
        rs, address = self._rs, self._address
        width, height = address.width or 1280, address.height or 720
        fps = address.fps or 30
        config, pipeline = rs.config(), rs.pipeline()
        if address.where:
            config.enable_device(address.where)
        config.enable_stream(rs.stream.color, width, height, rs.format.bgr8, fps)
        # Wide depth beside wide colour: these sizes all D400 cameras have.
        is_wide = width * 3 > height * 4
        config.enable_stream(rs.stream.depth, *_DEPTH_SIZES[is_wide], rs.format.z16, fps)
        try:
            profile = pipeline.start(config)
        except RuntimeError as error:
            raise CameraLostError(
                f"no RealSense {address.where} that can do this: {error}"
            ) from error
        self._pipeline = pipeline
        return self._described(profile, fps)

    def read(self, timeout_s: float) -> Images | None:
        """As in `CameraDriver`."""
        try:
            is_there, frames = self._pipeline.try_wait_for_frames(round(1e3 * timeout_s))
        except RuntimeError as error:
            raise CameraLostError(str(error)) from error
        if not is_there:
            return None
        color, depth = frames.get_color_frame(), frames.get_depth_frame()
        if not color:
            return None
        # The library takes its buffers back: these are copies.
        shown = np.array(color.get_data(), dtype=np.uint8)
        return Images(shown, np.array(depth.get_data(), dtype=np.uint16) if depth else None)

    def close(self) -> None:
        """As in `CameraDriver`."""
        pipeline, self._pipeline = self._pipeline, None
        if pipeline is not None:
            with suppress(RuntimeError):  # a camera that is gone cannot be stopped
                pipeline.stop()

    def _described(self, profile: Any, fps: int) -> LensedCamera:
        rs = self._rs
        device = profile.get_device()
        info = rs.camera_info
        name = f"{device.get_info(info.name)} {device.get_info(info.serial_number)}"
        color = profile.get_stream(rs.stream.color).as_video_stream_profile()
        depth = profile.get_stream(rs.stream.depth).as_video_stream_profile()
        place = depth.get_extrinsics_to(color)
        # Column by column.
        rotation = np.array(place.rotation, dtype=np.float64).reshape(3, 3).T
        color_lens, depth_lens = color.get_intrinsics(), depth.get_intrinsics()
        return LensedCamera(
            name,
            _pinhole(color_lens),
            float(fps),
            _distortion(name, color_lens),
            _pinhole(depth_lens),
            _distortion(name, depth_lens),
            float(device.first_depth_sensor().get_depth_scale()),
            Pose.from_rotation_translation(rotation, np.array(place.translation)),
        )


def _pinhole(lens: Any) -> PinholeCamera:
    return PinholeCamera(lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy)


def _distortion(name: str, lens: Any) -> tuple[float, ...]:
    """OpenCV's coefficients.

    Raises:
        SourceError: the lens is described by a model that OpenCV has not.
    """
    coefficients = tuple(float(each) for each in lens.coeffs)
    if not any(coefficients) or lens.model.name in _LIKE_OPENCV:
        return coefficients
    raise SourceError(f"{name}: its distortion {lens.model.name} is not supported")
