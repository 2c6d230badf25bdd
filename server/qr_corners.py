"""Corners inside a QR code, found to a fraction of a pixel.

A detector of QR codes tells four corners to about a pixel, the fourth by the other three. Once the
code is read, all its modules are known: where two dark ones meet at a corner, with two light ones
between them, is a corner as on a chessboard, and there are dozens of them.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

_FEWEST = 8
_LEAST_MODULE_PX = 3.0
_WINDOW = 0.45
_LARGEST_SHIFT = 0.5
_ROUNDS = 2
_CRITERIA = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)

Points = npt.NDArray[np.float64]


class QrCorners(NamedTuple):
    """Corners of a code.

    Attributes:
        places: (N, 2), from its left upper corner, in edges of the code, 0 to 1.
        pixels: (N, 2), where they are seen.
    """

    places: Points
    pixels: Points


def qr_corners(
    gray: npt.NDArray[np.uint8], modules: npt.NDArray[np.uint8], quad: Points
) -> QrCorners | None:
    """The corners inside a code; None where too few are seen.

    Args:
        gray: the image (H, W).
        modules: of the code (n, n), as it is read, dark below 128.
        quad: its four corners (4, 2), px, from the left upper one clockwise.
    """
    count = len(modules)
    places = _meeting_corners(modules < 128) / count
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float64)
    view = cv2.getPerspectiveTransform(square.astype(np.float32), quad.astype(np.float32))
    corners: QrCorners | None = None
    for _ in range(_ROUNDS):
        corners = _refined(gray, places, np.asarray(view, dtype=np.float64), count)
        if corners is None:
            return None
        view, inliers = cv2.findHomography(corners.places, corners.pixels, cv2.RANSAC, 1.0)
        if view is None:
            return None
        kept = np.ravel(inliers) > 0
        corners = QrCorners(corners.places[kept], corners.pixels[kept])
    return corners if corners is not None and len(corners.places) >= _FEWEST else None


def _meeting_corners(dark: npt.NDArray[np.bool_]) -> Points:
    """Where two dark modules touch at a corner alone: (N, 2), x and y in modules."""
    left_top, right_top = dark[:-1, :-1], dark[:-1, 1:]
    left_bottom, right_bottom = dark[1:, :-1], dark[1:, 1:]
    meet = (left_top == right_bottom) & (right_top == left_bottom) & (left_top != right_top)
    return np.argwhere(meet)[:, ::-1].astype(np.float64) + 1


def _refined(
    gray: npt.NDArray[np.uint8], places: Points, view: Points, count: int
) -> QrCorners | None:
    """Corners near where a homography (3, 3) from places to pixels has them."""
    if len(places) < _FEWEST:
        return None
    expected = _seen(view, places)
    beside = np.minimum(
        np.linalg.norm(_seen(view, places + np.array([1 / count, 0])) - expected, axis=1),
        np.linalg.norm(_seen(view, places + np.array([0, 1 / count])) - expected, axis=1),
    )
    module_px = float(np.median(beside))
    rim_px = 2 * module_px
    height, width = gray.shape
    inside = ((expected > rim_px) & (expected < np.array([width, height]) - rim_px)).all(axis=1)
    if module_px < _LEAST_MODULE_PX or inside.sum() < _FEWEST:
        return None
    places, expected = places[inside], expected[inside]
    half = max(round(_WINDOW * module_px), 2)
    pixels = expected.astype(np.float32).reshape(-1, 1, 2)
    pixels = cv2.cornerSubPix(gray, pixels, (half, half), (-1, -1), _CRITERIA)
    found = np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
    near = np.linalg.norm(found - expected, axis=1) < _LARGEST_SHIFT * module_px
    return QrCorners(places[near], found[near]) if near.sum() >= _FEWEST else None


def _seen(view: Points, places: Points) -> Points:
    seen = np.column_stack([places, np.ones(len(places))]) @ view.T
    return seen[:, :2] / seen[:, 2:]
