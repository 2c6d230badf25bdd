"""Stands in for pyk4a: the classes and functions of its documentation that are used."""

from __future__ import annotations

from enum import Enum
from types import SimpleNamespace
from typing import Any

import numpy as np
from scripts import Script

script = Script()
script.size, script.depth_size, script.focal_px = (1280, 720), (640, 576), 600.0
COEFFICIENTS = [0.4, -2.5, 0.001, -0.0002, 1.4, 0.3, -2.3, 1.3]
TURN = np.array([[1.0, 0.0, 0.0], [0.0, 0.995, 0.0998], [0.0, -0.0998, 0.995]])
SHIFT_MM = np.array([-32.0, -2.0, 4.0])
ColorResolution = Enum("ColorResolution", ["RES_720P", "RES_1080P"])
ImageFormat = Enum("ImageFormat", ["COLOR_BGRA32"])
DepthMode = Enum("DepthMode", ["NFOV_UNBINNED"])
FPS = Enum("FPS", ["FPS_5", "FPS_15", "FPS_30"])
CalibrationType = Enum("CalibrationType", ["DEPTH", "COLOR"])


class K4AException(Exception):  # noqa: N818
    pass


class K4ATimeoutException(K4AException):
    pass


class Config:
    def __init__(self, **given: Any) -> None:
        assert given["synchronized_images_only"]
        self.given = given


def connected_device_count() -> int:
    return int(script.is_there)


class _Calibration:
    def get_camera_matrix(self, kind: CalibrationType) -> np.ndarray:
        f = script.focal_px if kind is CalibrationType.COLOR else script.focal_px / 1.2
        return np.array([[f, 0, 318.5], [0, f + 1, 240.5], [0, 0, 1]])

    def get_distortion_coefficients(self, kind: CalibrationType) -> np.ndarray:
        return np.array(COEFFICIENTS) * (1.0 if kind is CalibrationType.COLOR else 0.5)

    def depth_to_color_3d(self, point_3d: tuple[float, float, float]) -> tuple[float, ...]:
        return tuple(TURN @ np.array(point_3d) + SHIFT_MM)


class PyK4A:
    calibration = _Calibration()

    def __init__(self, config: Config, device_id: int = 0) -> None:
        self.config, self.device_id = config, device_id

    @property
    def serial(self) -> str:
        return script.serial

    def open(self) -> None:
        if not script.is_there:
            raise K4AException
        script.opened += 1

    def start(self) -> None:
        """Streams."""

    def get_capture(self, timeout: int = -1) -> SimpleNamespace:
        if not script.is_there:
            raise K4AException
        if not script.wait(timeout):
            raise K4ATimeoutException
        bgr = script.next_color()
        bgra = np.dstack([bgr, np.full(bgr.shape[:2], 255, np.uint8)])
        return SimpleNamespace(color=bgra, depth=script.next_depth())

    def stop(self) -> None:
        script.closed += 1
        if not script.is_there:
            raise K4AException

    close = stop
