"""Undoes the distortion of a lens: after that a camera is a pinhole with the same intrinsics."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.tracking.sources.driver import Images, LensedCamera


class Undistortion:
    """Undoes one camera's distortion; the tables are made once.

    Args:
        lensed: the camera.
    """

    def __init__(self, lensed: LensedCamera) -> None:
        self._color = _maps(lensed.color, lensed.color_distortion)
        self._depth = None
        if lensed.depth is not None:
            self._depth = _maps(lensed.depth, lensed.depth_distortion)

    def undo(self, images: Images) -> Images:
        """The images of the pinhole camera; new arrays.

        Colour is interpolated. Depth takes the nearest value: between two surfaces there is
        nothing. What lies outside the image is black, and without depth.
        """
        color, depth = images.color, images.depth
        if self._color is not None:
            color = np.asarray(cv2.remap(color, *self._color, cv2.INTER_LINEAR), dtype=np.uint8)
        else:
            color = np.array(color, dtype=np.uint8, order="C")
        if depth is not None and self._depth is not None:
            nearest = cv2.remap(depth, *self._depth, cv2.INTER_NEAREST)
            depth = np.asarray(nearest, dtype=np.uint16)
        elif depth is not None:
            depth = np.array(depth, dtype=np.uint16, order="C")
        return Images(color, depth)


def _maps(
    camera: PinholeCamera, distortion: Sequence[float]
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]] | None:
    """Where in the distorted image each pixel comes from; None where there is nothing to undo."""
    if not any(distortion):
        return None
    coefficients = np.array(distortion, dtype=np.float64)
    size = (camera.width, camera.height)
    x, y = cv2.initUndistortRectifyMap(
        camera.matrix, coefficients, np.eye(3), camera.matrix, size, cv2.CV_32FC1
    )
    return np.asarray(x), np.asarray(y)
