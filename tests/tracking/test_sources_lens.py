"""A lens's distortion is undone: what was a straight grid of points is one again."""

import cv2
import numpy as np
import pytest

from snapfit.models.camera import PinholeCamera
from snapfit.tracking.sources.driver import Images, LensedCamera
from snapfit.tracking.sources.lens import Undistortion

CAMERA = PinholeCamera(640, 480, 520.0, 515.0, 322.0, 236.0)
BROWN = (-0.21, 0.08, 0.002, -0.001, 0.01)
RATIONAL = (0.4, -2.5, 0.001, -0.0002, 1.4, 0.3, -2.3, 1.3)
POINTS = np.array([[x, y, 1.0] for x in (-0.4, 0.0, 0.3) for y in (-0.3, 0.1, 0.3)])


def seen(distortion: tuple[float, ...]) -> np.ndarray:
    """(N, 2) where the lens puts the points, px."""
    zero = np.zeros(3)
    return cv2.projectPoints(POINTS, zero, zero, CAMERA.matrix, np.array(distortion))[0][:, 0]


@pytest.mark.parametrize("distortion", [BROWN, RATIONAL])
def test_points_are_where_a_pinhole_camera_sees_them(distortion: tuple[float, ...]) -> None:
    y, x = np.mgrid[:480, :640]
    undo = Undistortion(LensedCamera("camera", CAMERA, 30.0, distortion))
    wanted = CAMERA.project(POINTS)
    for place, at in zip(seen(distortion), wanted, strict=True):
        blob = 255 * np.exp(-((x - place[0]) ** 2 + (y - place[1]) ** 2) / (2 * 3.0**2))
        color = np.repeat(np.rint(blob).astype(np.uint8)[..., None], 3, axis=2)
        straight = undo.undo(Images(color)).color[..., 0].astype(float)
        found = (straight * x).sum() / straight.sum(), (straight * y).sum() / straight.sum()
        assert np.linalg.norm(np.array(found) - at) < 0.3
    assert np.linalg.norm(seen(distortion) - wanted, axis=1).max() > 3


def test_depth_takes_values_that_were_measured_and_no_others() -> None:
    depth_camera = PinholeCamera(64, 48, 52.0, 52.0, 31.5, 23.5)
    lensed = LensedCamera("camera", CAMERA, 30.0, (), depth_camera, BROWN)
    depth = np.where(np.arange(64) < 32, 500, 900).astype(np.uint16) * np.ones((48, 1), np.uint16)
    color = np.zeros((480, 640, 3), np.uint8)
    straight = Undistortion(lensed).undo(Images(color, depth))
    assert straight.depth is not None
    assert straight.depth.dtype == np.uint16
    assert set(np.unique(straight.depth)) <= {0, 500, 900}


def test_without_distortion_the_pixels_stay_and_the_arrays_are_new() -> None:
    rng = np.random.default_rng(1)
    color = rng.integers(0, 256, (480, 640, 3)).astype(np.uint8)
    straight = Undistortion(LensedCamera("camera", CAMERA, 30.0, (0.0,) * 5)).undo(Images(color))
    assert np.array_equal(straight.color, color)
    assert not np.shares_memory(straight.color, color)
