"""Boards as a camera would see them."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.server.boards import Board, CharucoBoard
from snapfit.server.marker_detection import opencv_board, opencv_dictionary

_SCALE = 4  # drawn larger and averaged, as a sensor's pixels do
_MARGIN = 0.1
_MODULE_PX = 28  # whole pixels, so that each of its corners is where it should be


def picture(board: Board) -> tuple[npt.NDArray[np.uint8], float, float]:
    """The board's picture, its width and height in metres."""
    if isinstance(board, CharucoBoard):
        side = round(2000 * board.square_m)  # the markers too are whole pixels then
        size = board.columns * side, board.rows * side
        image = opencv_board(board).generateImage(size, marginSize=0, borderBits=1)
        return np.asarray(image), board.columns * board.square_m, board.rows * board.square_m
    if board.kind == "aruco":
        image = cv2.aruco.generateImageMarker(opencv_dictionary(board.dictionary), board.id, 600)
        return np.asarray(image), board.size_m, board.size_m
    encoder = cv2.QRCodeEncoder.create()
    code = np.asarray(encoder.encode(board.text))
    dark = np.argwhere(code < 128)
    (top, left), (bottom, right) = dark.min(axis=0), dark.max(axis=0) + 1
    image = code[top:bottom, left:right].repeat(_MODULE_PX, axis=0).repeat(_MODULE_PX, axis=1)
    return image, board.size_m, board.size_m


def draw_board(
    board: Board, camera: PinholeCamera, camera_from_marker: Pose
) -> npt.NDArray[np.uint8]:
    """(H, W, 3) BGR: the board on white paper, before grey."""
    image, width_m, height_m = picture(board)
    rows, columns = image.shape
    rim = round(_MARGIN * columns)
    sheet = np.full((rows + 2 * rim, columns + 2 * rim), 255, dtype=np.uint8)
    sheet[rim:-rim, rim:-rim] = image
    corners = np.array([[0, 0], [columns, 0], [columns, rows], [0, rows]], dtype=np.float64)
    metres = corners * (width_m / columns, height_m / rows) - (width_m / 2, height_m / 2)
    points = camera_from_marker.transform(np.column_stack([metres, np.zeros(4)]))
    seen = points[:, :2] / points[:, 2:] * (camera.fx, camera.fy) + (camera.cx, camera.cy)
    # Pixel centres lie at integers, in the picture as in the camera.
    homography = cv2.getPerspectiveTransform(
        (corners + rim - 0.5).astype(np.float32), (_SCALE * (seen + 0.5) - 0.5).astype(np.float32)
    )
    size = _SCALE * camera.width, _SCALE * camera.height
    large: Any = cv2.warpPerspective(sheet, homography, size, flags=cv2.INTER_AREA, borderValue=128)
    gray = cv2.resize(large, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    return np.repeat(np.asarray(gray)[:, :, None], 3, axis=2)
