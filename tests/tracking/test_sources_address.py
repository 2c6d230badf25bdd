"""Addresses of cameras: what is understood, what is a path, what is refused and how."""

import re
from pathlib import Path

import pytest

from snapfit.tracking.errors import SourceError
from snapfit.tracking.sources.address import KINDS, Address, parse_address


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("realsense:012345", ("realsense", "012345")),
        ("realsense", ("realsense", "")),
        ("RealSense:", ("realsense", "")),
        ("kinect:000911", ("kinect", "000911")),
        ("orbbec", ("orbbec", "")),
        ("oak:192.168.1.20", ("oak", "192.168.1.20")),
        ("uvc:0", ("uvc", "0")),
        ("uvc:/dev/video2", ("uvc", "/dev/video2")),
        ("rtsp://cam/live?width=7&x", ("rtsp", "rtsp://cam/live?width=7&x")),
        ("rtsps://cam/live", ("rtsp", "rtsps://cam/live")),
    ],
)
def test_an_address_is_understood(text: str, wanted: tuple[str, str]) -> None:
    address = parse_address(text)
    assert address == Address(text, *wanted)


def test_options_are_numbers() -> None:
    address = parse_address("uvc:0?width=1280&height=720&fps=25")
    assert address == Address("uvc:0?width=1280&height=720&fps=25", "uvc", "0", 1280, 720, 25)


@pytest.mark.parametrize("text", ["recordings/monday", "demo.mcap", "C:\\bench", "my folder"])
def test_a_path_is_a_path(text: str) -> None:
    assert parse_address(text) is None


def test_what_exists_is_a_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "oak").mkdir()
    (tmp_path / "take:2").mkdir()
    monkeypatch.chdir(tmp_path)
    assert parse_address("oak") is None
    assert parse_address("take:2") is None


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("kinekt:1", "no kind of camera 'kinekt'. There are realsense"),
        ("http://cam/stream", "no kind of camera 'http'"),
        ("uvc", "say which one after a colon"),
        ("uvc:", "say which one after the colon"),
        ("rtsp:cam", "begins with rtsp://"),
        ("uvc:0?width=1280", "width and height, or neither"),
        ("uvc:0?width=0&height=2", "width: .*greater than 0"),
        ("uvc:0?size=3", "size: .*the options are width, height, fps"),
        ("uvc:0?fps", "fps: .*integer"),
        ("uvc:0?&", "options stand as"),
    ],
)
def test_what_is_wrong_is_told(text: str, problem: str) -> None:
    with pytest.raises(SourceError, match=problem) as caught:
        parse_address(text)
    assert str(caught.value).startswith(text)


def test_every_kind_is_documented() -> None:
    page = (Path(__file__).parents[2] / "docs" / "cameras.md").read_text()
    for kind in KINDS:
        assert re.search(rf"^\| `{kind}:", page, re.MULTILINE), kind
