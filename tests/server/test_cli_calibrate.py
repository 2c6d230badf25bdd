"""`snapfit calibrate`: from a folder of images, from a camera, and what it refuses."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

sys.path.insert(0, str(Path(__file__).parents[1] / "models"))

from charuco_views import CAMERA, poses, rendered

from snapfit.models.camera_file import read_camera_file
from snapfit.server.cli.main import app
from snapfit.tracking.sources import video

N_VIEWS = 16


def snapfit(*arguments: object) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["calibrate", *(str(each) for each in arguments)])
    return done.exit_code, done.output


@pytest.fixture(scope="module")
def images() -> list[np.ndarray]:
    return [rendered(pose, i) for i, pose in enumerate(poses(N_VIEWS, seed=5))]


@pytest.fixture
def folder(images: list[np.ndarray], tmp_path: Path) -> Path:
    (tmp_path / "views").mkdir()
    for number, image in enumerate(images):
        cv2.imwrite(str(tmp_path / "views" / f"{number:02d}.png"), image)
    return tmp_path / "views"


def test_a_folder_of_images_gives_a_camera_file(folder: Path, tmp_path: Path) -> None:
    cv2.imwrite(str(folder / "wall.jpg"), np.full((480, 640, 3), 90, np.uint8))
    (folder / "broken.png").write_bytes(b"no image")
    out = tmp_path / "camera.json"
    code, told = snapfit("camera", folder, "--out", out)
    assert code == 0, told
    assert "wall.jpg: the board is not seen well" in told
    assert "broken.png: is no image that can be read" in told
    assert f"over {N_VIEWS} images" in told
    file = read_camera_file(out)
    assert file.fx == pytest.approx(CAMERA.fx, rel=0.01)
    assert file.images == N_VIEWS


def test_what_does_not_do_is_one_clear_line_and_no_file(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "camera.json"
    for path in sorted(folder.iterdir())[9:]:
        path.unlink()
    code, told = snapfit("camera", folder, "--out", out)
    assert code == 2
    assert "seen in 9 images, at least 10 are needed" in told
    cv2.imwrite(str(folder / "zz.png"), np.zeros((100, 100, 3), np.uint8))
    code, told = snapfit("camera", folder, "--out", out)
    assert (code, "is 100x100, the others are 640x480" in told) == (2, True)
    (tmp_path / "empty").mkdir()
    for where, problem in (
        (tmp_path / "empty", "there is no image in it"),
        (tmp_path / "nowhere", "no such folder"),
        ("realsense:1", "brings its own calibration"),
        ("uvc", "say which one after a colon"),
    ):
        code, told = snapfit("camera", where, "--out", out)
        assert (code, problem in told) == (2, True), told
    assert not out.exists()


class FakeCapture:
    """Stands in for cv2.VideoCapture: a hand that shows the board, moves it, holds it still."""

    images: Iterator[np.ndarray] = iter(())
    is_there = True

    def __init__(self, number: int) -> None:
        assert number == 0

    def isOpened(self) -> bool:
        return FakeCapture.is_there

    def set(self, _key: int, _value: float) -> bool:
        return True

    def read(self) -> tuple[bool, np.ndarray | None]:
        image = next(FakeCapture.images, None)
        return image is not None, image

    def release(self) -> None:
        """Done."""


@pytest.fixture
def capture(monkeypatch: pytest.MonkeyPatch) -> type[FakeCapture]:
    monkeypatch.setattr(video.cv2, "VideoCapture", FakeCapture)
    FakeCapture.is_there = True
    return FakeCapture


def test_a_camera_gives_one_too(
    capture: type[FakeCapture], images: list[np.ndarray], tmp_path: Path
) -> None:
    wall = np.full((480, 640, 3), 90, np.uint8)
    in_color = [cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) for image in images]
    # Each view is held for three frames: it is still from the second on, and new only once.
    capture.images = itertools.chain.from_iterable([wall, each, each, each] for each in in_color)
    out = tmp_path / "camera.json"
    code, told = snapfit("camera", "uvc:0", "--out", out, "--views", 12)
    assert code == 0, told
    file = read_camera_file(out)
    assert file.images == 12
    assert file.fx == pytest.approx(CAMERA.fx, rel=0.01)


def test_a_camera_that_ends_or_is_not_there_is_told(
    capture: type[FakeCapture], tmp_path: Path
) -> None:
    capture.images = iter(())
    out = tmp_path / "camera.json"
    code, told = snapfit("camera", "uvc:0", "--out", out)
    assert (code, "delivers no image any more" in told) == (2, True)
    capture.is_there = False
    code, told = snapfit("camera", "uvc:0", "--out", out)
    assert (code, "there is no such camera" in told) == (2, True)
    assert not out.exists()


def test_the_board_is_written(tmp_path: Path) -> None:
    out = tmp_path / "board.pdf"
    code, told = snapfit("board", out, "--columns", 7, "--rows", 5, "--square-mm", 35)
    assert code == 0, told
    assert "ChArUco 7x5, squares of 35 mm" in told
    assert out.read_bytes().startswith(b"%PDF")
    code, told = snapfit("board", tmp_path / "board.svg")
    assert (code, told.count("\n")) == (2, 1)
