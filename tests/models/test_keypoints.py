"""Keypoints lie spread over the surface; those of a symmetric part are the same in equal views."""

import numpy as np
import pytest
import trimesh

from snapfit.models.asset import bundled_names, find_asset
from snapfit.models.keypoints import (
    N_KEYPOINTS,
    canonical_pose,
    keypoint_models,
    main_axis,
    surface_keypoints,
)
from snapfit.models.pose import Pose
from snapfit.models.symmetry import NO_SYMMETRY, Symmetry, SymmetryAxis

PARTS = [part for name in bundled_names() for part in find_asset(name).tracked_parts]
SYMMETRIC = [part for part in PARTS if not part.symmetry.is_none]
NAMES = [part.name for part in SYMMETRIC]


def sampled_pose(rng):
    turn = Pose.from_quaternion(rng.standard_normal(4), (0, 0, 0)).rotation
    return Pose.from_rotation_translation(turn, [*rng.uniform(-0.3, 0.3, 2), rng.uniform(0.3, 1)])


def test_keypoints_are_the_same_each_time_and_far_from_each_other():
    for part in PARTS[:4]:
        points, normals = surface_keypoints(part.mesh)
        again, _ = surface_keypoints(part.mesh)
        assert points.shape == (N_KEYPOINTS, 3)
        np.testing.assert_array_equal(points, again)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-9)
        gaps = np.linalg.norm(points[:, None] - points, axis=2) + 9 * np.eye(N_KEYPOINTS)
        assert gaps.min() > 0.06 * part.mesh.diameter_m
        # More keypoints begin with the same ones.
        more, _ = surface_keypoints(part.mesh, 25)
        np.testing.assert_array_equal(more[:N_KEYPOINTS], points)


def test_keypoints_lie_on_the_surface():
    part = PARTS[0]
    points, normals = surface_keypoints(part.mesh)
    surface = trimesh.Trimesh(part.mesh.vertices, part.mesh.faces, process=False)
    _, distance, _ = trimesh.proximity.closest_point(surface, points)
    # As near as the search for the closest point is on slender triangles.
    assert distance.max() < 5e-5
    inside = surface.contains(points - 1e-4 * normals)
    assert inside.all()


@pytest.mark.parametrize("part", SYMMETRIC, ids=NAMES)
def test_poses_that_look_alike_have_the_same_keypoints(part):
    (model,) = keypoint_models([part])
    rng = np.random.default_rng(len(part.name))
    for _ in range(25):
        pose = sampled_pose(rng)
        expected = model.in_camera(pose)
        for motion in part.symmetry.sampled(0.02, part.mesh.diameter_m / 2):
            np.testing.assert_allclose(model.in_camera(pose @ motion), expected, atol=1e-9)


@pytest.mark.parametrize("part", SYMMETRIC, ids=NAMES)
def test_the_canonical_pose_is_one_of_those_that_look_alike_and_its_own(part):
    rng = np.random.default_rng(7)
    for _ in range(10):
        pose = sampled_pose(rng)
        chosen = canonical_pose(pose, part.symmetry)
        nearest = part.symmetry.nearest(pose, chosen)
        assert nearest.angle_to(chosen) < 1e-6
        assert nearest.distance_to(chosen) < 1e-9
        again = canonical_pose(chosen, part.symmetry)
        np.testing.assert_allclose(again.matrix, chosen.matrix, atol=1e-9)


def test_what_the_camera_sees_alone_decides():
    """A part that is moved along the rays around the camera keeps its keypoints."""
    part = next(part for part in SYMMETRIC if part.symmetry.axis is None)
    rng = np.random.default_rng(3)
    for _ in range(20):
        pose = sampled_pose(rng)
        chosen = canonical_pose(pose, part.symmetry)
        ray = pose.translation / np.linalg.norm(pose.translation)
        angle = rng.uniform(-0.3, 0.3)
        # A turn of the camera about a level or upright axis of its own, by which nothing rolls.
        axis = np.cross((0, 0, 1), ray) / np.linalg.norm(np.cross((0, 0, 1), ray))
        turn = Pose.exp([*(axis * angle), 0, 0, 0])
        np.testing.assert_allclose(
            canonical_pose(turn @ pose, part.symmetry).matrix, (turn @ chosen).matrix, atol=1e-9
        )


def test_a_small_motion_moves_the_keypoints_little_away_from_the_seams():
    part = next(part for part in SYMMETRIC if part.symmetry.axis is not None)
    (model,) = keypoint_models([part])
    rng = np.random.default_rng(1)
    jumps = 0
    for _ in range(200):
        pose = sampled_pose(rng)
        step = rng.normal(0, 0.01, 6) * (1, 1, 1, 0.1, 0.1, 0.1)
        moved = np.abs(model.in_camera(pose.perturbed(step)) - model.in_camera(pose)).max()
        jumps += moved > 0.01
    # A continuous symmetry has a single bad direction of its axis.
    assert jumps <= 2


def test_a_part_without_symmetry_keeps_its_pose():
    pose = sampled_pose(np.random.default_rng(0))
    assert canonical_pose(pose, NO_SYMMETRY) is pose


def test_the_main_axis_is_that_of_most_turns():
    quarter = [Pose.exp([0, 0, np.pi / 2 * i, 0, 0, 0]) for i in (1, 2, 3)]
    flips = [Pose.exp([np.pi, 0, 0, 0, 0, 0]) @ turn for turn in (Pose.identity(), *quarter)]
    np.testing.assert_allclose(main_axis(Symmetry((*flips, *quarter))), (0, 0, 1), atol=1e-9)
    axis = SymmetryAxis(np.array([0, 2.0, 0]), np.zeros(3))
    np.testing.assert_allclose(main_axis(Symmetry((), axis)), (0, 1, 0), atol=1e-12)
