"""Orbbec Femto and its kin by pyorbbecsdk: colour and depth apart, as the factory calibrated."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.tracking.sources.address import Address
from snapfit.tracking.sources.driver import CameraLostError, Images, LensedCamera, load_driver


class Orbbec:
    """A `CameraDriver`; the first camera that is found, or the one with a serial number."""

    def __init__(self, address: Address) -> None:
        """Loads the library.

        Raises:
            SourceError: it is not installed.
        """
        self._ob = load_driver("pyorbbecsdk", "orbbec", "pyorbbecsdk2")
        self._address = address
        self._pipeline: Any = None

    def open(self) -> LensedCamera:
        """As in `CameraDriver`."""
        ob, address = self._ob, self._address
        try:
            devices = ob.Context().query_devices()
            if not devices.get_count():
                raise CameraLostError("there is no Orbbec camera")
            device = (
                devices.get_device_by_serial_number(address.where)
                if address.where
                else devices.get_device_by_index(0)
            )
            pipeline, config = ob.Pipeline(device), ob.Config()
            color = self._profile(pipeline, ob.OBSensorType.COLOR_SENSOR)
            config.enable_stream(color)
            profiles = pipeline.get_stream_profile_list(ob.OBSensorType.DEPTH_SENSOR)
            config.enable_stream(profiles.get_default_video_stream_profile())
            config.set_frame_aggregate_output_mode(ob.OBFrameAggregateOutputMode.FULL_FRAME_REQUIRE)
            pipeline.start(config)
        except (ob.OBError, RuntimeError) as error:
            raise CameraLostError(f"no Orbbec {address.where} that can do this: {error}") from error
        self._pipeline = pipeline
        serial = device.get_device_info().get_serial_number()
        return self._described(pipeline, serial, float(color.get_fps()))

    def read(self, timeout_s: float) -> Images | None:
        """As in `CameraDriver`."""
        try:
            frames = self._pipeline.wait_for_frames(round(1e3 * timeout_s))
        except (self._ob.OBError, RuntimeError) as error:
            raise CameraLostError(str(error)) from error
        color = None if frames is None else frames.get_color_frame()
        if frames is None or color is None:
            return None
        return Images(self._color(color), self._depth(frames.get_depth_frame()))

    def close(self) -> None:
        """As in `CameraDriver`."""
        pipeline, self._pipeline = self._pipeline, None
        if pipeline is not None:
            with suppress(self._ob.OBError, RuntimeError):  # one that is gone cannot be stopped
                pipeline.stop()

    def _profile(self, pipeline: Any, sensor: Any) -> Any:
        address = self._address
        profiles = pipeline.get_stream_profile_list(sensor)
        width, height = address.width or 1280, address.height or 720
        return profiles.get_video_stream_profile(
            width, height, self._ob.OBFormat.RGB, address.fps or 30
        )

    def _color(self, frame: Any) -> npt.NDArray[np.uint8]:
        """The image as BGR; one whose bytes are too few stays as flat as it came, and is told."""
        data = np.asarray(frame.get_data(), dtype=np.uint8)
        height, width = frame.get_height(), frame.get_width()
        if data.size != height * width * 3:
            return data.reshape(1, -1).copy()
        shown = cv2.cvtColor(data.reshape(height, width, 3), cv2.COLOR_RGB2BGR)
        return np.asarray(shown, dtype=np.uint8)

    def _depth(self, frame: Any) -> npt.NDArray[np.uint16] | None:
        """In millimetres, whatever the camera's unit is."""
        if frame is None:
            return None
        height, width = frame.get_height(), frame.get_width()
        data = np.frombuffer(np.asarray(frame.get_data(), dtype=np.uint8).tobytes(), np.uint16)
        if data.size != height * width:
            return data.reshape(1, -1).copy()
        scale_mm = float(frame.get_depth_scale())
        image = data.reshape(height, width)
        if scale_mm == 1.0:
            return image.copy()
        millimetres = np.rint(np.minimum(image * scale_mm, 65534.0))
        return np.asarray(millimetres, dtype=np.uint16)

    def _described(self, pipeline: Any, serial: str, frame_rate_hz: float) -> LensedCamera:
        parameters = pipeline.get_camera_param()
        place = parameters.transform
        rotation = np.array(place.rot, dtype=np.float64).reshape(3, 3)
        translation_m = np.array(place.transform, dtype=np.float64).ravel() / 1000.0
        return LensedCamera(
            f"Orbbec {serial}",
            _pinhole(parameters.rgb_intrinsic),
            frame_rate_hz,
            _distortion(parameters.rgb_distortion),
            _pinhole(parameters.depth_intrinsic),
            _distortion(parameters.depth_distortion),
            0.001,
            Pose.from_rotation_translation(rotation, translation_m),
        )


def _pinhole(lens: Any) -> PinholeCamera:
    return PinholeCamera(lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy)


def _distortion(d: Any) -> tuple[float, ...]:
    """OpenCV's order."""
    return tuple(float(each) for each in (d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6))
