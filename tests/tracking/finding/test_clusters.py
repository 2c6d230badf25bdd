"""Points, the plane below them, and the clusters on it."""

import numpy as np
import pytest

from snapfit.models.camera import PinholeCamera
from snapfit.tracking.finding.clusters import find_clusters
from snapfit.tracking.finding.parameters import CloudParameters
from snapfit.tracking.finding.plane import find_plane, rises
from snapfit.tracking.finding.point_cloud import PointCloud, point_cloud

CAMERA = PinholeCamera(300, 240, 300.0, 300.0, 150.0, 120.0)
PARAMETERS = CloudParameters()


def cloud_of(counts: np.ndarray) -> PointCloud:
    return point_cloud(counts, CAMERA, 0.001, PARAMETERS.stride_px, PARAMETERS.farthest_m)


def flat(depth_mm: int = 600) -> np.ndarray:
    rng = np.random.default_rng(1)
    noisy = depth_mm + rng.normal(0, 0.8, (240, 300))
    return np.round(noisy).astype(np.uint16)


def test_points_project_to_the_pixels_they_come_from():
    counts = np.full((240, 300), 700, dtype=np.uint16)
    cloud = cloud_of(counts)
    assert cloud.points_m.shape == (80, 100, 3)
    # The first of each three pixels in the middle: stride // 2.
    assert CAMERA.project(cloud.points_m[0, 0]) == pytest.approx([1, 1])
    assert CAMERA.project(cloud.points_m[20, 33]) == pytest.approx([1 + 99, 1 + 60])
    assert cloud.camera.project(cloud.points_m[20, 33]) == pytest.approx([33, 20])


def test_missing_and_far_depth_is_not_measured():
    counts = np.full((240, 300), 700, dtype=np.uint16)
    counts[1, 1], counts[1, 4], counts[1, 7] = 0, 65535, 1600
    cloud = cloud_of(counts)
    assert (~cloud.measured).sum() == 3
    assert not cloud.measured[0, :3].any()
    assert (cloud.points_m[0, :3] == 0).all()


@pytest.mark.usefixtures("needs_open3d")
def test_the_plane_is_found_and_a_thin_plate_on_it():
    counts = flat()
    counts[90:150, 100:160] -= 4
    cloud = cloud_of(counts)
    plane = find_plane(cloud, PARAMETERS, 0.2)
    assert plane is not None
    assert plane.normal == pytest.approx([0, 0, -1], abs=0.005)
    assert plane.offset_m == pytest.approx(0.6, abs=0.001)
    # Depth comes in whole millimetres.
    assert plane.deviation_m == pytest.approx(0.0008, abs=0.0007)
    above = rises(cloud, plane, PARAMETERS)
    assert above[31:49, 34:52].mean() > 0.9
    assert above.sum() < 1.2 * 20 * 20


@pytest.mark.usefixtures("needs_open3d")
def test_there_is_no_plane_in_a_ball_of_points_nor_in_a_handful():
    rng = np.random.default_rng(2)
    scattered = rng.integers(400, 1400, (240, 300)).astype(np.uint16)
    assert find_plane(cloud_of(scattered), PARAMETERS, 0.2) is None
    few = np.zeros((240, 300), dtype=np.uint16)
    few[:20, :20] = 600
    assert find_plane(cloud_of(few), PARAMETERS, 0.2) is None


@pytest.mark.usefixtures("needs_open3d")
def test_the_face_of_a_part_is_no_plane_to_lie_on():
    face = np.zeros((240, 300), dtype=np.uint16)
    face[60:160, 80:180] = 600
    cloud = cloud_of(face)
    assert find_plane(cloud, PARAMETERS, 0.3) is None
    assert find_plane(cloud, PARAMETERS, 0.2) is not None
    assert rises(cloud, None, PARAMETERS).sum() == cloud.measured.sum() > 0


@pytest.mark.usefixtures("needs_open3d")
def test_pieces_near_one_another_are_given_together_too():
    counts = flat()
    counts[60:120, 40:80] -= 50
    # 9 px are 17 mm at the plates' height, seen every 3 px.
    counts[60:120, 89:129] -= 50
    counts[60:120, 220:260] -= 50
    cloud = cloud_of(counts)
    above = rises(cloud, find_plane(cloud, PARAMETERS, 0.2), PARAMETERS)
    clusters = find_clusters(cloud, above, PARAMETERS, 0.4)
    assert [len(each.pieces) for each in clusters] == [1, 1, 1, 2]
    single, together = clusters[0], clusters[3]
    assert together.area_m2 == pytest.approx(2 * single.area_m2, rel=0.1)
    assert single.area_m2 == pytest.approx(60 * 40 * (0.55 / 300) ** 2, rel=0.1)
    assert together.middle_m[2] == pytest.approx(0.55, abs=0.003)
    # Larger than any part: the pair is left out, and then all.
    assert len(find_clusters(cloud, above, PARAMETERS, 0.15)) == 3
    assert find_clusters(cloud, above, PARAMETERS, 0.05) == []
