"""Stands in for pyrealsense2: the classes and functions of its documentation that are used."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from scripts import Script

script = Script()
EXTRINSICS = SimpleNamespace(
    # Column by column: 90 degrees about z.
    rotation=[0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    translation=[0.015, 0.001, -0.002],
)
COEFFICIENTS = [-0.05, 0.02, 0.001, -0.001, 0.0]
stream = SimpleNamespace(color="color", depth="depth")
format = SimpleNamespace(bgr8="bgr8", z16="z16")  # noqa: A001
camera_info = SimpleNamespace(name="name", serial_number="serial")
distortion = SimpleNamespace(name="inverse_brown_conrady")
asked: dict[str, Any] = {}


class config:  # noqa: N801
    def __init__(self) -> None:
        asked.clear()

    def enable_device(self, serial: str) -> None:
        asked["serial"] = serial

    def enable_stream(self, which: str, width: int, height: int, kind: str, fps: int) -> None:
        asked[which] = (width, height, kind, fps)
        if which == "color":
            script.size = (width, height)
        else:
            script.depth_size = (width, height)


class _Profile:
    def __init__(self, which: str) -> None:
        self.which = which

    def as_video_stream_profile(self) -> _Profile:
        return self

    def get_intrinsics(self) -> SimpleNamespace:
        width, height = script.size if self.which == "color" else script.depth_size
        coeffs = COEFFICIENTS if self.which == "color" else [0.0] * 5
        f = script.focal_px * (1.0 if self.which == "color" else 0.5)
        return SimpleNamespace(
            width=width,
            height=height,
            fx=f,
            fy=f + 1,
            model=distortion,
            ppx=width / 2 - 0.5,
            ppy=height / 2 - 0.5,
            coeffs=coeffs,
        )

    def get_extrinsics_to(self, other: _Profile) -> SimpleNamespace:
        assert (self.which, other.which) == ("depth", "color")
        return EXTRINSICS


class _Device:
    def get_info(self, key: str) -> str:
        return {"name": "Stand-in D435", "serial": script.serial}[key]

    def first_depth_sensor(self) -> SimpleNamespace:
        return SimpleNamespace(get_depth_scale=lambda: 0.00025)


class pipeline:  # noqa: N801
    def start(self, _config: config) -> SimpleNamespace:
        if not script.is_there or asked.get("serial", script.serial) != script.serial:
            raise RuntimeError("No device connected")
        script.opened += 1
        return SimpleNamespace(get_device=_Device, get_stream=_Profile)

    def try_wait_for_frames(self, timeout_ms: int = 5000) -> tuple[bool, Any]:
        if not script.is_there:
            raise RuntimeError("Device disconnected")
        if not script.wait(timeout_ms):
            return False, None
        color, depth = script.next_color(), script.next_depth()
        frames = SimpleNamespace(
            get_color_frame=lambda: SimpleNamespace(get_data=lambda: color),
            get_depth_frame=lambda: SimpleNamespace(get_data=lambda: depth),
        )
        return True, frames

    def stop(self) -> None:
        script.closed += 1
        if not script.is_there:
            raise RuntimeError("stop() cannot be called before start()")
