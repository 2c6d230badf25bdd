"""Calibrates a camera from images of a ChArUco board, and says how far that can be believed.

Source: Z. Zhang, "A flexible new technique for camera calibration" (2000), in OpenCV's form.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera_file import CameraFile
from snapfit.models.charuco import CharucoBoard
from snapfit.models.errors import CalibrationError

_WORST_TOLD = 3


@dataclass(frozen=True)
class CalibrationParameters:
    """When a calibration is refused.

    Attributes:
        least_views: images that show the board.
        least_corners: of the board, share that has to be found in an image for it to count.
        most_rms_px: root mean square of the reprojection error.
        least_tilt_deg: between the two views that differ most; boards that all face the camera
            leave focal length and distance open together, and no deviation shows it.
        most_focal_error: three standard deviations of the focal length, as a share of it.
        least_coverage: share of the image, in 4x4 fields, in which corners were seen.
        k3_gain: share by which the third radial coefficient has to lower the error to be used;
            where it is not needed it bends the image's corners.
    """

    least_views: int = 10
    least_corners: float = 0.3
    most_rms_px: float = 1.0
    least_tilt_deg: float = 20.0
    most_focal_error: float = 0.02
    least_coverage: float = 0.6
    k3_gain: float = 0.1


@dataclass(frozen=True, eq=False)
class View:
    """The board in one image.

    Attributes:
        name: of the image.
        points_m: (N, 3) float32, corners in the board's frame, metres.
        pixels: (N, 2) float32, where they are seen.
    """

    name: str
    points_m: npt.NDArray[np.float32]
    pixels: npt.NDArray[np.float32]


class BoardFinder:
    """Finds a board in images.

    Args:
        board: that is looked for.
        parameters: how much of it has to be seen.
    """

    def __init__(
        self, board: CharucoBoard, parameters: CalibrationParameters | None = None
    ) -> None:
        self._board = board
        share = (parameters or CalibrationParameters()).least_corners
        self._least = max(6, math.ceil(share * board.n_corners))
        self._detector = cv2.aruco.CharucoDetector(board.opencv)

    def find(self, name: str, image: npt.NDArray[np.uint8]) -> View | None:
        """The board in an image (H, W, 3) BGR or (H, W), uint8; None where too little is seen."""
        gray = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        corners, ids, _, _ = self._detector.detectBoard(gray)
        if ids is None or len(ids) < self._least:
            return None
        points, pixels = self._board.opencv.matchImagePoints(corners, ids)
        return View(
            name,
            np.asarray(points, dtype=np.float32).reshape(-1, 3),
            np.asarray(pixels, dtype=np.float32).reshape(-1, 2),
        )


def calibrate(
    views: Sequence[View],
    size: tuple[int, int],
    board: CharucoBoard,
    parameters: CalibrationParameters | None = None,
) -> CameraFile:
    """The camera that saw these views.

    Args:
        views: of one board, from different sides.
        size: width and height of the images, px.
        board: that was seen.
        parameters: when it is refused.

    Raises:
        CalibrationError: too few views, too small a part of the image, a large error, or a focal
            length that these views do not determine.
    """
    p = parameters or CalibrationParameters()
    if len(views) < p.least_views:
        raise CalibrationError(
            f"the board was seen in {len(views)} images, at least {p.least_views} are needed: "
            "show it whole, sharp and well lit, from different sides"
        )
    _check_coverage(views, size, p)
    solution = _solve(views, size, cv2.CALIB_FIX_K3)
    with_k3 = _solve(views, size, 0)
    if with_k3.rms_px < (1 - p.k3_gain) * solution.rms_px:
        solution = with_k3
    _check(solution, views, p)
    k = solution.matrix
    return CameraFile(
        width=size[0],
        height=size[1],
        fx=float(k[0, 0]),
        fy=float(k[1, 1]),
        cx=float(k[0, 2]),
        cy=float(k[1, 2]),
        distortion=tuple(solution.distortion.ravel().tolist()),
        rms_px=round(solution.rms_px, 4),
        images=len(views),
        date=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        board=str(board),
    )


@dataclass(frozen=True, eq=False)
class _Solution:
    rms_px: float
    matrix: npt.NDArray[np.float64]
    distortion: npt.NDArray[np.float64]
    focal_deviation_px: float
    tilt_deg: float
    view_errors_px: npt.NDArray[np.float64]


def _solve(views: Sequence[View], size: tuple[int, int], flags: int) -> _Solution:
    points: list[Any] = [view.points_m for view in views]
    pixels: list[Any] = [view.pixels for view in views]
    try:
        rms, matrix, distortion, turns, _, deviations, _, errors = cv2.calibrateCameraExtended(
            points, pixels, size, np.eye(3), np.zeros(5), flags=flags
        )
    except cv2.error as error:
        raise CalibrationError(f"these views cannot be solved: {error.err}") from error
    numbers = np.asarray(deviations).ravel()
    return _Solution(
        float(rms),
        np.asarray(matrix, dtype=np.float64),
        np.asarray(distortion, dtype=np.float64),
        float(max(numbers[0], numbers[1])),
        _tilt_deg([np.asarray(turn, dtype=np.float64) for turn in turns]),
        np.asarray(errors).ravel(),
    )


def _tilt_deg(turns: Sequence[npt.NDArray[np.float64]]) -> float:
    """The largest angle between two boards' normals, from their rotation vectors."""
    normals = np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns])
    return float(np.degrees(np.arccos(np.clip(normals @ normals.T, -1, 1).min())))


def _check_coverage(views: Sequence[View], size: tuple[int, int], p: CalibrationParameters) -> None:
    fields = np.zeros((4, 4), dtype=bool)
    for view in views:
        place = (4 * view.pixels / np.array(size)).astype(int).clip(0, 3)
        fields[place[:, 1], place[:, 0]] = True
    share = float(fields.mean())
    if share < p.least_coverage:
        raise CalibrationError(
            f"the board was seen in {share:.0%} of the image, at least {p.least_coverage:.0%} is "
            "needed: bring it to the edges and corners too"
        )


def _check(solution: _Solution, views: Sequence[View], p: CalibrationParameters) -> None:
    if not math.isfinite(solution.rms_px) or solution.rms_px > p.most_rms_px:
        worst = np.argsort(-solution.view_errors_px)[:_WORST_TOLD]
        told = ", ".join(f"{views[i].name} ({solution.view_errors_px[i]:.1f} px)" for i in worst)
        raise CalibrationError(
            f"the error is {solution.rms_px:.2f} px, at most {p.most_rms_px:g} px is accepted: is "
            f"the board flat, the size of its squares right, no image blurred? The worst: {told}"
        )
    if not solution.tilt_deg >= p.least_tilt_deg:
        raise CalibrationError(
            f"the views differ by {solution.tilt_deg:.0f} degrees, at least {p.least_tilt_deg:.0f} "
            "are needed: tilt the board, by up to 45 degrees, to all sides"
        )
    focal_error = 3 * solution.focal_deviation_px / float(solution.matrix[0, 0])
    if not math.isfinite(focal_error) or focal_error > p.most_focal_error:
        raise CalibrationError(
            f"these views leave the focal length open by {focal_error:.1%}, at most "
            f"{p.most_focal_error:.0%} is accepted: tilt the board, by up to 45 degrees, to all "
            "sides, and bring it nearer"
        )
