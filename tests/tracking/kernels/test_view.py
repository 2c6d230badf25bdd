"""The closest view: climbing against a scan of all 2562."""

from functools import cache

import numpy as np
import pytest
from scenes import unit_vectors

from snapfit.models.pose import Pose
from snapfit.models.viewpoint_grid import geodesic_grid, viewpoint_pose
from snapfit.tracking.kernels.view import closest_view

N_VIEWS = 2562


@cache
def grid() -> tuple[np.ndarray, np.ndarray]:
    directions, neighbours = geodesic_grid()
    return directions.astype(np.float32), neighbours


@pytest.mark.parametrize("distance_m", [0.05, 0.6, 30.0])
def test_climbing_finds_what_a_scan_finds(distance_m: float) -> None:
    rng = np.random.default_rng(1)
    directions, neighbours = grid()
    for _ in range(700):
        center = rng.uniform(-0.2, 0.2, 3).astype(np.float32)
        rotation = Pose.from_quaternion(rng.normal(size=4), np.zeros(3)).rotation
        # The camera stands at center + distance * direction, turned anyhow.
        wanted = unit_vectors(rng, (3,))
        pose = Pose.from_rotation_translation(rotation, -rotation @ (center + distance_m * wanted))
        view = closest_view(
            directions, neighbours, np.array(pose.matrix), center, int(rng.integers(N_VIEWS))
        )
        cosines = directions @ wanted
        # In single precision two views may be equally near.
        assert cosines[view] >= cosines.max() - 1e-6
        assert cosines[view] > np.cos(np.radians(2.9))


def test_every_view_is_its_own_closest() -> None:
    rng = np.random.default_rng(2)
    directions, neighbours = grid()
    center = np.array([0.02, -0.01, 0.05])
    starts = rng.integers(N_VIEWS, size=N_VIEWS)
    for view in range(0, N_VIEWS, 3):
        pose = viewpoint_pose(directions[view], center, 0.8)
        found = closest_view(
            directions,
            neighbours,
            np.array(pose.matrix),
            center.astype(np.float32),
            int(starts[view]),
        )
        assert found == view
