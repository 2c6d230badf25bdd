"""The kernel that refines all bodies of a frame."""

import numpy as np
import pytest
from worlds import ITERATIONS, World

from snapfit.models.pose import Pose
from snapfit.tracking.kernels.types import CONSIDERED, OCCLUDED, VALID


def matrices(poses: list[Pose]) -> np.ndarray:
    return np.array([pose.matrix for pose in poses])


@pytest.mark.parametrize("seed", range(6))
def test_poses_that_are_off_a_little_come_back(world: World, seed: int) -> None:
    start = world.near(np.random.default_rng(seed))
    refined = world.refine(start)
    for truth, before, after in zip(world.truth, start, refined.poses, strict=True):
        assert truth.distance_to(after) < 0.0015
        assert np.degrees(truth.angle_to(after)) < 1.0
        assert truth.distance_to(after) + 0.05 * truth.angle_to(after) < (
            truth.distance_to(before) + 0.05 * truth.angle_to(before)
        )
    assert (refined.bodies.solved == 1).all()


def test_without_iterations_nothing_moves(world: World) -> None:
    start = world.near(np.random.default_rng(1))
    refined = world.refine(start, iterations=0)
    assert np.array_equal(refined.bodies.poses, matrices(start))
    assert not refined.lines.valid.any()
    assert not refined.points.valid.any()


def test_without_updates_there_are_correspondences_and_the_poses_stay(world: World) -> None:
    start = world.near(np.random.default_rng(1))
    refined = world.refine(start, iterations=1, updates=0)
    assert np.array_equal(refined.bodies.poses, matrices(start))
    assert refined.lines.valid.sum() > 100
    assert refined.points.valid.sum() > 100


def test_counts_are_those_of_the_last_iteration(world: World) -> None:
    refined = world.refine(world.near(np.random.default_rng(2)))
    counts = refined.counts.sum(axis=1)
    assert np.array_equal(counts[:, 0, VALID], refined.lines.valid.sum(axis=1))
    assert np.array_equal(counts[:, 1, VALID], refined.points.valid.sum(axis=1))
    assert (counts[:, :, VALID] <= counts[:, :, CONSIDERED] - counts[:, :, OCCLUDED]).all()
    views = refined.bodies.views
    n_lines = world.models.line_counts[np.arange(2), views]
    assert (counts[:, 0, CONSIDERED] <= n_lines).all()
    assert (counts[:, 0, CONSIDERED] > 0.5 * n_lines).all()


@pytest.mark.parametrize("active", [[0, 0], [1, 0], [0, 1]])
def test_bodies_that_take_no_part_are_never_touched(world: World, active: list[int]) -> None:
    start = world.near(np.random.default_rng(3))
    refined = world.refine(start, active=active)
    for body in range(2):
        moved = not np.array_equal(refined.bodies.poses[body], start[body].matrix)
        assert moved == bool(active[body])
        if not active[body]:
            assert not refined.lines.valid[body].any()
            assert not refined.points.valid[body].any()
            assert (refined.counts[body] == -1).all()
            assert refined.bodies.views[body] == 0


@pytest.mark.parametrize("seed", range(4))
def test_two_bodies_at_once_are_refined_like_each_alone(world: World, seed: int) -> None:
    """Without modelled occlusion nothing of one body enters into the other."""
    start = world.near(np.random.default_rng(seed))
    together = world.refine(start)
    for body in range(2):
        alone = world.refine(start, active=[body == 0, body == 1])
        difference = together.bodies.poses[body] - alone.bodies.poses[body]
        assert np.abs(difference).max() < 1e-9
        assert np.allclose(together.bodies.hessians[body], alone.bodies.hessians[body])


@pytest.mark.parametrize("n_parts", [2, 3, 4, 7])
def test_the_result_does_not_depend_on_the_number_of_parts(world: World, n_parts: int) -> None:
    start = world.near(np.random.default_rng(5))
    whole, cut = world.refine(start, n_parts=1), world.refine(start, n_parts=n_parts)
    assert np.abs(whole.bodies.poses - cut.bodies.poses).max() < 1e-9
    assert np.array_equal(whole.lines.valid, cut.lines.valid)
    assert np.array_equal(whole.points.valid, cut.points.valid)
    assert np.array_equal(whole.counts.sum(axis=1), cut.counts.sum(axis=1))


def test_the_same_frame_gives_the_same_poses_again(world: World) -> None:
    start = world.near(np.random.default_rng(6))
    first, second = world.refine(start), world.refine(start)
    assert np.array_equal(first.bodies.poses, second.bodies.poses)


def test_at_the_truth_the_poses_stay_within_the_images_resolution(world: World) -> None:
    refined = world.refine(world.truth)
    for truth, after in zip(world.truth, refined.poses, strict=True):
        assert truth.distance_to(after) < 0.001
        assert np.degrees(truth.angle_to(after)) < 0.7


@pytest.mark.parametrize("z_m", [-0.6, 50.0])
def test_a_body_that_is_not_in_the_image_stays_where_it_is(world: World, z_m: float) -> None:
    away = Pose.from_translation(0, 0, z_m)
    refined = world.refine([away, world.truth[1]])
    assert np.array_equal(refined.bodies.poses[0], away.matrix)
    assert refined.bodies.solved.tolist() == [1, 1]
    assert refined.counts[0, :, :, VALID].sum() == 0
    assert not refined.bodies.hessians[0].any()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_pose_that_is_not_finite_harms_no_other_body(world: World, value: float) -> None:
    start = world.near(np.random.default_rng(7))
    good = world.refine(start, active=[0, 1])
    broken = matrices(start)
    broken[0, :3] = value
    refined = world.refine([_Unchecked(broken[0]), start[1]])
    assert np.array_equal(refined.bodies.poses[1], good.bodies.poses[1])
    assert refined.bodies.solved[1] == 1
    assert not np.isfinite(refined.bodies.poses[0]).all()


class _Unchecked(Pose):
    """A pose that `Pose` would refuse."""

    def __post_init__(self) -> None:
        """Take whatever comes."""


def test_a_system_without_evidence_or_regularisation_is_no_success(world: World) -> None:
    """The Newton step that cannot be solved leaves the pose and says so."""
    away = [Pose.from_translation(0, 0, -0.6), world.truth[1]]
    refined = world.refine(away, tikhonov=(0.0, 0.0))
    assert refined.bodies.solved.tolist() == [0, 1]
    assert np.array_equal(refined.bodies.poses[0], away[0].matrix)


def test_the_closest_view_is_that_of_the_pose(world: World) -> None:
    refined = world.refine(world.truth, iterations=1, updates=0)
    for body, pose in enumerate(world.truth):
        camera = pose.inverse().translation - world.models.centers[body]
        wanted = int(np.argmax(world.models.directions @ camera))
        assert refined.bodies.views[body] == wanted


def test_a_finer_search_ends_closer(world: World) -> None:
    """Each correspondence iteration works: the errors shrink from the first to the last."""
    errors = np.zeros((2, ITERATIONS + 1))
    for seed in range(6):
        start = world.near(np.random.default_rng(seed))
        for iterations in (0, 1, ITERATIONS):
            refined = world.refine(start, iterations=iterations)
            for body in range(2):
                errors[body, iterations] += world.truth[body].distance_to(refined.poses[body])
    assert (errors[:, 1] < errors[:, 0]).all()
    assert (errors[:, ITERATIONS] < errors[:, 1]).all()
