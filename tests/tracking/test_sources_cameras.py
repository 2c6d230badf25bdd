"""Cameras as sources, each by a stand-in of its driver: what they deliver, and what goes wrong."""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from patience import within

sys.path.insert(0, str(Path(__file__).parent / "stand_ins"))

from snapfit.models.asset import find_asset
from snapfit.models.camera_file import CameraFile, write_camera_file
from snapfit.models.errors import CameraError
from snapfit.tracking.errors import FrameError, SourceError
from snapfit.tracking.sources import live as live_module
from snapfit.tracking.sources import open_any
from snapfit.tracking.sources.base import is_live
from snapfit.tracking.sources.live import LiveCamera, LiveTimes

KINDS = {
    "realsense": "pyrealsense2",
    "kinect": "pyk4a",
    "orbbec": "pyorbbecsdk",
    "oak": "depthai",
}
# As the real ones, and quicker.
TIMES = LiveTimes(
    read_s=0.05, answer_s=0.2, silent_s=0.3, first_delay_s=0.02, longest_delay_s=0.05, close_s=60.0
)


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def driver(kind: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The stand-in, afresh."""
    monkeypatch.setattr(live_module, "LiveTimes", lambda: TIMES)
    name = KINDS[kind]
    sys.modules.pop(name, None)
    yield importlib.import_module(name)
    sys.modules.pop(name, None)


def address(kind: str, serial: str = "") -> str:
    size = "" if kind == "kinect" else "?width=64&height=48"
    return f"{kind}:{serial}{size}"


def frame_within(source: LiveCamera, limit_s: float = 5.0):
    give_up_at_s = time.monotonic() + within(limit_s)
    while True:
        try:
            return source.read()
        except FrameError:
            assert time.monotonic() < give_up_at_s


def problem_of(source: LiveCamera, holds: Callable[[str], bool], limit_s: float = 5.0) -> str:
    """The first problem of this kind."""
    give_up_at_s = time.monotonic() + within(limit_s)
    told = ""
    while time.monotonic() < give_up_at_s:
        try:
            source.read()
        except FrameError as error:
            told = error.problem
            if holds(told):
                return told
    raise AssertionError(f"not told; the last: {told}")


def test_frames_come_with_what_the_driver_says_of_the_camera(kind: str, driver: ModuleType) -> None:
    asset = find_asset("hobby-corner-clamp")
    opened_ns = time.monotonic_ns()
    with closing(open_any(address(kind), asset)) as source:
        assert is_live(source)
        assert source.parts == asset.tracked_parts
        assert source.frame_rate_hz == 30.0
        camera = source.camera
        assert camera.color.fx == driver.script.focal_px
        assert (camera.color.width, camera.color.height) == driver.script.size
        frame = frame_within(source)
        assert frame.color.shape == (*driver.script.size[::-1], 3)
        assert frame.color.dtype == np.uint8
        assert frame.depth.shape == driver.script.depth_size[::-1]
        assert frame.depth.dtype == np.uint16
        assert opened_ns <= frame.captured_at_ns <= time.monotonic_ns()
        later = frame_within(source)
        assert later.captured_at_ns > frame.captured_at_ns
    assert driver.script.closed == 1
    assert source.read() is None


def test_a_camera_is_chosen_by_its_serial_number(kind: str, driver: ModuleType) -> None:
    driver.script.serial = "4711"
    with closing(open_any(address(kind, "4711"))) as source:
        assert frame_within(source) is not None
    with pytest.raises(SourceError, match="0815"):
        open_any(address(kind, "0815"))


def test_a_camera_that_is_not_there_is_refused_at_the_start(kind: str, driver: ModuleType) -> None:
    driver.script.is_there = False
    with pytest.raises(SourceError, match="no "):
        open_any(address(kind))


def test_a_camera_that_goes_away_is_taken_up_again(kind: str, driver: ModuleType) -> None:
    with closing(open_any(address(kind))) as source:
        frame_within(source)
        driver.script.is_there = False
        assert problem_of(source, lambda told: "is gone" in told and "looking for it" in told)
        opened = driver.script.opened
        driver.script.is_there = True
        assert frame_within(source) is not None
        assert driver.script.opened > opened


def test_another_camera_in_its_place_is_not_taken(kind: str, driver: ModuleType) -> None:
    focal_px = driver.script.focal_px
    with closing(open_any(address(kind))) as source:
        frame_within(source)
        driver.script.is_there = False
        problem_of(source, lambda told: "is gone" in told)
        driver.script.focal_px, driver.script.is_there = focal_px + 5, True
        assert problem_of(source, lambda told: "another camera answers" in told)
        driver.script.focal_px = focal_px
        assert frame_within(source) is not None


def test_a_camera_that_is_silent_is_told_and_connected_anew(kind: str, driver: ModuleType) -> None:
    with closing(open_any(address(kind))) as source:
        frame_within(source)
        opened = driver.script.opened
        driver.script.is_silent = True
        assert problem_of(source, lambda told: "has delivered nothing for 0.3 s" in told)
        driver.script.is_silent = False
        assert frame_within(source) is not None
        assert driver.script.opened > opened


def frozen(script, height: int, width: int) -> None:
    script.color = np.random.default_rng(1).integers(9, 200, (height, width, 3)).astype(np.uint8)
    script.depth = np.full(script.depth_size[::-1], 500, np.uint16)


def black(script, height: int, width: int) -> None:
    script.color = np.random.default_rng(1).integers(0, 9, (height, width, 3)).astype(np.uint8)


def half(script, height: int, width: int) -> None:
    image = np.random.default_rng(1).integers(9, 200, (height, width, 3)).astype(np.uint8)
    image[height // 2 :] = (0, 135, 0)
    script.color = image


def small(script, height: int, width: int) -> None:
    script.color = np.full((height // 2, width, 3), 99, np.uint8)


@pytest.mark.parametrize(
    ("damage", "problem"),
    [
        (frozen, "same image again and again"),
        (black, "the colour image is black"),
        (half, "the lower part of the colour image is missing"),
        (small, "the colour image is "),
    ],
)
def test_images_that_are_wrong_are_told_and_left_out(
    kind: str, driver: ModuleType, damage, problem: str
) -> None:
    script = driver.script
    with closing(open_any(address(kind))) as source:
        frame_within(source)
        width, height = script.size
        damage(script, height, width)
        assert problem_of(source, lambda told: problem in told)
        script.color = script.depth = None
        assert frame_within(source) is not None


def test_without_its_library_a_camera_tells_what_to_install(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, KINDS[kind], None)
    with pytest.raises(SourceError, match=rf"pip install 'snapfit\[{kind}\]'"):
        open_any(address(kind))


def test_calibration_belongs_to_cameras_that_bring_none(tmp_path: Path) -> None:
    file = tmp_path / "camera.json"
    with pytest.raises(SourceError, match="brings its own calibration"):
        open_any("realsense", calibration=file)
    with pytest.raises(SourceError, match="a recording brings its own"):
        open_any(str(tmp_path), calibration=file)
    with pytest.raises(SourceError, match="snapfit calibrate"):
        open_any("uvc:0")
    with pytest.raises(CameraError, match="cannot be read"):
        open_any("uvc:0", calibration=file)


def camera_file(path: Path, **changes: object) -> Path:
    given = {"width": 64, "height": 48, "fx": 60.0, "fy": 61.0, "cx": 31.5, "cy": 23.5}
    told = {"rms_px": 0.2, "images": 20, "date": "2026-01-01T00:00:00Z", "board": "a board"}
    write_camera_file(path, CameraFile(**{**given, **told, **changes}))
    return path


class FakeCapture:
    """Stands in for cv2.VideoCapture."""

    made: list[FakeCapture] = []  # noqa: RUF012
    is_there = True
    delivers = True

    def __init__(self, *arguments: object) -> None:
        self.arguments, self.set_to, self.is_open = arguments, {}, FakeCapture.is_there
        self.rng = np.random.default_rng(2)
        FakeCapture.made.append(self)

    def isOpened(self) -> bool:
        return self.is_open

    def set(self, key: int, value: float) -> bool:
        self.set_to[key] = value
        return True

    def get(self, _key: int) -> float:
        return 0.0

    def read(self) -> tuple[bool, np.ndarray | None]:
        time.sleep(0.005)
        if not FakeCapture.delivers:
            return False, None
        return True, self.rng.integers(20, 230, (48, 64, 3)).astype(np.uint8)

    def release(self) -> None:
        self.is_open = False


@pytest.fixture
def capture(monkeypatch: pytest.MonkeyPatch) -> type[FakeCapture]:
    from snapfit.tracking.sources import video

    monkeypatch.setattr(live_module, "LiveTimes", lambda: TIMES)
    monkeypatch.setattr(video.cv2, "VideoCapture", FakeCapture)
    FakeCapture.made, FakeCapture.is_there, FakeCapture.delivers = [], True, True
    return FakeCapture


@pytest.mark.parametrize("where", ["uvc:2", "uvc:/dev/video7?fps=25", "rtsp://cam/live"])
def test_opencvs_cameras_deliver_colour_and_come_back(
    capture: type[FakeCapture], tmp_path: Path, where: str
) -> None:
    import cv2

    file = camera_file(tmp_path / "camera.json", distortion=(-0.2, 0.05, 0.0, 0.0, 0.0))
    with closing(open_any(where, calibration=file)) as source:
        assert source.camera.depth is None
        assert (source.camera.color.fx, source.frame_rate_hz) == (60.0, 30.0)
        frame = frame_within(source)
        assert frame.depth is None
        first = capture.made[0]
        if where.startswith("uvc"):
            assert first.arguments == (2 if where == "uvc:2" else "/dev/video7",)
            assert first.set_to[cv2.CAP_PROP_FRAME_WIDTH] == 64
        else:
            assert first.arguments[:2] == (where, cv2.CAP_FFMPEG)
        capture.delivers = False
        assert problem_of(source, lambda told: "has delivered nothing for" in told)
        capture.delivers = True
        assert frame_within(source) is not None
    assert not capture.made[-1].is_open


def test_a_camera_of_another_size_than_its_calibration_is_told(
    capture: type[FakeCapture], tmp_path: Path
) -> None:
    file = camera_file(tmp_path / "camera.json", width=128, height=96)
    with closing(open_any("uvc:0", calibration=file)) as source:
        told = problem_of(source, lambda told: "the colour image is" in told)
        assert told == "the colour image is 64x48x3 uint8, the camera's is 128x96"


def test_opencvs_camera_that_is_not_there_is_refused(
    capture: type[FakeCapture], tmp_path: Path
) -> None:
    capture.is_there = False
    with pytest.raises(SourceError, match="there is no such camera, or it is in use"):
        open_any("uvc:0", calibration=camera_file(tmp_path / "camera.json"))


def test_a_bug_in_a_driver_is_told_and_not_taken_for_silence(
    capture: type[FakeCapture],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    def broken(_self):
        raise ZeroDivisionError

    monkeypatch.setattr(FakeCapture, "read", broken)
    with closing(open_any("uvc:0", calibration=camera_file(tmp_path / "camera.json"))) as source:
        assert problem_of(source, lambda told: "a bug, told in the log" in told)
    assert "ZeroDivisionError" in caplog.text
