"""The small rendering that tells which body is in front of which."""

from collections.abc import Sequence

import numpy as np
import pytest
import trimesh
from scenes import CAMERA, bodies_at, body_without_views

from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.tracking.nearby import NearbyRendering
from snapfit.tracking.parameters import OcclusionParameters

CUBE_M = 0.08
SCALE = 0.5
SMALL = CAMERA.scaled(SCALE)


def cube_mesh() -> Mesh:
    box = trimesh.creation.box([CUBE_M] * 3)
    return Mesh(box.vertices, box.faces)


def rendered(
    poses: Sequence[Pose],
    active: Sequence[int] | None = None,
    into: NearbyRendering | None = None,
) -> NearbyRendering:
    """Cubes at some poses, in half the image's size."""
    nearby = into or NearbyRendering(
        [body_without_views("cube", cube_mesh()) for _ in poses],
        CAMERA,
        OcclusionParameters(image_scale=SCALE),
    )
    bodies = bodies_at(list(poses))
    if active is not None:
        bodies.active[:] = active
    nearby.render(bodies)
    return nearby


def at(x_m: float, z_m: float = 0.5) -> Pose:
    return Pose.from_translation(x_m, 0, z_m).perturbed([0.3, -0.2, 0.1, 0, 0, 0])


def test_the_nearer_of_two_bodies_is_in_front_whatever_their_order() -> None:
    for order in (1, -1):
        poses = [at(0.02, 0.4), at(-0.02, 0.6)][::order]
        nearby = rendered(poses)
        wanted = render(SMALL, [(cube_mesh(), pose) for pose in poses])
        assert nearby.neighboured.tolist() == [1, 1]
        assert np.array_equal(nearby.part_id, wanted.part_id)
        assert np.allclose(nearby.depth, wanted.depth, atol=1e-6)
        both = (render(SMALL, [(cube_mesh(), poses[0])]).part_id > 0) & (
            render(SMALL, [(cube_mesh(), poses[1])]).part_id > 0
        )
        assert both.sum() > 50
        assert (nearby.part_id[both] == (1 if order == 1 else 2)).all()


def test_bodies_whose_images_do_not_touch_are_not_drawn() -> None:
    nearby = rendered([at(-0.15), at(0.15)])
    assert nearby.neighboured.tolist() == [0, 0]
    assert not nearby.part_id.any()
    assert not nearby.depth.any()


def test_a_body_far_behind_another_touches_it_too() -> None:
    nearby = rendered([at(0.0, 0.3), at(0.0, 5.0)])
    assert nearby.neighboured.tolist() == [1, 1]
    assert set(np.unique(nearby.part_id)) == {0, 1}


def test_of_three_only_those_two_are_drawn_that_touch() -> None:
    nearby = rendered([at(-0.15), at(0.12), at(0.16, 0.55)])
    assert nearby.neighboured.tolist() == [0, 1, 1]
    assert set(np.unique(nearby.part_id)) == {0, 2, 3}


@pytest.mark.parametrize("active", [[1, 0], [0, 1], [0, 0]])
def test_a_body_that_takes_no_part_hides_nothing(active: list[int]) -> None:
    nearby = rendered([at(0.02, 0.4), at(-0.02, 0.6)], active)
    assert nearby.neighboured.tolist() == [0, 0]
    assert not nearby.part_id.any()


def test_one_body_alone_is_nobodys_neighbour() -> None:
    nearby = rendered([at(0.0)])
    assert nearby.neighboured.tolist() == [0]
    assert not nearby.part_id.any()


def test_nothing_of_the_last_frame_stays() -> None:
    nearby = rendered([at(0.02, 0.4), at(-0.02, 0.6)])
    assert nearby.part_id.any()
    rendered([at(-0.15), at(0.15)], into=nearby)
    assert not nearby.part_id.any()
    assert not nearby.depth.any()
    assert nearby.neighboured.tolist() == [0, 0]


def test_whatever_overlaps_counts_as_neighboured() -> None:
    """The circles around the bodies may touch too early, but never too late."""
    rng = np.random.default_rng(1)
    n_overlapping, n_apart = 0, 0
    for _ in range(200):
        poses = [at(*rng.uniform([-0.2, 0.3], [0.2, 0.8])) for _ in range(2)]
        masks = [render(SMALL, [(cube_mesh(), pose)]).part_id > 0 for pose in poses]
        overlap = bool((masks[0] & masks[1]).any())
        neighboured = rendered(poses).neighboured.tolist()
        assert neighboured in ([0, 0], [1, 1])
        assert not overlap or neighboured == [1, 1]
        n_overlapping += overlap
        n_apart += neighboured == [0, 0]
    assert n_overlapping > 30
    assert n_apart > 30


@pytest.mark.parametrize("z_m", [-1.0, -0.02, 0.0, 0.02])
def test_a_body_at_or_behind_the_camera_does_no_harm(z_m: float) -> None:
    nearby = rendered([Pose.from_translation(0, 0, z_m), at(0.0, 0.5)])
    assert np.isfinite(nearby.depth).all()
    assert (nearby.depth >= 0).all()
    assert ((nearby.depth > 0) == (nearby.part_id > 0)).all()
    if z_m < -CUBE_M:
        assert 1 not in nearby.part_id


def test_the_picture_is_of_the_scaled_size_and_small_where_nothing_is_modelled() -> None:
    cube = body_without_views("cube", cube_mesh())
    quarter = NearbyRendering([cube], CAMERA, OcclusionParameters(image_scale=0.25))
    assert quarter.depth.shape == quarter.part_id.shape == (50, 60)
    without = NearbyRendering([cube], CAMERA, OcclusionParameters(modelled=False))
    assert without.depth.size < 100


def test_meshes_are_simplified_before_they_are_drawn() -> None:
    ball = trimesh.creation.icosphere(subdivisions=5, radius=0.05)
    mesh = Mesh(ball.vertices, ball.faces)
    assert len(mesh.faces) > 10_000
    poses = [at(0.02, 0.4), at(-0.02, 0.6)]
    nearby = NearbyRendering(
        [body_without_views("ball", mesh)] * 2,
        CAMERA,
        OcclusionParameters(image_scale=SCALE, faces_max=300),
    )
    nearby.render(bodies_at(poses))
    wanted = render(SMALL, [(mesh, pose) for pose in poses])
    assert (nearby.part_id != wanted.part_id).mean() < 0.01
    seen = (nearby.part_id > 0) & (wanted.part_id == nearby.part_id)
    assert np.abs(nearby.depth - wanted.depth)[seen].mean() < 0.001


def test_what_is_drawn_for_an_attempt_is_put_back() -> None:
    poses = [at(0.02, 0.4), at(-0.02, 0.6)]
    nearby = rendered(poses)
    before = nearby.depth.copy(), nearby.part_id.copy(), nearby.neighboured.copy()
    kept = nearby.shown(bodies_at([poses[0], at(0.3, 0.3)]))
    alone = rendered([poses[0], at(0.3, 0.3)])
    assert np.array_equal(nearby.part_id, alone.part_id)
    assert nearby.neighboured.tolist() == alone.neighboured.tolist() == [0, 0]
    nearby.put_back(kept)
    for now, then in zip((nearby.depth, nearby.part_id, nearby.neighboured), before, strict=True):
        assert np.array_equal(now, then)
