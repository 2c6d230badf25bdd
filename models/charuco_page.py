"""Draws a ChArUco board on a page: rectangles, so that no printer blurs an edge."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.pdf_page import PdfPage


def draw_charuco(
    page: PdfPage, board: cv2.aruco.CharucoBoard, left_mm: float, top_mm: float
) -> None:
    """Markers where OpenCV has them; every square without one is black.

    Args:
        page: to draw on.
        board: lengths in metres.
        left_mm, top_mm: of its corner on the page.
    """
    columns, rows = board.getChessboardSize()
    square_mm, marker_mm = 1e3 * board.getSquareLength(), 1e3 * board.getMarkerLength()
    dictionary = board.getDictionary()
    cells = dictionary.markerSize + 2
    has_marker = np.zeros((rows, columns), dtype=np.bool_)
    for number, corners in zip(np.ravel(board.getIds()), board.getObjPoints(), strict=True):
        at_mm = 1e3 * np.asarray(corners, dtype=np.float64)[:, :2]
        column, row = (at_mm.mean(axis=0) / square_mm).astype(int)
        has_marker[row, column] = True
        bits = np.asarray(cv2.aruco.generateImageMarker(dictionary, int(number), cells)) < 128
        draw_cells(page, bits, left_mm + at_mm[0, 0], top_mm + at_mm[0, 1], marker_mm / cells)
    for row, column in np.argwhere(~has_marker):
        page.rectangle(left_mm + column * square_mm, top_mm + row * square_mm, square_mm, square_mm)


def draw_cells(
    page: PdfPage, dark: npt.NDArray[np.bool_], left_mm: float, top_mm: float, cell_mm: float
) -> None:
    """Black cells of a grid (rows, columns); a run of them is drawn as one, without hairlines."""
    for row, line in enumerate(dark):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], line.astype(np.int8), [0]])))
        for begin, end in edges.reshape(-1, 2):
            width_mm = float(end - begin) * cell_mm
            page.rectangle(left_mm + begin * cell_mm, top_mm + row * cell_mm, width_mm, cell_mm)
