"""The board that cameras are calibrated with: a chessboard with ArUco markers in its white squares.

Source: Garrido-Jurado, Munoz-Salinas, Madrid-Cuevas, Marin-Jimenez, "Automatic generation and
detection of highly reliable fiducial markers under occlusion" (2014); drawn and found by OpenCV.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.charuco_page import draw_charuco
from snapfit.models.errors import CalibrationError
from snapfit.models.pdf_page import PdfPage

# A marker has seven cells (five bits and its border) on three quarters of a square: so a square of
# 56 pixels has whole pixels for all of them.
_SQUARE_PX = 56
_MARKER_SHARE = 0.75
_PNG_PX_PER_MM = 12
_PNG_HEAD_BYTES = 33
_MARGIN_MM = 12.0
_TEXT_MM = 2.8
_LEAST_SQUARES, _MOST_SQUARES = 3, 20


@dataclass(frozen=True)
class CharucoBoard:
    """A board; its corners are those where four squares meet.

    Attributes:
        columns, rows: squares.
        square_mm: side of a square, as it is on paper: measure it.

    Raises:
        CalibrationError: no such board can be made.
    """

    columns: int = 9
    rows: int = 6
    square_mm: float = 28.0

    def __post_init__(self) -> None:
        if not all(_LEAST_SQUARES <= n <= _MOST_SQUARES for n in (self.columns, self.rows)):
            bounds = f"{_LEAST_SQUARES} to {_MOST_SQUARES}"
            problem = f"a board has {bounds} squares a side, this has {self.columns}x{self.rows}"
            raise CalibrationError(problem)
        if not 1 <= self.square_mm <= 500:
            raise CalibrationError(f"a square has 1 to 500 mm, this has {self.square_mm:g}")

    def __str__(self) -> str:
        """The board in words."""
        return f"ChArUco {self.columns}x{self.rows}, squares of {self.square_mm:g} mm"

    @cached_property
    def opencv(self) -> Any:
        """OpenCV's board; lengths in metres."""
        side_m = self.square_mm / 1000.0
        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_250)
        size = (self.columns, self.rows)
        return cv2.aruco.CharucoBoard(size, side_m, _MARKER_SHARE * side_m, dictionary)

    @property
    def n_corners(self) -> int:
        """How many corners there are to be found."""
        return (self.columns - 1) * (self.rows - 1)

    def image(self, square_px: int = _SQUARE_PX) -> npt.NDArray[np.uint8]:
        """The board alone, (rows, columns) times `square_px` (a multiple of 56), grey."""
        size = (self.columns * _SQUARE_PX, self.rows * _SQUARE_PX)
        drawn = np.asarray(self.opencv.generateImage(size), dtype=np.uint8)
        factor = square_px // _SQUARE_PX
        return drawn.repeat(factor, axis=0).repeat(factor, axis=1)


def write_board(path: Path, board: CharucoBoard) -> None:
    """Writes a board for printing, PNG or PDF, in its true size and with a white margin.

    Raises:
        CalibrationError: it is called neither .png nor .pdf, or cannot be written.
    """
    makers = {".png": _png, ".pdf": _pdf}
    maker = makers.get(path.suffix.lower())
    if maker is None:
        raise CalibrationError(f"{path}: a board is written as .png or .pdf")
    try:
        path.write_bytes(maker(board))
    except OSError as error:
        raise CalibrationError(f"{path}: cannot be written: {error.strerror}") from error


def _png(board: CharucoBoard) -> bytes:
    """At 12 pixels a millimetre, which the file says."""
    size = tuple(round(n * board.square_mm * _PNG_PX_PER_MM) for n in (board.columns, board.rows))
    drawn = cv2.resize(board.image(), size, interpolation=cv2.INTER_NEAREST)
    margin_px = round(_MARGIN_MM * _PNG_PX_PER_MM)
    whole = np.pad(drawn, margin_px, constant_values=255)
    data = bytes(cv2.imencode(".png", whole)[1])
    per_metre = (1000 * _PNG_PX_PER_MM).to_bytes(4, "big")
    chunk = b"pHYs" + 2 * per_metre + b"\x01"
    resolution = (9).to_bytes(4, "big") + chunk + zlib.crc32(chunk).to_bytes(4, "big")
    return data[:_PNG_HEAD_BYTES] + resolution + data[_PNG_HEAD_BYTES:]


def _pdf(board: CharucoBoard) -> bytes:
    """A page as large as board and margin, with a line of text."""
    width_mm, height_mm = board.columns * board.square_mm, board.rows * board.square_mm
    page = PdfPage(width_mm + 2 * _MARGIN_MM, height_mm + 2 * _MARGIN_MM)
    draw_charuco(page, board.opencv, _MARGIN_MM, _MARGIN_MM)
    told = f"snapfit: {board}. Print at 100 %, measure a square, keep it flat."
    page.text(_MARGIN_MM, height_mm + 1.6 * _MARGIN_MM, _TEXT_MM, told)
    return page.to_bytes()
