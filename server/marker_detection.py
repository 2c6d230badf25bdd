"""Where a board stands, from one image. Workers only."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.server.boards import ArucoMarker, Board, CharucoBoard, MarkerDictionary, QrCode
from snapfit.server.qr_corners import qr_corners

_FEWEST_CORNERS = 6
_AMBIGUOUS_RATIO = 1.5
"""A square far away looks alike from two sides: the better pose must be clearly the better one."""
_LARGEST_ERROR_PX = 3.0

Points = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MarkerPose:
    """A board as the camera sees it.

    Attributes:
        camera_from_marker: its pose, in the colour camera's frame.
        error_px: root mean square of the corners' reprojection errors.
        corners: how many were seen.
    """

    camera_from_marker: Pose
    error_px: float
    corners: int


class MarkerDetector:
    """Finds one board.

    Args:
        board: what to look for.
        camera: of the images, which are undistorted.
    """

    def __init__(self, board: Board, camera: PinholeCamera) -> None:
        self._board = board
        self._intrinsics = np.array(
            [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]], dtype=np.float64
        )
        if isinstance(board, CharucoBoard):
            self._charuco = opencv_board(board)
            self._charuco_detector = cv2.aruco.CharucoDetector(self._charuco)
        elif isinstance(board, ArucoMarker):
            refined = cv2.aruco.DetectorParameters()
            refined.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
            dictionary = opencv_dictionary(board.dictionary)
            self._aruco_detector = cv2.aruco.ArucoDetector(dictionary, refined)
        else:
            self._qr_detector = cv2.QRCodeDetector()

    def detect(self, gray: npt.NDArray[np.uint8]) -> MarkerPose | None:
        """The board in an image (H, W); None where it is not seen well enough."""
        if isinstance(self._board, CharucoBoard):
            found = self._charuco_corners(gray)
        elif isinstance(self._board, ArucoMarker):
            found = self._aruco_corners(gray, self._board)
        else:
            found = self._qr_corners(gray, self._board)
        return None if found is None else self._pose(*found)

    def _charuco_corners(self, gray: npt.NDArray[np.uint8]) -> tuple[Points, Points] | None:
        corners, ids, _, _ = self._charuco_detector.detectBoard(gray)
        if ids is None or len(ids) < _FEWEST_CORNERS:
            return None
        known = np.asarray(self._charuco.getChessboardCorners(), dtype=np.float64)
        width, height = _size_m(self._board)
        known = known - (width / 2, height / 2, 0)
        return known[np.ravel(ids)], np.asarray(corners, dtype=np.float64).reshape(-1, 2)

    def _aruco_corners(
        self, gray: npt.NDArray[np.uint8], marker: ArucoMarker
    ) -> tuple[Points, Points] | None:
        corners, ids, _ = self._aruco_detector.detectMarkers(gray)
        if ids is None:
            return None
        places = np.flatnonzero(np.ravel(ids) == marker.id)
        if len(places) != 1:  # not there, or several of which nobody knows which is meant
            return None
        return _square(marker.size_m), np.asarray(corners[places[0]], np.float64).reshape(4, 2)

    def _qr_corners(
        self, gray: npt.NDArray[np.uint8], code: QrCode
    ) -> tuple[Points, Points] | None:
        found, texts, quads, codes = self._qr_detector.detectAndDecodeMulti(gray)
        places = [i for i, text in enumerate(texts) if text == code.text] if found else []
        if len(places) != 1:
            return None
        quad = np.asarray(quads[places[0]], np.float64).reshape(4, 2)
        inner = qr_corners(gray, np.asarray(codes[places[0]]), quad)
        if inner is None:  # far away: the four outer ones, which are coarse
            return _square(code.size_m), quad
        plane = (inner.places - 0.5) * code.size_m
        return np.column_stack([plane, np.zeros(len(plane))]), inner.pixels

    def _pose(self, points: Points, seen: Points) -> MarkerPose | None:
        """From a plane's points (N, 3), metres, and where they are seen (N, 2), px (IPPE)."""
        n, turns, ways, errors = cv2.solvePnPGeneric(
            points, seen, self._intrinsics, None, flags=cv2.SOLVEPNP_IPPE
        )
        errors = np.ravel(errors)
        if n == 0 or (n > 1 and errors[1] < _AMBIGUOUS_RATIO * errors[0]):
            return None
        turn, way = cv2.solvePnPRefineLM(
            points, seen, self._intrinsics, None, turns[0].copy(), ways[0].copy()
        )
        again, _ = cv2.projectPoints(points, turn, way, self._intrinsics, None)
        off = np.linalg.norm(np.asarray(again).reshape(-1, 2) - seen, axis=1)
        error_px = float(np.sqrt((off**2).mean()))
        rotation, _ = cv2.Rodrigues(turn)
        values = np.concatenate([np.ravel(rotation), np.ravel(way), [error_px]])
        if not np.isfinite(values).all() or error_px > _LARGEST_ERROR_PX or way[2, 0] <= 0:
            return None
        pose = Pose.from_rotation_translation(np.asarray(rotation), np.ravel(way))
        return MarkerPose(pose, error_px, len(points))


def opencv_dictionary(name: MarkerDictionary) -> cv2.aruco.Dictionary:
    """OpenCV's dictionary of this name."""
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))


def opencv_board(board: CharucoBoard) -> cv2.aruco.CharucoBoard:
    """The board as OpenCV describes it.

    Raises:
        cv2.error: its sizes do not fit together.
    """
    size = (board.columns, board.rows)
    dictionary = opencv_dictionary(board.dictionary)
    return cv2.aruco.CharucoBoard(size, board.square_m, board.marker_m, dictionary)


def _size_m(board: Board) -> tuple[float, float]:
    if not isinstance(board, CharucoBoard):
        return board.size_m, board.size_m
    return board.columns * board.square_m, board.rows * board.square_m


def _square(size_m: float) -> Points:
    """Corners from the top left one clockwise, around the middle."""
    h = size_m / 2
    return np.array([[-h, -h, 0], [h, -h, 0], [h, h, 0], [-h, h, 0]])
