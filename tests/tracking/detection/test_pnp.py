"""Poses from keypoints: exact ones, outliers, and all that has to be rejected."""

import numpy as np
import pytest
from fake_network import CAMERA, MODELS, POSES

from snapfit.models.pose import Pose
from snapfit.tracking.detection.parameters import PnpParameters
from snapfit.tracking.detection.pnp import PnpPose, Rejection, pose_from_keypoints

POINTS = MODELS[0].points
TRUE = POSES[MODELS[0].name]
SURE = np.ones(17, dtype=np.float32)


def seen(pose=TRUE, points=POINTS):
    return CAMERA.project(pose.transform(points))


def solve(pixels, presence=SURE, points=POINTS, **changes):
    return pose_from_keypoints(points, pixels, presence, CAMERA, PnpParameters(**changes))


@pytest.mark.parametrize("seed", range(8))
def test_any_pose_before_the_camera_is_found(seed):
    rng = np.random.default_rng(seed)
    place = rng.uniform((-0.15, -0.1, 0.35), (0.15, 0.1, 0.9))
    pose = Pose.from_rotation_translation(Pose.exp([*rng.normal(0, 2, 3), 0, 0, 0]).rotation, place)
    found = solve(seen(pose))
    assert isinstance(found, PnpPose)
    assert found.camera_from_body.distance_to(pose) < 1e-4
    assert found.camera_from_body.angle_to(pose) < 1e-3


def test_noise_of_a_pixel_costs_little():
    rng = np.random.default_rng(0)
    found = solve(seen() + rng.normal(0, 1, (17, 2)))
    assert found.is_inlier.all()
    assert 0.5 < found.error_px < 1.6
    assert found.camera_from_body.angle_to(TRUE) < np.radians(3)
    assert found.camera_from_body.distance_to(TRUE) < 0.015


@pytest.mark.parametrize("n_outliers", [3, 6, 8])
def test_outliers_do_not_pull(n_outliers):
    rng = np.random.default_rng(n_outliers)
    pixels = seen()
    wrong = rng.choice(17, n_outliers, replace=False)
    pixels[wrong] += rng.uniform(40, 90, (n_outliers, 2)) * rng.choice([-1, 1], (n_outliers, 2))
    found = solve(pixels)
    assert set(np.flatnonzero(~found.is_inlier)) == set(wrong)
    assert found.camera_from_body.distance_to(TRUE) < 1e-3


def test_fewer_than_four_inliers():
    rng = np.random.default_rng(5)
    pixels = seen()
    pixels[3:] = rng.uniform(0, (640, 360), (14, 2))
    assert solve(pixels, least_inliers=4, threshold_px=2.0) is Rejection.FEW_INLIERS
    assert solve(rng.uniform(0, (640, 360), (17, 2))) is Rejection.FEW_INLIERS


def test_too_few_keypoints_in_the_image():
    presence = np.zeros(17, dtype=np.float32)
    presence[:5] = 1
    assert solve(seen(), presence) is Rejection.FEW_KEYPOINTS
    assert isinstance(solve(seen(), presence, least_inliers=4), PnpPose)
    # Even where fewer were allowed, three points leave several poses.
    assert solve(seen()[:3], presence[:3], POINTS[:3], least_inliers=1) is Rejection.FEW_KEYPOINTS


def test_a_part_that_would_lie_behind_the_camera():
    """Projected through the centre: a mirrored picture, as a part behind the camera gives it."""
    behind = Pose.from_rotation_translation(TRUE.rotation, -TRUE.translation)
    points = behind.transform(POINTS)
    assert (points[:, 2] < 0).all()
    found = solve(CAMERA.project(points))
    assert (
        isinstance(found, Rejection) or (found.camera_from_body.transform(POINTS)[:, 2] > 0).all()
    )


def test_a_part_that_reaches_behind_the_camera():
    near = Pose.from_translation(0, 0, 0.02)
    points = near.transform(POINTS)
    assert points[:, 2].min() < 0 < points[:, 2].max()
    assert solve(CAMERA.project(points), threshold_px=1e3) is Rejection.BEHIND_CAMERA


def test_a_part_too_far_away():
    assert solve(seen(), farthest_m=0.3) is Rejection.DISTANCE
    assert solve(seen(), nearest_m=0.9) is Rejection.DISTANCE


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_none(value):
    pixels = seen()
    pixels[4, 1] = value
    assert solve(pixels) is Rejection.NOT_FINITE
    presence = SURE.copy()
    presence[0] = np.nan
    assert solve(seen(), presence) is Rejection.NOT_FINITE


def test_points_that_fall_together_give_no_pose():
    assert solve(np.tile(seen().mean(axis=0), (17, 1))) is Rejection.DISTANCE
    assert solve(seen(), points=np.zeros((17, 3))) is Rejection.FEW_INLIERS
