"""Products and actions of poses in single precision, against `Pose`."""

import numpy as np
from scenes import CAMERA, both_cameras, kernel_camera, random_pose

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.tracking.kernels.geometry import intrinsics, multiply_poses, rotate, transform


def test_products_of_poses() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        a, b = random_pose(rng), random_pose(rng)
        out = np.full((4, 4), np.nan, dtype=np.float32)
        multiply_poses(np.array(a.matrix), np.array(b.matrix), out)
        assert np.allclose(out, (a @ b).matrix, atol=1e-6)
        assert out[3].tolist() == [0, 0, 0, 1]


def test_points_move_and_directions_turn() -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        pose, point = random_pose(rng), rng.normal(size=3).astype(np.float32)
        matrix = pose.matrix.astype(np.float32)
        assert np.allclose(transform(matrix, *point), pose.transform(point), atol=1e-6)
        assert np.allclose(rotate(matrix, *point), pose.rotation @ point, atol=1e-6)


def test_intrinsics_have_their_names() -> None:
    camera = kernel_camera()
    assert (camera.width, camera.height) == (CAMERA.width, CAMERA.height)
    assert np.allclose(
        [camera.fx, camera.fy, camera.cx, camera.cy], [CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy]
    )


def test_kernel_cameras_hold_both_ways_between_them() -> None:
    color_from_depth = random_pose(np.random.default_rng(3))
    depth = PinholeCamera(64, 48, 50.0, 51.0, 31.0, 22.0)
    cameras = both_cameras(depth=depth, color_from_depth=color_from_depth)
    assert np.allclose(cameras.color_from_depth @ cameras.depth_from_color, np.eye(4), atol=1e-6)
    assert np.allclose(cameras.color_from_depth, color_from_depth.matrix, atol=1e-6)
    assert intrinsics(cameras.depth) == (50, 51, 31, 22, 64, 48)
    assert intrinsics(cameras.color)[4:] == (CAMERA.width, CAMERA.height)


def test_without_a_depth_camera_the_colour_camera_stands_in() -> None:
    cameras = both_cameras(depth=None)
    assert np.array_equal(cameras.depth, cameras.color)
    assert np.array_equal(cameras.color_from_depth, Pose.identity().matrix)
