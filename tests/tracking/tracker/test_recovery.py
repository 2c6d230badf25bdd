"""Known answers: draw a part, start beside the truth, come back to it."""

import itertools

import numpy as np
import pytest

from snapfit.models.pose import Pose
from snapfit.models.symmetry import distance_modulo_symmetry
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.result import Status
from snapfit.tracking.tracker import Tracker

HOME = Pose.from_rotation_translation(
    Pose.exp([0.5, 0.6, -0.3, 0, 0, 0]).rotation, (0.02, -0.01, 0.65)
)
OFFSETS = [
    np.array([*(np.radians(5.0) * np.array(turn)), *(0.01 * np.array(move))])
    for turn, move in itertools.product(
        [(1, 0, 0), (0, -1, 0), (0, 0, 1), (-0.6, 0.6, 0.5)],
        [(1, 0, 0), (0, 1, 0), (0, 0, -1), (0.6, -0.6, 0.5)],
    )
]


@pytest.fixture(scope="module")
def trackers(clamp, camera) -> dict[str, Tracker]:
    return {part.name: create_tracker("icg", [part], camera) for part in clamp}


@pytest.mark.parametrize("part_index", range(3))
def test_comes_back_from_a_grid_of_offsets(clamp, trackers, draw, part_index: int) -> None:
    part = clamp[part_index]
    tracker = trackers[part.name]
    frame = draw([part], {part.name: HOME})
    for offset in OFFSETS:
        tracker.start(frame, {part.name: HOME.perturbed(offset)})
        estimate = tracker.track(frame).parts[0]
        assert estimate.status is Status.TRACKED
        distance_m, angle_rad = distance_modulo_symmetry(
            estimate.camera_from_body, HOME, part.symmetry
        )
        assert distance_m < 0.001, (part.name, offset)
        assert np.degrees(angle_rad) < 1.0, (part.name, offset)


def test_follows_steps_of_8_mm_and_4_degrees(clamp, trackers, draw) -> None:
    part = clamp[0]
    tracker = trackers[part.name]
    step = np.array([*(np.radians(4.0) * np.array([0.6, -0.6, 0.53])), 0.0046, 0.0046, -0.0046])
    pose = HOME
    tracker.start(draw([part], {part.name: pose}), {part.name: pose})
    for k in range(5):
        pose = pose.perturbed(step)
        estimate = tracker.track(draw([part], {part.name: pose})).parts[0]
        assert estimate.camera_from_body.distance_to(pose) < 0.0015, k
        assert np.degrees(estimate.camera_from_body.angle_to(pose)) < 1.0, k


def test_two_starts_of_one_frame_give_the_same_bytes(clamp, trackers, draw) -> None:
    part = clamp[1]
    frame = draw([part], {part.name: HOME})
    poses = []
    for _ in range(2):
        trackers[part.name].start(frame, {part.name: HOME.perturbed(OFFSETS[3])})
        poses.append(trackers[part.name].track(frame).parts[0].camera_from_body.matrix.tobytes())
    assert poses[0] == poses[1]


def test_the_covariance_is_positive_definite_and_small_where_much_is_seen(
    clamp, trackers, draw
) -> None:
    part = clamp[0]
    frame = draw([part], {part.name: HOME})
    trackers[part.name].start(frame, {part.name: HOME})
    covariance = trackers[part.name].track(frame).parts[0].covariance
    assert covariance.shape == (6, 6)
    np.testing.assert_allclose(covariance, covariance.T, atol=1e-12)
    assert (np.linalg.eigvalsh(covariance) > 0).all()
    assert np.sqrt(covariance.diagonal()[3:]).max() < 0.01
