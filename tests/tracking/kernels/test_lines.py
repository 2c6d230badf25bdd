"""Finding correspondence lines: contour points of a flat board over an image with a known edge."""

from typing import Any

import numpy as np
import pytest
from scenes import CAMERA, bodies_at, both_cameras, images_of, occlusion

from snapfit.models.pose import Pose
from snapfit.tracking.kernels.region import find_lines
from snapfit.tracking.kernels.types import CONSIDERED, OCCLUDED, VALID, Images, Lines
from snapfit.tracking.parameters import RegionParameters
from snapfit.tracking.region_modality import empty_lines, region_settings

UNIT_M = 1e-5
HALF_M = np.array([0.09, 0.06])
DEPTH_M = 0.5
BODY_BGR, GROUND_BGR = (200, 40, 90), (30, 170, 60)
ANGLES_DEG = [0, 20, 45, 77, 90, 133, 180, 222, 270, 301]


def board_contour(n: int = 48, continuous_m: float = 0.05) -> np.ndarray:
    """(N, 9) int16: points along the border of a board in the plane z = 0, off its corners."""
    along = np.linspace(-0.6, 0.6, n // 4)
    contour = np.zeros((n, 9))
    for side in range(4):
        axis, sign = side % 2, 1 - side // 2 * 2
        points = contour[side::4]
        points[:, axis], points[:, 1 - axis] = sign * HALF_M[axis], along * HALF_M[1 - axis]
        points[:, 3 + axis] = sign * 32767 * UNIT_M
    contour[:, 6:8] = continuous_m
    return np.round(contour / UNIT_M).astype(np.int16)


def board_pose(angle_deg: float) -> Pose:
    return Pose.exp([0, 0, np.radians(angle_deg), 0, 0, 0]).perturbed([0, 0, 0, 0, 0, DEPTH_M])


def board_image(pose: Pose) -> np.ndarray:
    """Pixels whose rays meet the board in its colour, the others in the ground's."""
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    rays = np.stack([(u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy, np.ones(u.shape)])
    points = pose.inverse().transform(np.moveaxis(rays * DEPTH_M, 0, -1))
    on_board = (np.abs(points[..., :2]) < HALF_M).all(axis=-1)
    return np.where(on_board[..., None], BODY_BGR, GROUND_BGR).astype(np.uint8)


def board_table() -> np.ndarray:
    table = np.full((1, 4096), 0.5)
    for color, p in ((BODY_BGR, 0.95), (GROUND_BGR, 0.05)):
        b, g, r = (value // 16 for value in color)
        table[0, 256 * b + 16 * g + r] = p
    return table


def find(
    contour: np.ndarray,
    pose: Pose,
    images: Images,
    *,
    scale: int = 1,
    rows: tuple[int, int] | None = None,
    depth_pose: Pose | None = None,
    **hidden: Any,
) -> tuple[Lines, np.ndarray]:
    """The lines of one body, and what became of them."""
    lines = empty_lines(1, len(contour))
    lines.valid[:] = 7
    counts = np.zeros(4, dtype=np.int64)
    bodies = bodies_at([pose], board_table())
    if depth_pose is not None:
        bodies.depth_poses[0] = depth_pose.matrix
    find_lines(
        0,
        *(rows or (0, len(contour))),
        1,
        images,
        both_cameras(),
        bodies,
        contour,
        np.float32(UNIT_M),
        region_settings(RegionParameters(scales_px=(9, scale), min_continuous_distance=3.0), 2),
        occlusion(**hidden),
        lines,
        counts,
        np.zeros(64, dtype=np.float32),
    )
    return lines, counts


@pytest.mark.parametrize("scale", [1, 2, 3])
@pytest.mark.parametrize("angle_deg", ANGLES_DEG)
def test_lines_see_how_far_the_edge_is_along_their_normals(angle_deg: float, scale: int) -> None:
    rng = np.random.default_rng(angle_deg)
    truth, contour = board_pose(angle_deg), board_contour()
    images = images_of(board_image(truth))
    reach_m = 0.003 * scale
    for _ in range(5):
        moved = truth.perturbed([0, 0, 0, *rng.uniform(-reach_m, reach_m, 2), 0])
        lines, counts = find(contour, moved, images, scale=scale)
        assert counts[CONSIDERED] == counts[VALID] == (lines.valid[0] == 1).sum() >= 24
        on = lines.valid[0] == 1
        place, moments = lines.place[0, on], lines.moments[0, on]
        points = contour[on, :3] * UNIT_M
        normals = truth.rotation[:2, :2] @ contour[on, 3:5].T / 32767
        assert np.allclose(place[:, :2], CAMERA.project(moved.transform(points)), atol=1e-3)
        assert np.allclose(place[:, 2:4], normals.T, atol=1e-3)
        assert np.allclose(place[:, 6:8], 0.05 * CAMERA.fx / DEPTH_M, rtol=1e-3)
        assert np.allclose(lines.point[0, on], points, atol=1e-7)
        apart = CAMERA.project(truth.transform(points)) - place[:, :2]
        edge_px = (apart * place[:, 2:4]).sum(axis=1)
        seen_px = moments[:, 0] / place[:, 5] + place[:, 4]
        # Half a segment, and at scale 1 half a pixel of the minor axis more.
        errors = (seen_px - edge_px) * place[:, 5]
        assert np.abs(errors).max() < (0.8 if scale == 1 else 0.6)
        assert abs(errors.mean()) < 0.2


def test_only_its_own_part_of_the_lines_is_looked_at() -> None:
    truth, contour = board_pose(20), board_contour()
    images = images_of(board_image(truth))
    whole, counts = find(contour, truth, images)
    part, part_counts = find(contour, truth, images, rows=(10, 25))
    assert (part.valid[0, :10] == 7).all()
    assert (part.valid[0, 25:] == 7).all()
    assert np.array_equal(part.valid[0, 10:25], whole.valid[0, 10:25])
    assert np.array_equal(part.posterior[0, 10:25], whole.posterior[0, 10:25])
    _, rest_counts = find(contour, truth, images, rows=(0, 10))
    _, last_counts = find(contour, truth, images, rows=(25, 48))
    assert np.array_equal(part_counts + rest_counts + last_counts, counts)


@pytest.mark.parametrize("side", [6, 7])
def test_a_line_needs_foreground_and_background_on_both_sides(side: int) -> None:
    """At scale 2, three segments are 6 px; at 0.5 m and 230 px that is 13.04 mm."""
    truth = board_pose(20)
    images = images_of(board_image(truth))
    for continuous_m, wanted in ((0.01300, 0), (0.01308, 48)):
        contour = board_contour()
        contour[:, side] = round(continuous_m / UNIT_M)
        lines, counts = find(contour, truth, images, scale=2)
        assert counts[CONSIDERED] == wanted
        assert (lines.valid[0] > 0).any() == (wanted > 0)


def test_points_behind_the_camera_or_beside_the_image_are_not_considered() -> None:
    contour, images = board_contour(), images_of()
    for pose in (
        board_pose(0).perturbed([0, 0, 0, 0, 0, -2 * DEPTH_M]),
        board_pose(0).perturbed([0, 0, 0, 0, 0, -DEPTH_M]),
        board_pose(0).perturbed([0, 0, 0, 2.0, 0, 0]),
        board_pose(0).perturbed([0, 0, 0, 0, -2.0, 0]),
    ):
        lines, counts = find(contour, pose, images)
        assert not lines.valid.any()
        assert not counts.any()


def test_a_normal_along_the_optical_axis_gives_no_line() -> None:
    contour = board_contour()
    contour[:, 3:6] = [0, 0, 32767]
    truth = board_pose(45)
    lines, counts = find(contour, truth, images_of(board_image(truth)))
    assert counts[CONSIDERED] == len(contour)
    assert counts[VALID] == 0
    assert not lines.valid.any()


def test_lines_behind_something_measured_are_hidden() -> None:
    truth, contour = board_pose(0), board_contour()
    depth = np.full((CAMERA.height, CAMERA.width), 500)
    depth[:, : int(CAMERA.cx)] = 470
    images = images_of(board_image(truth), depth)
    lines, counts = find(contour, truth, images, measured=True)
    left = contour[:, 0] * UNIT_M < -0.012
    right = contour[:, 0] * UNIT_M > 0.012
    assert not lines.valid[0, left].any()
    assert counts[OCCLUDED] >= left.sum()
    assert lines.valid[0, right].sum() == counts[VALID] - lines.valid[0, ~left & ~right].sum() > 0
    assert counts[CONSIDERED] == len(contour)
    # Where the body itself comes nearer, that is not what hides it.
    contour[:, 8] = round(0.02 / UNIT_M)
    _, counts = find(contour, truth, images, measured=True)
    assert counts[OCCLUDED] == 0
    _, counts = find(board_contour(), truth, images, measured=False)
    assert counts[OCCLUDED] == 0


def test_occlusion_is_judged_in_the_depth_cameras_frame() -> None:
    truth, contour = board_pose(0), board_contour()
    images = images_of(board_image(truth), np.full((CAMERA.height, CAMERA.width), 470))
    _, counts = find(contour, truth, images, measured=True)
    assert counts[OCCLUDED] == len(contour)
    nearer = truth.perturbed([0, 0, 0, 0, 0, -0.02])
    _, counts = find(contour, truth, images, measured=True, depth_pose=nearer)
    assert counts[OCCLUDED] == 0
