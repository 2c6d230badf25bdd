"""What goes from camera to camera: poses out, gradients and Hessians back."""

import numpy as np
import pytest
from scenes import bodies_at, random_pose

from snapfit.models.pose import Pose
from snapfit.tracking.kernels.rig import add_energies, clear_energies, follow_first
from snapfit.tracking.kernels.types import Bodies


def energetic(rng: np.random.Generator) -> Bodies:
    bodies = bodies_at([random_pose(rng) for _ in range(3)])
    bodies.gradients[:] = rng.normal(size=(3, 6))
    bodies.hessians[:] = rng.normal(size=(3, 6, 6))
    return bodies


@pytest.mark.parametrize("seed", range(4))
def test_bodies_stand_where_the_first_camera_has_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    poses = [random_pose(rng) for _ in range(3)]
    camera_from_first = random_pose(rng)
    first, own = bodies_at(poses), bodies_at([Pose.identity()] * 3)
    follow_first(camera_from_first.matrix, first, own)
    for pose, found in zip(poses, own.poses, strict=True):
        np.testing.assert_allclose(found, (camera_from_first @ pose).matrix, atol=1e-12)


def test_energies_of_active_bodies_add_up() -> None:
    rng = np.random.default_rng(0)
    first, own = energetic(rng), energetic(rng)
    first.active[1] = 0
    gradients, hessians = first.gradients.copy(), first.hessians.copy()
    add_energies(own, first)
    for body, times in enumerate((1, 0, 1)):
        np.testing.assert_array_equal(
            first.gradients[body], gradients[body] + times * own.gradients[body]
        )
        np.testing.assert_array_equal(
            first.hessians[body], hessians[body] + times * own.hessians[body]
        )


def test_energies_of_active_bodies_are_cleared() -> None:
    bodies = energetic(np.random.default_rng(1))
    bodies.active[2] = 0
    gradients = bodies.gradients.copy()
    clear_energies(bodies)
    assert not bodies.gradients[:2].any()
    assert not bodies.hessians[:2].any()
    np.testing.assert_array_equal(bodies.gradients[2], gradients[2])
    assert bodies.hessians[2].any()
