"""Boards are found where they are drawn; the printed one has the size that it says."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import drawn_boards
import numpy as np
import numpy.typing as npt
import pytest
from drawn_boards import draw_board
from pydantic import TypeAdapter, ValidationError
from typer.testing import CliRunner

from snapfit.models.camera import AZURE_KINECT_720P
from snapfit.models.pose import Pose
from snapfit.server import qr_corners
from snapfit.server.board_pdf import PAPERS_MM, board_pdf
from snapfit.server.boards import ArucoMarker, Board, CharucoBoard, QrCode
from snapfit.server.cli.main import app
from snapfit.server.errors import BoardError
from snapfit.server.marker_detection import MarkerDetector

CAMERA = AZURE_KINECT_720P
BOARDS = [
    CharucoBoard(),
    CharucoBoard(columns=6, rows=4, square_m=0.04, marker_m=0.03, dictionary="DICT_4X4_50"),
    ArucoMarker(kind="aruco", id=3, size_m=0.15),
    ArucoMarker(kind="aruco", id=500, size_m=0.15, dictionary="DICT_APRILTAG_36H11"),
    QrCode(kind="qr", text="bench-1", size_m=0.2),
]
# Half a millimetre and a quarter of a degree for many corners; four say less.
TOLERANCES = {"charuco": (0.0015, 0.3), "aruco": (0.004, 1.0), "qr": (0.001, 0.3)}


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: str(board.kind))
@pytest.mark.parametrize(
    "camera_from_marker",
    [
        Pose.exp([0.4, 0.3, 0.1, 0.02, -0.03, 0.6]),
        Pose.exp([-0.5, 0.4, 1.2, -0.05, 0.02, 0.55]),
        Pose.exp([0.6, -0.2, -2.5, 0.0, 0.0, 0.65]),
    ],
)
def test_a_board_is_found_where_it_is(board: Board, camera_from_marker: Pose) -> None:
    image = draw_board(board, CAMERA, camera_from_marker)
    found = MarkerDetector(board, CAMERA).detect(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    assert found is not None
    off_m, off_deg = TOLERANCES[board.kind]
    assert found.camera_from_marker.distance_to(camera_from_marker) < off_m
    assert np.degrees(found.camera_from_marker.angle_to(camera_from_marker)) < off_deg


@pytest.mark.parametrize("distance_m", [0.6, 0.8])
def test_a_qr_code_is_measured_by_its_inner_corners(distance_m: float) -> None:
    """With a sensor's noise, in dimmer light, a little out of focus."""
    rng = np.random.default_rng(4)
    code = QrCode(kind="qr", text="bench-1", size_m=0.15)
    pose = Pose.exp([0.4, 0.3, 0.2, 0.02, -0.01, distance_m])
    image = cv2.GaussianBlur(draw_board(code, CAMERA, pose), (0, 0), 0.7)
    noisy = 20 + 0.8 * image[:, :, 0] + rng.normal(0, 3, image.shape[:2])
    found = MarkerDetector(code, CAMERA).detect(noisy.clip(0, 255).astype(np.uint8))
    assert found is not None
    assert found.corners >= 16
    assert found.camera_from_marker.distance_to(pose) < 0.0015


