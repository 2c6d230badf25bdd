"""A ChArUco board to print, with a ruler that shows whether the print has the right size."""

from __future__ import annotations

import cv2
import numpy as np

from snapfit.server.boards import CharucoBoard
from snapfit.server.errors import BoardError
from snapfit.server.marker_detection import opencv_board, opencv_dictionary
from snapfit.server.pdf_page import PdfPage

PAPERS_MM = {"a4": (210.0, 297.0), "a3": (297.0, 420.0), "letter": (215.9, 279.4)}

_RULER_MM = 100
_TICK_MM = 10
_LINE_MM = 0.2
_MARGIN_MM = 8.0
"""What printers leave white, and what the markers at the edge need around them."""
_RULER_ROOM_MM = 14.0


def board_pdf(board: CharucoBoard, paper: str) -> bytes:
    """The file.

    Args:
        board: what to print.
        paper: a name of `PAPERS_MM`.

    Raises:
        BoardError: the board does not fit the paper.
    """
    width_mm, height_mm = PAPERS_MM[paper]
    square_mm = 1e3 * board.square_m
    board_mm = board.columns * square_mm, board.rows * square_mm
    free_mm = width_mm - 2 * _MARGIN_MM, height_mm - 2 * _MARGIN_MM - _RULER_ROOM_MM
    if board_mm[0] > free_mm[0] or board_mm[1] > free_mm[1]:
        raise BoardError(
            f"a board of {board_mm[0]:g} x {board_mm[1]:g} mm does not fit {paper} paper, on which "
            f"{free_mm[0]:g} x {free_mm[1]:g} mm are free: fewer squares, smaller ones, or "
            "larger paper"
        )
    page = PdfPage(width_mm, height_mm)
    left_mm = (width_mm - board_mm[0]) / 2
    _draw_board(page, board, left_mm, _MARGIN_MM)
    _draw_ruler(page, left_mm, _MARGIN_MM + board_mm[1] + 4)
    text = (
        f"snapfit: ChArUco {board.columns} x {board.rows}, squares {square_mm:g} mm, markers "
        f"{1e3 * board.marker_m:g} mm, {board.dictionary}. Print at 100 %."
    )
    page.text(left_mm, _MARGIN_MM + board_mm[1] + 13, 3.2, text)
    return page.to_bytes()


def _draw_board(page: PdfPage, board: CharucoBoard, left_mm: float, top_mm: float) -> None:
    """Markers where OpenCV has them; every square without one is black."""
    known = opencv_board(board)
    dictionary = opencv_dictionary(board.dictionary)
    cells = dictionary.markerSize + 2
    cell_mm = 1e3 * board.marker_m / cells
    has_marker = np.zeros((board.rows, board.columns), dtype=np.bool_)
    for number, corners in zip(np.ravel(known.getIds()), known.getObjPoints(), strict=True):
        at_mm = 1e3 * np.asarray(corners, dtype=np.float64)[:, :2]
        column, row = (at_mm.mean(axis=0) / (1e3 * board.square_m)).astype(int)
        has_marker[row, column] = True
        bits = cv2.aruco.generateImageMarker(dictionary, int(number), cells)
        x_mm, y_mm = left_mm + at_mm[0, 0], top_mm + at_mm[0, 1]
        for down, line in enumerate(np.asarray(bits) < 128):
            for begin, end in _runs(line):
                width_mm = (end - begin) * cell_mm
                page.rectangle(x_mm + begin * cell_mm, y_mm + down * cell_mm, width_mm, cell_mm)
    square_mm = 1e3 * board.square_m
    for row, column in np.argwhere(~has_marker):
        page.rectangle(left_mm + column * square_mm, top_mm + row * square_mm, square_mm, square_mm)


def _runs(line: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> list[tuple[int, int]]:
    """Begin and end of each run of black cells: drawn as one, they leave no hairlines."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(np.int8), [0]])))
    return [(int(begin), int(end)) for begin, end in edges.reshape(-1, 2)]


def _draw_ruler(page: PdfPage, left_mm: float, top_mm: float) -> None:
    page.rectangle(left_mm, top_mm, _RULER_MM, _LINE_MM)
    for at_mm in range(0, _RULER_MM + 1, _TICK_MM):
        length_mm = 4.0 if at_mm in (0, _RULER_MM) else 2.5
        # The outer edges of the first and the last tick are 100 mm apart.
        x_mm = min(max(left_mm + at_mm - _LINE_MM / 2, left_mm), left_mm + _RULER_MM - _LINE_MM)
        page.rectangle(x_mm, top_mm, _LINE_MM, length_mm)
    page.text(left_mm + _RULER_MM + 3, top_mm + 3, 3.2, f"{_RULER_MM} mm: measure it")
