"""Stands in for pyorbbecsdk: the classes and functions of its documentation that are used."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from scripts import Script

script = Script()
OBSensorType = SimpleNamespace(COLOR_SENSOR="color", DEPTH_SENSOR="depth")
OBFormat = SimpleNamespace(RGB="rgb")
OBFrameAggregateOutputMode = SimpleNamespace(FULL_FRAME_REQUIRE="full")
PLACE = SimpleNamespace(
    rot=np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], dtype=np.float32),
    transform=np.array([32.0, 1.0, -2.0], dtype=np.float32),
)
DEPTH_SCALE_MM = 0.5
asked: dict[str, Any] = {}


class OBError(Exception):
    pass


class Context:
    def query_devices(self) -> SimpleNamespace:
        def by_serial(serial: str) -> str:
            if serial != script.serial:
                raise OBError(f"device {serial} not found")
            return device

        info = SimpleNamespace(get_serial_number=lambda: script.serial)
        device: Any = SimpleNamespace(get_device_info=lambda: info)
        return SimpleNamespace(
            get_count=lambda: int(script.is_there),
            get_device_by_serial_number=by_serial,
            get_device_by_index=lambda _index: device,
        )


class Config:
    def enable_stream(self, profile: Any) -> None:
        assert profile is not None

    def set_frame_aggregate_output_mode(self, mode: str) -> None:
        assert mode == "full"


class _Frame:
    def __init__(self, data: np.ndarray) -> None:
        self._data = data

    def get_width(self) -> int:
        return self._data.shape[1]

    def get_height(self) -> int:
        return self._data.shape[0]

    def get_data(self) -> np.ndarray:
        data = np.frombuffer(self._data.tobytes(), np.uint8)
        return data[: len(data) // 2] if script.half else data

    def get_depth_scale(self) -> float:
        return DEPTH_SCALE_MM


script.half = False  # type: ignore[attr-defined]


class Pipeline:
    def __init__(self, device: Any) -> None:
        assert device.get_device_info().get_serial_number() == script.serial

    def get_stream_profile_list(self, sensor: str) -> SimpleNamespace:
        def video(width: int, height: int, kind: str, fps: int) -> SimpleNamespace:
            asked.update(size=(width, height), kind=kind)
            return SimpleNamespace(get_fps=lambda: fps)

        return SimpleNamespace(
            get_video_stream_profile=video,
            get_default_video_stream_profile=lambda: SimpleNamespace(sensor=sensor),
        )

    def start(self, _config: Config) -> None:
        script.opened += 1

    def get_camera_param(self) -> SimpleNamespace:
        def lens(size: tuple[int, int], f: float) -> SimpleNamespace:
            width, height = size
            return SimpleNamespace(width=width, height=height, fx=f, fy=f, cx=31.0, cy=23.0)

        d = {"k1": 0.1, "k2": 0.2, "p1": 0.3, "p2": 0.4, "k3": 0.5, "k4": 0.6, "k5": 0.7, "k6": 0.8}
        return SimpleNamespace(
            rgb_intrinsic=lens(script.size, script.focal_px),
            depth_intrinsic=lens(script.depth_size, script.focal_px / 2),
            rgb_distortion=SimpleNamespace(**d),
            depth_distortion=SimpleNamespace(**dict.fromkeys(d, 0.0)),
            transform=PLACE,
        )

    def wait_for_frames(self, timeout_ms: int) -> SimpleNamespace | None:
        if not script.is_there:
            raise OBError("device disconnected")
        if not script.wait(timeout_ms):
            return None
        color = _Frame(np.ascontiguousarray(script.next_color()[..., ::-1]))
        depth = _Frame(script.next_depth())
        return SimpleNamespace(get_color_frame=lambda: color, get_depth_frame=lambda: depth)

    def stop(self) -> None:
        script.closed += 1
        if not script.is_there:
            raise OBError("device disconnected")
