"""A part's place by its box: exact where the rotation is, and never worse than what was found."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.tracking.detection.box_placement import placed_by_box
from snapfit.tracking.detection.candidates import overlaps
from snapfit.tracking.detection.parameters import BoxParameters

CAMERA = PinholeCamera(1280, 720, 607.0, 607.0, 639.0, 365.0)
PARAMETERS = BoxParameters()
CORNERS = np.array([[x, y, z] for x in (-0.03, 0.05) for y in (-0.02, 0.02) for z in (0, 0.03)])


def box_of(pose):
    pixels = CAMERA.project(pose.transform(CORNERS))
    return np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])


@given(
    turn=st.tuples(*[st.floats(-3, 3)] * 3),
    x=st.floats(-0.25, 0.25),
    y=st.floats(-0.12, 0.12),
    z=st.floats(0.35, 1.2),
    farther=st.floats(0.6, 5.0),
)
def test_the_true_place_is_found_from_any_distance_on_the_ray(turn, x, y, z, farther):
    true = Pose.exp([*turn, 0, 0, 0])
    true = Pose.from_rotation_translation(true.rotation, np.array([x, y, z]))
    wrong = Pose.from_rotation_translation(true.rotation, true.translation * farther)
    found = placed_by_box(wrong, CORNERS, box_of(true), CAMERA, PARAMETERS)
    assert found is not None
    if found is wrong:
        # Near enough that the box is filled: it stays.
        assert abs(farther - 1) < 0.1
    else:
        assert np.abs(found.translation - true.translation).max() < 1e-3 * z
    assert np.array_equal(found.rotation, true.rotation)


def test_a_pose_that_fills_its_box_stays():
    pose = Pose.from_translation(0.1, 0.05, 0.6)
    assert placed_by_box(pose, CORNERS, box_of(pose) + 1.0, CAMERA, PARAMETERS) is pose


def test_with_a_wrong_rotation_the_box_is_filled_as_well_as_can_be():
    true = Pose.from_translation(0.0, 0.0, 0.7)
    turned = Pose.exp([0.3, 0.2, 0.4, 0, 0, 0])
    wrong = Pose.from_rotation_translation(turned.rotation, np.array([0.0, 0.0, 1.9]))
    found = placed_by_box(wrong, CORNERS, box_of(true), CAMERA, PARAMETERS)
    assert found is not None
    before, after = (overlaps(box_of(true), box_of(each)[None])[0] for each in (wrong, found))
    assert after > 0.6
    assert after > before + 0.2


def test_a_side_at_the_images_border_is_not_the_parts_own():
    true = Pose.from_translation(-0.62, 0.0, 0.6)
    cut = np.clip(box_of(true), 0, (1280, 720, 1280, 720))
    assert cut[0] == 0
    wrong = Pose.from_translation(-1.1, 0.0, 1.1)
    found = placed_by_box(wrong, CORNERS, cut, CAMERA, PARAMETERS)
    assert found is not None
    assert np.abs(found.translation - true.translation).max() < 2e-3


@pytest.mark.parametrize("box", [[0, 0, 1280, 400], [0, 300, 1280, 360], [0, 0, 100, 720]])
def test_a_box_that_is_cut_off_on_two_sides_says_nothing(box):
    wrong = Pose.from_translation(0.3, 0.2, 3.0)
    assert placed_by_box(wrong, CORNERS, np.array(box, float), CAMERA, PARAMETERS) is None


def test_a_box_that_would_need_the_part_in_the_lens():
    wrong = Pose.from_translation(0.0, 0.0, 0.5)
    huge = np.array([-9000.0, 10.0, 9000.0, 700.0]).clip(5, 1275)
    found = placed_by_box(wrong, CORNERS, huge, CAMERA, PARAMETERS)
    assert found is None or found.translation[2] > PARAMETERS.nearest_m
