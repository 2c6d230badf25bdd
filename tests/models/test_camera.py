"""Pinhole cameras: projection, scaling, and cameras that cannot exist."""

import numpy as np
import pytest

from snapfit.models.camera import AZURE_KINECT_720P, PinholeCamera, RgbdCamera
from snapfit.models.errors import CameraError

CAMERA = PinholeCamera(640, 480, fx=500.0, fy=510.0, cx=320.5, cy=239.0)


def test_projection_agrees_with_the_matrix() -> None:
    points = np.random.default_rng(1).uniform((-0.3, -0.2, 0.4), (0.3, 0.2, 1.5), (50, 3))
    by_matrix = points @ CAMERA.matrix.T
    assert np.allclose(CAMERA.project(points), by_matrix[:, :2] / by_matrix[:, 2:])


def test_a_point_on_the_axis_falls_on_the_principal_point() -> None:
    assert CAMERA.project(np.array([0.0, 0.0, 0.7])).tolist() == [320.5, 239.0]


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0])
def test_a_scaled_camera_sees_the_same_from_border_to_border(factor: float) -> None:
    scaled = CAMERA.scaled(factor)
    assert (scaled.width, scaled.height) == (640 * factor, 480 * factor)
    points = np.random.default_rng(2).uniform((-0.3, -0.2, 0.4), (0.3, 0.2, 1.5), (50, 3))
    # Pixel centres at integers: the image's border is half a pixel outside.
    assert np.allclose(scaled.project(points) + 0.5, (CAMERA.project(points) + 0.5) * factor)


def test_scaling_to_whole_pixels_keeps_both_sides() -> None:
    scaled = PinholeCamera(101, 51, 80, 80, 50, 25).scaled(0.5)
    assert (scaled.width, scaled.height) == (50, 26)
    assert scaled.fx == pytest.approx(80 * 50 / 101)
    assert scaled.fy == pytest.approx(80 * 26 / 51)


@pytest.mark.parametrize("name", ["width", "height", "fx", "fy"])
@pytest.mark.parametrize("value", [0, -3, float("nan"), float("inf")])
def test_sizes_and_focal_lengths_must_be_positive(name: str, value: float) -> None:
    good = {"width": 640, "height": 480, "fx": 500.0, "fy": 500.0, "cx": 320.0, "cy": 240.0}
    with pytest.raises(CameraError, match=f"{name} is .* positive"):
        PinholeCamera(**{**good, name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["cx", "cy"])
def test_the_principal_point_must_be_finite(name: str) -> None:
    good = {"width": 640, "height": 480, "fx": 500.0, "fy": 500.0, "cx": 320.0, "cy": 240.0}
    with pytest.raises(CameraError, match=f"{name} is nan"):
        PinholeCamera(**{**good, name: float("nan")})  # type: ignore[arg-type]


@pytest.mark.parametrize("scale", [0.0, -0.001, float("nan")])
def test_the_depth_scale_must_be_positive(scale: float) -> None:
    with pytest.raises(CameraError, match="depth_scale_m"):
        RgbdCamera(CAMERA, depth=CAMERA, depth_scale_m=scale)


def test_an_rgbd_camera_stands_where_its_colour_camera_does() -> None:
    camera = RgbdCamera(AZURE_KINECT_720P)
    assert camera.depth is None
    assert np.array_equal(camera.color_from_depth.matrix, np.eye(4))
