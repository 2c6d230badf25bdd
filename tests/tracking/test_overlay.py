"""The parts drawn into the camera's image."""

import cv2
import numpy as np
import pytest
import trimesh

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.tracking.overlay import draw_overlay
from snapfit.tracking.result import PartEstimate, Status

CAMERA = PinholeCamera(160, 120, fx=150.0, fy=150.0, cx=80.0, cy=60.0)
CUBE_M = 0.1
SIZE_PX = CUBE_M * 150 / (0.5 - CUBE_M / 2)


def cube(name: str, color_rgb: tuple[int, int, int] = (0, 0, 255)) -> Part:
    box = trimesh.creation.box([CUBE_M] * 3)
    return Part(name, Mesh(box.vertices, box.faces), color_rgb)


PARTS = (cube("cube"), cube("other", (255, 0, 0)))


def estimate(
    pose: Pose | None, part: str = "cube", status: Status = Status.TRACKED
) -> PartEstimate:
    return PartEstimate(part, status, 0.9, pose)


def image() -> np.ndarray:
    return np.random.default_rng(1).integers(0, 256, (120, 160, 3), dtype=np.uint8)


def silhouette(*poses: Pose, beside_px: int = 0) -> np.ndarray:
    """Where the cubes are, and up to so many pixels beside them."""
    mask = (render(CAMERA, [(PARTS[0].mesh, pose) for pose in poses]).part_id > 0).astype(np.uint8)
    kernel = np.ones((2 * beside_px + 1, 2 * beside_px + 1), dtype=np.uint8)
    return cv2.dilate(mask, kernel).astype(bool)


def changed(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    return (before != after).any(axis=2)


TURNED = Pose.from_translation(0.02, -0.03, 0.5).perturbed([0.4, 0.7, -0.2, 0, 0, 0])


@pytest.mark.parametrize("pose", [Pose.from_translation(0, 0, 0.5), TURNED])
def test_pixels_change_where_the_part_is_and_nowhere_else(pose: Pose) -> None:
    before = image()
    after = draw_overlay(before, CAMERA, PARTS, [estimate(pose)])
    assert not changed(before, after)[~silhouette(pose, beside_px=2)].any()
    # A pixel that has the blended colour already is rare.
    assert changed(before, after)[silhouette(pose)].mean() > 0.98
    assert after.dtype == np.uint8
    assert after.shape == before.shape


def test_the_image_that_is_given_is_left_as_it_is() -> None:
    before = image()
    draw_overlay(before, CAMERA, PARTS, [estimate(TURNED)])
    assert np.array_equal(before, image())


def test_a_read_only_image_will_do() -> None:
    before = image()
    before.setflags(write=False)
    after = draw_overlay(before, CAMERA, PARTS, [estimate(TURNED)])
    assert changed(before, after).any()


@pytest.mark.parametrize(
    "estimates",
    [
        [],
        [estimate(None, status=Status.LOST), estimate(None, "other", Status.SEARCHING)],
        [estimate(TURNED, "a part that nobody knows")],
    ],
    ids=["none", "no pose", "unknown"],
)
def test_without_a_pose_the_picture_is_an_identical_copy(estimates: list[PartEstimate]) -> None:
    before = image()
    after = draw_overlay(before, CAMERA, PARTS, estimates)
    assert np.array_equal(after, before)
    assert not np.shares_memory(after, before)


@pytest.mark.parametrize("z_m", [-0.5, -0.01, 0.0, 0.01, 1e-4, 1e3])
def test_a_part_behind_or_around_or_far_from_the_camera_does_no_harm(z_m: float) -> None:
    pose = Pose.from_translation(0.001, 0, z_m).perturbed([0.3, 0.2, 0.1, 0, 0, 0])
    after = draw_overlay(image(), CAMERA, PARTS, [estimate(pose), estimate(TURNED, "other")])
    only_other = draw_overlay(image(), CAMERA, PARTS, [estimate(TURNED, "other")])
    assert after.shape == only_other.shape
    if z_m < -CUBE_M:
        assert np.array_equal(after, only_other)
    if z_m > 100:
        # A dot, of the width of the axes' lines.
        assert changed(only_other, after).sum() < 25


def test_a_part_behind_the_camera_is_not_drawn() -> None:
    before = image()
    behind = Pose.from_translation(0, 0, -0.5)
    assert np.array_equal(draw_overlay(before, CAMERA, PARTS, [estimate(behind)]), before)


def test_a_part_beside_the_image_is_not_drawn() -> None:
    before = image()
    beside = Pose.from_translation(3, 0, 0.5)
    assert np.array_equal(draw_overlay(before, CAMERA, PARTS, [estimate(beside)]), before)


def gray() -> np.ndarray:
    return np.full((120, 160, 3), 100, dtype=np.uint8)


def test_parts_are_tinted_in_their_colours_and_the_nearer_is_in_front() -> None:
    near, far = Pose.from_translation(-0.03, 0, 0.4), Pose.from_translation(0.05, 0, 0.6)
    for estimates in (
        [estimate(near), estimate(far, "other")],
        [estimate(far, "other"), estimate(near)],
    ):
        picture = draw_overlay(gray(), CAMERA, PARTS, estimates).astype(int)
        # In the lower halves, away from the axes of the body frames.
        u, v = np.round(CAMERA.project(np.array([0.01, 0.04, 0.35]))).astype(int)
        blue_of_near = picture[v, u]
        u, v = np.round(CAMERA.project(np.array([0.08, 0.04, 0.55]))).astype(int)
        red_of_far = picture[v, u]
        assert blue_of_near[0] > 130 > blue_of_near[2]
        assert red_of_far[2] > 130 > red_of_far[0]


@pytest.mark.parametrize(
    ("status", "color"),
    [
        (Status.TRACKED, (255, 255, 255)),
        (Status.PREDICTED, (0, 200, 255)),
        (Status.INFERRED, (0, 200, 255)),
    ],
)
def test_the_outline_tells_what_is_seen_from_what_is_carried_on(
    status: Status, color: tuple[int, int, int]
) -> None:
    pose = Pose.from_translation(0, 0, 0.5)
    picture = draw_overlay(gray(), CAMERA, PARTS, [estimate(pose, status=status)])
    inside = silhouette(pose)
    border = inside & ~cv2.erode(inside.astype(np.uint8), np.ones((3, 3))).astype(bool)
    assert border.sum() > 3.5 * SIZE_PX
    on_border = picture[border].astype(int)
    assert (np.abs(on_border - color).max(axis=1) < 90).mean() > 0.95


def test_the_axes_stand_at_the_body_frames_origin() -> None:
    """x red, y green, z blue; x to the right, y down when the body is not turned."""
    pose = Pose.from_translation(0, 0, 0.5)
    length_px = 0.4 * PARTS[0].mesh.radius_m * 150 / 0.5
    picture = draw_overlay(gray(), CAMERA, PARTS, [estimate(pose)]).astype(int)
    x_axis = picture[60, int(80 + 0.7 * length_px)]
    y_axis = picture[int(60 + 0.7 * length_px), 80]
    assert x_axis.argmax() == 2
    assert y_axis.argmax() == 1
    assert x_axis[2] > 200
    assert y_axis[1] > 180
