"""A board to print, with a ruler that shows whether the print has the right size."""

from __future__ import annotations

import numpy as np
import segno

from snapfit.models.charuco_page import draw_cells, draw_charuco
from snapfit.models.pdf_page import PdfPage
from snapfit.server.boards import CharucoBoard, QrCode
from snapfit.server.errors import BoardError
from snapfit.server.marker_detection import opencv_board

PAPERS_MM = {"a4": (210.0, 297.0), "a3": (297.0, 420.0), "letter": (215.9, 279.4)}

_RULER_MM = 100
_TICK_MM = 10
_LINE_MM = 0.2
_TEXT_MM = 3.2
_MARGIN_MM = 8.0
"""What printers leave white, and what the markers at the edge need around them."""
_RULER_ROOM_MM = 14.0
_QUIET_MODULES = 4
"""White around a QR code, by its standard (ISO/IEC 18004)."""


def board_pdf(board: CharucoBoard | QrCode, paper: str) -> bytes:
    """The file.

    Args:
        board: what to print.
        paper: a name of `PAPERS_MM`.

    Raises:
        BoardError: the board does not fit the paper, or its text no QR code.
    """
    return _charuco(board, paper) if isinstance(board, CharucoBoard) else _qr(board, paper)


def _charuco(board: CharucoBoard, paper: str) -> bytes:
    square_mm = 1e3 * board.square_m
    board_mm = board.columns * square_mm, board.rows * square_mm
    page, left_mm, top_mm = _page(paper, board_mm, 0.0, "fewer squares, smaller ones")
    draw_charuco(page, opencv_board(board), left_mm, top_mm)
    text = (
        f"snapfit: ChArUco {board.columns} x {board.rows}, squares {square_mm:g} mm, markers "
        f"{1e3 * board.marker_m:g} mm, {board.dictionary}. Print at 100 %."
    )
    return _finished(page, left_mm, top_mm + board_mm[1], text)


def _qr(board: QrCode, paper: str) -> bytes:
    try:
        # More correction than this makes modules smaller, and those are what a camera has to see.
        code = segno.make_qr(board.text, error="m", boost_error=False)
    except ValueError as error:  # too long
        raise BoardError(f"no QR code says so: {error}") from error
    dark = np.array([[bool(module) for module in row] for row in code.matrix])
    size_mm = 1e3 * board.size_m
    module_mm = size_mm / len(dark)
    quiet_mm = _QUIET_MODULES * module_mm
    page, left_mm, top_mm = _page(paper, (size_mm, size_mm), quiet_mm, "a smaller size")
    draw_cells(page, dark, left_mm, top_mm, module_mm)
    text = f"snapfit: QR code {size_mm:g} mm, {board.text[:40]!r}. Print at 100 %."
    return _finished(page, left_mm, top_mm + size_mm + quiet_mm, text)


def _page(
    paper: str, board_mm: tuple[float, float], quiet_mm: float, remedy: str
) -> tuple[PdfPage, float, float]:
    """A page on which the board fits, and where its left upper corner comes, mm.

    Raises:
        BoardError: it does not fit; says what would help.
    """
    width_mm, height_mm = PAPERS_MM[paper]
    top_mm = max(_MARGIN_MM, quiet_mm)
    free_mm = width_mm - 2 * top_mm, height_mm - top_mm - quiet_mm - _MARGIN_MM - _RULER_ROOM_MM
    if board_mm[0] > free_mm[0] or board_mm[1] > free_mm[1]:
        raise BoardError(
            f"a board of {board_mm[0]:g} x {board_mm[1]:g} mm does not fit {paper} paper, on which "
            f"{free_mm[0]:g} x {free_mm[1]:g} mm are free: {remedy}, or larger paper"
        )
    return PdfPage(width_mm, height_mm), (width_mm - board_mm[0]) / 2, top_mm


def _finished(page: PdfPage, left_mm: float, bottom_mm: float, text: str) -> bytes:
    # The ruler and its words want more room than a small board has.
    left_mm = min(left_mm, (page.width_mm - _RULER_MM) / 2)
    _draw_ruler(page, left_mm, bottom_mm + 4)
    page.text(left_mm, bottom_mm + 13, _TEXT_MM, text)
    return page.to_bytes()


def _draw_ruler(page: PdfPage, left_mm: float, top_mm: float) -> None:
    page.rectangle(left_mm, top_mm, _RULER_MM, _LINE_MM)
    for at_mm in range(0, _RULER_MM + 1, _TICK_MM):
        length_mm = 4.0 if at_mm in (0, _RULER_MM) else 2.5
        # The outer edges of the first and the last tick are 100 mm apart.
        x_mm = min(max(left_mm + at_mm - _LINE_MM / 2, left_mm), left_mm + _RULER_MM - _LINE_MM)
        page.rectangle(x_mm, top_mm, _LINE_MM, length_mm)
    page.text(left_mm + _RULER_MM + 3, top_mm + 3, _TEXT_MM, f"{_RULER_MM} mm: measure it")
