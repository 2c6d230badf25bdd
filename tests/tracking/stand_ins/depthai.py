"""Stands in for depthai 3: the classes and functions of its documentation that are used."""

from __future__ import annotations

import datetime
from types import SimpleNamespace
from typing import Any

from scripts import Script

script = Script()
script.size = script.depth_size = (64, 48)
CameraBoardSocket = SimpleNamespace(CAM_A="A", CAM_B="B", CAM_C="C")
ImgFrame = SimpleNamespace(Type=SimpleNamespace(BGR888i="bgr"))
asked: dict[str, Any] = {}


class DeviceInfo:
    def __init__(self, where: str) -> None:
        self.where = where


class Device:
    def __init__(self, info: DeviceInfo | None = None) -> None:
        if not script.is_there or (info is not None and info.where != script.serial):
            raise RuntimeError("No available devices")

    def getDeviceId(self) -> str:
        return script.serial

    def readCalibration(self) -> SimpleNamespace:
        def intrinsics(socket: str, width: int, height: int) -> list[list[float]]:
            assert socket == "A"
            f = script.focal_px
            return [[f, 0.0, width / 2], [0.0, f + 1, height / 2], [0.0, 0.0, 1.0]]

        return SimpleNamespace(getCameraIntrinsics=intrinsics)


class _Output:
    def __init__(self, what: str) -> None:
        self.what = what

    def link(self, other: _Output) -> None:
        asked.setdefault("links", []).append((self.what, other.what))

    def createOutputQueue(self, maxSize: int, blocking: bool) -> SimpleNamespace:
        assert (maxSize, blocking) == (1, False)
        return SimpleNamespace(get=_get)


def _get(timeout: datetime.timedelta) -> dict[str, Any] | None:
    if not script.is_there:
        raise RuntimeError("Communication exception - X_LINK_ERROR")
    if not script.wait(1e3 * timeout.total_seconds()):
        return None
    color, depth = script.next_color(), script.next_depth()
    return {
        "color": SimpleNamespace(getCvFrame=lambda: color),
        "depth": SimpleNamespace(getFrame=lambda: depth),
    }


class _Camera:
    def build(self, socket: str) -> _Camera:
        self.socket = socket
        return self

    def requestOutput(self, size: tuple[int, int], *kind: str, **given: Any) -> _Output:
        if self.socket == "A":
            asked["color"] = (size, *kind, given)
        return _Output(self.socket)


class _StereoDepth:
    depth = _Output("depth")

    def build(self, left: _Output, right: _Output) -> _StereoDepth:
        assert (left.what, right.what) == ("B", "C")
        return self

    def setLeftRightCheck(self, enable: bool) -> None:
        assert enable

    def setSubpixel(self, enable: bool) -> None:
        assert enable

    def setDepthAlign(self, camera: str) -> None:
        asked["align"] = camera

    def setOutputSize(self, width: int, height: int) -> None:
        asked["depth"] = (width, height)


class _Sync:
    def __init__(self) -> None:
        self.inputs = {name: _Output(name) for name in ("color", "depth")}
        self.out = _Output("out")


node = SimpleNamespace(Camera=_Camera, StereoDepth=_StereoDepth, Sync=_Sync)


class Pipeline:
    def __init__(self, device: Device) -> None:
        assert isinstance(device, Device)
        asked.clear()

    def create(self, kind: type) -> Any:
        return kind()

    def start(self) -> None:
        script.opened += 1

    def stop(self) -> None:
        script.closed += 1
        if not script.is_there:
            raise RuntimeError("device is gone")