def test_a_qr_code_with_modules_too_small_is_measured_by_its_four_corners(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(qr_corners, "_LEAST_MODULE_PX", 50.0)
    code = QrCode(kind="qr", text="bench-1", size_m=0.2)
    pose = Pose.exp([0.4, 0.3, 0.1, 0.02, -0.03, 0.6])
    image = draw_board(code, CAMERA, pose)
    found = MarkerDetector(code, CAMERA).detect(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    assert found is not None
    assert found.corners == 4
    assert found.camera_from_marker.distance_to(pose) < 0.012


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: str(board.kind))
def test_nothing_is_found_where_nothing_is(board: Board) -> None:
    rng = np.random.default_rng(1)
    detector = MarkerDetector(board, CAMERA)
    assert detector.detect(np.full((720, 1280), 128, dtype=np.uint8)) is None
    noise = rng.integers(0, 256, (720, 1280), dtype=np.uint8)
    assert detector.detect(noise) is None


def test_another_marker_is_not_taken_for_it() -> None:
    image = draw_board(BOARDS[2], CAMERA, Pose.exp([0.4, 0.3, 0.1, 0, 0, 0.6]))
    gray = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    assert MarkerDetector(ArucoMarker(kind="aruco", id=4, size_m=0.15), CAMERA).detect(gray) is None
    assert MarkerDetector(CharucoBoard(), CAMERA).detect(gray) is None


@pytest.mark.parametrize(
    "board",
    [
        {"kind": "aruco", "id": 50, "size_m": 0.1},
        {"kind": "aruco", "id": -1, "size_m": 0.1},
        {"kind": "aruco", "id": 1, "size_m": 0},
        {"kind": "aruco", "id": 1},
        {"kind": "charuco", "square_m": 0.02, "marker_m": 0.02},
        {"kind": "charuco", "columns": 20, "rows": 20},
        {"kind": "charuco", "columns": 2},
        {"kind": "qr", "text": "", "size_m": 0.1},
        {"kind": "barcode", "text": "x", "size_m": 0.1},
    ],
)
def test_a_board_that_cannot_be_is_refused(board: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        TypeAdapter(Board).validate_python(board)


def rendered(pdf: bytes, px_per_mm: float) -> npt.NDArray[np.uint8]:
    """Draws the page's rectangles; needs nothing else, because the file holds nothing else."""
    media = re.search(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    assert media is not None
    width_mm, height_mm = (float(value) * 25.4 / 72 for value in media.groups())
    scale = re.search(rb"stream\n([\d.]+) 0 0 ([\d.]+) 0 0 cm", pdf)
    assert scale is not None
    unit_mm = float(scale[1]) * 25.4 / 72
    assert unit_mm == pytest.approx(1, abs=1e-8)
    page = np.full((round(height_mm * px_per_mm), round(width_mm * px_per_mm)), 255, dtype=np.uint8)
    for found in re.finditer(rb"([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) re f", pdf):
        x, y, w, h = (float(value) for value in found.groups())
        left, right = (round(each * px_per_mm) for each in (x, x + w))
        top, bottom = (round((height_mm - each) * px_per_mm) for each in (y + h, y))
        page[top:bottom, left:right] = 0
    return page


@pytest.mark.parametrize("paper", PAPERS_MM)
def test_the_printed_board_is_the_one_that_is_looked_for(paper: str) -> None:
    board, px_per_mm = CharucoBoard(), 10.0
    page = rendered(board_pdf(board, paper), px_per_mm)
    detector = cv2.aruco.CharucoDetector(
        cv2.aruco.CharucoBoard(
            (board.columns, board.rows),
            board.square_m,
            board.marker_m,
            cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100),
        )
    )
    corners, ids, _, _ = detector.detectBoard(page)
    assert len(ids) == (board.columns - 1) * (board.rows - 1)
    grid = corners.reshape(board.rows - 1, board.columns - 1, 2) / px_per_mm
    np.testing.assert_allclose(np.diff(grid[:, :, 0], axis=1), 35.0, atol=0.1)
    np.testing.assert_allclose(np.diff(grid[:, :, 1], axis=0), 35.0, atol=0.1)


@pytest.mark.parametrize("paper", PAPERS_MM)
@pytest.mark.parametrize("text", ["snapfit", "https://example.com/bench-1?key=0123456789"])
def test_the_printed_qr_code_says_what_it_should_in_its_true_size(paper: str, text: str) -> None:
    px_per_mm = 8.0
    page = rendered(board_pdf(QrCode(kind="qr", text=text, size_m=0.15), paper), px_per_mm)
    said, _, _ = cv2.QRCodeDetector().detectAndDecode(page)
    assert said == text
    assert code_of(page, px_per_mm).shape == (1200, 1200)


def code_of(page: npt.NDArray[np.uint8], px_per_mm: float) -> npt.NDArray[np.uint8]:
    """What is black above the ruler, which is farther from the code than a centimetre."""
    top = np.flatnonzero((page == 0).any(axis=1))[0]
    rows, columns = np.nonzero(page[: top + round(160 * px_per_mm)] == 0)
    return page[top : rows.max() + 1, columns.min() : columns.max() + 1]


def test_what_is_printed_is_seen_by_the_camera_in_its_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The page itself before the camera, not another drawing of the code."""
    code = QrCode(kind="qr", text="bench-1", size_m=0.15)
    printed = code_of(rendered(board_pdf(code, "a4"), 8.0), 8.0)
    monkeypatch.setattr(drawn_boards, "picture", lambda _: (printed, 0.15, 0.15))
    pose = Pose.exp([0.3, -0.4, 0.2, 0.01, 0.02, 0.6])
    image = draw_board(code, CAMERA, pose)
    found = MarkerDetector(code, CAMERA).detect(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    assert found is not None
    assert found.corners > 16
    assert found.camera_from_marker.distance_to(pose) < 0.001
    assert np.degrees(found.camera_from_marker.angle_to(pose)) < 0.3


def test_a_qr_code_that_cannot_be_printed_is_refused() -> None:
    with pytest.raises(BoardError, match=r"250 x 250 mm does not fit a4 .*a smaller size"):
        board_pdf(QrCode(kind="qr", text="x", size_m=0.25), "a4")


def test_the_ruler_is_a_hundred_millimetres_long() -> None:
    pdf = board_pdf(CharucoBoard(), "a4")
    numbers = [
        tuple(map(float, it))
        for it in re.findall(rb"([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) re f", pdf)
    ]
    ruler = next(each for each in numbers if each[2] == 100)
    ticks = [each for each in numbers if each[3] in (2.5, 4.0)]
    assert len(ticks) == 11
    assert min(tick[0] for tick in ticks) == ruler[0]
    assert max(tick[0] + tick[2] for tick in ticks) == pytest.approx(ruler[0] + 100)


def test_the_file_is_a_whole_pdf() -> None:
    pdf = board_pdf(CharucoBoard(), "letter")
    assert pdf.startswith(b"%PDF-1.4")
    start = int(pdf.rpartition(b"startxref\n")[2].split()[0])
    assert pdf[start:].startswith(b"xref\n0 6\n")
    for number in range(1, 6):
        place = int(pdf[start:].splitlines()[2 + number].split()[0])
        assert pdf[place:].startswith(b"%d 0 obj" % number)
    length = re.search(rb"/Length (\d+) >>\nstream\n", pdf)
    assert length is not None
    assert pdf[length.end() + int(length[1]) :].startswith(b"\nendstream")


def test_a_board_that_does_not_fit_the_paper_is_refused() -> None:
    with pytest.raises(BoardError, match=r"315 x 245 mm does not fit a4 .*larger paper"):
        board_pdf(CharucoBoard(columns=9), "a4")
    assert board_pdf(CharucoBoard(columns=7, rows=9), "a3")


def test_the_command_writes_it_and_names_what_is_wrong(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "board.pdf"
    done = CliRunner().invoke(app, ["anchor", "board", "--out", str(out), "--paper", "letter"])
    assert done.exit_code == 0
    assert "100 mm" in done.output
    assert out.read_bytes() == board_pdf(CharucoBoard(), "letter")
    qr = ["anchor", "board", "--out", str(out), "--kind", "qr", "--text", "bench-1"]
    done = CliRunner().invoke(app, [*qr, "--size-mm", "120"])
    assert '{"kind":"qr","text":"bench-1","size_m":0.12}' in done.output
    assert out.read_bytes() == board_pdf(QrCode(kind="qr", text="bench-1", size_m=0.12), "a4")
    for wrong, named in (
        ([*qr, "--size-mm", "1"], "size_m"),
        ([*qr[:4], "--columns", "50"], "columns"),
    ):
        refused = CliRunner().invoke(app, wrong)
        assert refused.exit_code == 2
        assert named in refused.stderr
