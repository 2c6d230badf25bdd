"""Calibration: known intrinsics are recovered, and what cannot be believed is refused."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from charuco_views import BOARD, CAMERA, DISTORTION, poses, rendered

from snapfit.models.calibration import BoardFinder, CalibrationParameters, View, calibrate
from snapfit.models.camera_file import CameraFile, read_camera_file, write_camera_file
from snapfit.models.charuco import CharucoBoard, write_board
from snapfit.models.errors import CalibrationError, CameraError

SIZE = (CAMERA.width, CAMERA.height)


def seen(**given: float) -> list[View]:
    finder = BoardFinder(BOARD)
    found = [
        finder.find(f"view {i}", rendered(pose, i))
        for i, pose in enumerate(poses(int(given.pop("n", 24)), **given))
    ]
    return [view for view in found if view is not None]


@pytest.fixture(scope="module")
def views() -> list[View]:
    return seen()


@pytest.fixture(scope="module")
def camera(views: list[View]) -> CameraFile:
    return calibrate(views, SIZE, BOARD)


def test_known_intrinsics_are_recovered(views: list[View], camera: CameraFile) -> None:
    assert len(views) >= 20
    assert camera.images == len(views)
    assert camera.rms_px < 0.25
    assert camera.fx == pytest.approx(CAMERA.fx, rel=0.005)
    assert camera.fy == pytest.approx(CAMERA.fy, rel=0.005)
    assert camera.cx == pytest.approx(CAMERA.cx, abs=2.0)
    assert camera.cy == pytest.approx(CAMERA.cy, abs=2.0)
    assert (camera.width, camera.height) == SIZE
    assert camera.board == "ChArUco 9x6, squares of 28 mm"
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", camera.date)


def test_every_pixel_looks_where_it_should(camera: CameraFile) -> None:
    """Lens and intrinsics together, all over the image."""
    y, x = np.mgrid[10:470:20, 10:630:20].astype(np.float64)
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)[:, None]
    rays = cv2.undistortPoints(pixels, CAMERA.matrix, np.array(DISTORTION))[:, 0]
    points = np.column_stack([rays, np.ones(len(rays))])
    zero, matrix = np.zeros(3), camera.camera.matrix
    again = cv2.projectPoints(points, zero, zero, matrix, np.array(camera.distortion))[0]
    # A turn of the camera of a fraction of a degree is none of the calibration's business.
    off = (again - pixels)[:, 0]
    off -= off.mean(axis=0)
    assert np.linalg.norm(off, axis=1).max() < 0.8
    assert np.linalg.norm(off, axis=1).mean() < 0.3


def test_too_few_views_are_refused(views: list[View]) -> None:
    with pytest.raises(CalibrationError, match="seen in 9 images, at least 10 are needed"):
        calibrate(views[:9], SIZE, BOARD)


def test_views_in_one_corner_are_refused(views: list[View]) -> None:
    one = [View(v.name, v.points_m, v.pixels * np.float32(0.4)) for v in views]
    with pytest.raises(CalibrationError, match="bring it to the edges"):
        calibrate(one, SIZE, BOARD)


def test_a_large_error_is_refused_and_names_the_worst(views: list[View]) -> None:
    rng = np.random.default_rng(2)
    bent = list(views)
    noise = rng.normal(0, 12, bent[4].pixels.shape).astype(np.float32)
    bent[4] = View("blurred.png", bent[4].points_m, bent[4].pixels + noise)
    with pytest.raises(CalibrationError, match=r"The worst: blurred\.png \("):
        calibrate(bent, SIZE, BOARD)


@pytest.mark.parametrize("tilt_rad", [0.0, 0.05])
def test_views_that_are_not_tilted_are_refused(tilt_rad: float) -> None:
    flat = seen(n=20, tilt_rad=tilt_rad)
    assert len(flat) >= 10
    with pytest.raises(CalibrationError, match="tilt the board"):
        calibrate(flat, SIZE, BOARD, CalibrationParameters(least_coverage=0.0))


def test_an_image_without_the_board_is_no_view() -> None:
    finder = BoardFinder(BOARD)
    noise = np.random.default_rng(0).integers(0, 256, (480, 640, 3)).astype(np.uint8)
    assert finder.find("noise", noise) is None
    other = rendered(next(poses(1)), board=CharucoBoard(5, 4))
    view = finder.find("another board", other)
    assert view is None


def test_a_camera_file_comes_back_and_a_wrong_one_is_refused(
    camera: CameraFile, tmp_path: Path
) -> None:
    path = tmp_path / "camera.json"
    write_camera_file(path, camera)
    assert read_camera_file(path) == camera
    path.write_text(path.read_text().replace('"fx": ', '"fx": -'))
    with pytest.raises(CameraError, match=r"camera\.json: fx: "):
        read_camera_file(path)
    path.write_text('{"focal": 3}')
    with pytest.raises(CameraError, match=r"camera\.json: "):
        read_camera_file(path)
    path.write_text("{")
    with pytest.raises(CameraError, match="is not valid JSON"):
        read_camera_file(path)
    with pytest.raises(CameraError, match="cannot be written"):
        write_camera_file(tmp_path / "nowhere" / "camera.json", camera)


def test_the_printed_board_is_found_and_has_its_true_size(tmp_path: Path) -> None:
    path = tmp_path / "board.png"
    write_board(path, BOARD)
    data = path.read_bytes()
    at = data.index(b"pHYs") + 4
    assert int.from_bytes(data[at : at + 4], "big") == 12_000
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    assert image.shape == ((6 * 28 + 24) * 12, (9 * 28 + 24) * 12)
    view = BoardFinder(BOARD).find("board", cv2.resize(image, None, fx=0.25, fy=0.25))
    assert view is not None
    assert len(view.pixels) == BOARD.n_corners
    spacing = np.linalg.norm(np.diff(view.pixels[:8], axis=0), axis=1)
    assert spacing == pytest.approx(28 * 12 / 4, abs=0.5)


def test_the_pdf_holds_the_same_board_in_points(tmp_path: Path) -> None:
    path = tmp_path / "board.pdf"
    write_board(path, BOARD)
    data = path.read_bytes()
    assert data.startswith(b"%PDF-1.4")
    place = int(re.search(rb"startxref\n(\d+)\n%%EOF", data)[1])
    assert data[place : place + 4] == b"xref"
    for line in re.findall(rb"^(\d{10}) 00000 n", data, re.MULTILINE):
        assert re.match(rb"\d+ 0 obj", data[int(line) :])
    box = [float(n) for n in re.search(rb"MediaBox \[([\d. ]+)\]", data)[1].split()]
    assert box[2:] == pytest.approx([(252 + 24) * 72 / 25.4, (168 + 24) * 72 / 25.4], abs=0.01)
    # Its rectangles, drawn as many pixels a square as the picture has.
    px_per_mm = 56 / BOARD.square_mm
    drawn = np.full((6 * 56, 9 * 56), 255, dtype=np.uint8)
    for found in re.finditer(rb"([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) re f", data):
        x, y, w, h = (float(value) for value in found.groups())
        left, right = (round((each - 12) * px_per_mm) for each in (x, x + w))
        top, bottom = (round((168 + 12 - each) * px_per_mm) for each in (y + h, y))
        drawn[top:bottom, left:right] = 0
    assert np.array_equal(drawn, BOARD.image())


@pytest.mark.parametrize(
    ("given", "problem"),
    [({"columns": 2}, "3 to 20 squares"), ({"square_mm": 0.0}, "1 to 500 mm")],
)
def test_a_board_that_cannot_be_made_is_refused(given: dict[str, float], problem: str) -> None:
    with pytest.raises(CalibrationError, match=problem):
        CharucoBoard(**given)


def test_a_board_is_png_or_pdf(tmp_path: Path) -> None:
    with pytest.raises(CalibrationError, match=r"as \.png or \.pdf"):
        write_board(tmp_path / "board.svg", BOARD)
    with pytest.raises(CalibrationError, match="cannot be written"):
        write_board(tmp_path / "nowhere" / "board.pdf", BOARD)
