"""The rasteriser against trimesh's ray casting, and where rasterisers go wrong."""

from functools import cache

import numpy as np
import pytest
import trimesh
from scipy import ndimage

from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import Rendering, render

CAMERA = PinholeCamera(120, 90, fx=130.0, fy=125.0, cx=58.3, cy=46.2)


def as_mesh(surface: trimesh.Trimesh) -> Mesh:
    return Mesh(surface.vertices, surface.faces)


@cache
def drilled_block() -> Mesh:
    block = trimesh.creation.box((0.14, 0.06, 0.04))
    drill = trimesh.creation.cylinder(radius=0.016, height=0.1, sections=40)
    return as_mesh(trimesh.boolean.difference([block, drill], engine="manifold"))


def cast_rays(
    camera: PinholeCamera, bodies: list[tuple[Mesh, Pose]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth, part ids and normals by trimesh's ray engine."""
    v, u = np.mgrid[: camera.height, : camera.width].astype(float)
    rays = np.stack([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)], -1)
    rays = rays.reshape(-1, 3)
    surfaces = [trimesh.Trimesh(p.transform(m.vertices), m.faces, process=False) for m, p in bodies]
    part_of_face = np.repeat(np.arange(1, len(bodies) + 1), [len(m.faces) for m, _ in bodies])
    scene = trimesh.util.concatenate(surfaces)
    hits, ray, face = scene.ray.intersects_location(np.zeros_like(rays), rays, multiple_hits=False)
    depth, part, normal = np.zeros(len(rays)), np.zeros(len(rays), int), np.zeros((len(rays), 3))
    depth[ray], part[ray], normal[ray] = hits[:, 2], part_of_face[face], scene.face_normals[face]
    normal *= -np.sign((normal * rays).sum(axis=1, keepdims=True))
    shape = (camera.height, camera.width)
    return depth.reshape(shape), part.reshape(shape), normal.reshape(*shape, 3)


def away_from_edges(part: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Pixels all of whose neighbours lie on the same plane's side of the same part."""
    same = np.ones(part.shape, dtype=bool)
    for shift in np.ndindex(3, 3):
        offset = (shift[0] - 1, shift[1] - 1)
        same &= np.roll(part, offset, (0, 1)) == part
        same &= np.abs(np.roll(normal, offset, (0, 1)) - normal).max(axis=2) < 1e-6
    return ndimage.binary_erosion(same, border_value=0)


def scenes() -> list[list[tuple[Mesh, Pose]]]:
    generator = np.random.default_rng(5)
    ball = as_mesh(trimesh.creation.icosphere(1, 0.04))
    result = []
    for _ in range(4):
        turn = Pose.exp(np.concatenate([generator.uniform(-3, 3, 3), np.zeros(3)]))
        away = Pose.from_translation(*generator.uniform((-0.05, -0.03, 0.2), (0.05, 0.03, 0.35)))
        block = (drilled_block(), away @ turn)
        # The ball cuts into the block, so that both win somewhere.
        result.append([block, (ball, away @ Pose.from_translation(0.02, 0.01, -0.03))])
    return result


@pytest.mark.parametrize("bodies", scenes())
def test_agrees_with_ray_casting(bodies: list[tuple[Mesh, Pose]]) -> None:
    depth, part, normal = cast_rays(CAMERA, bodies)
    picture = render(CAMERA, bodies, normals=True)
    assert picture.normal is not None
    inner = away_from_edges(part, normal)
    assert inner.mean() > 0.5
    assert (np.bincount(part[inner], minlength=3)[1:] > 20).all()
    assert np.array_equal(picture.part_id[inner], part[inner])
    assert np.allclose(picture.depth[inner], depth[inner], atol=1e-6)
    assert np.allclose(picture.normal[inner], normal[inner], atol=1e-4)
    # At edges, rounding may decide: but for a pixel or two nothing may differ there either.
    assert (picture.part_id != part).sum() <= 2


def test_without_normals_the_picture_is_the_same() -> None:
    bodies = scenes()[0]
    plain, full = render(CAMERA, bodies), render(CAMERA, bodies, normals=True)
    assert plain.normal is None
    assert np.array_equal(plain.depth, full.depth)
    assert np.array_equal(plain.part_id, full.part_id)


def test_the_nearer_of_two_bodies_wins_in_either_order() -> None:
    box = as_mesh(trimesh.creation.box((0.1, 0.1, 0.1)))
    near, far = Pose.from_translation(0.03, 0, 0.4), Pose.from_translation(-0.03, 0, 0.6)
    one = render(CAMERA, [(box, near), (box, far)])
    two = render(CAMERA, [(box, far), (box, near)])
    assert np.array_equal(one.depth, two.depth)
    swapped = np.array([0, 2, 1], dtype=np.uint8)[two.part_id]
    assert np.array_equal(one.part_id, swapped)
    overlap = one.part_id[46, 62]
    assert (overlap, one.depth[46, 62]) == (1, pytest.approx(0.35))
    assert (one.part_id == 2).sum() > 100


def test_pixel_centres_stand_at_integers() -> None:
    # A square from pixel 20 to 40 and 10 to 30 exactly, borders included.
    corners = np.array([[20, 10], [40, 10], [40, 30], [20, 30]], dtype=float)
    camera = PinholeCamera(60, 40, fx=64.0, fy=64.0, cx=32.0, cy=16.0)
    points = np.column_stack([(corners - (32, 16)) / 64, np.ones(4)])
    square = Mesh(points, np.array([[0, 1, 2], [0, 2, 3]]))
    picture = render(camera, [(square, Pose.identity())])
    rows, columns = np.nonzero(picture.part_id)
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (10, 30, 20, 40)
    assert len(rows) == 21 * 21
    assert (picture.depth[10:31, 20:41] == 1).all()


def test_depth_is_perspective_correct() -> None:
    # The plane z = 0.5 + 2 x: along a ray x = a z, so z = 0.5 / (1 - 2 a).
    x = np.array([-0.1, 0.3])
    points = [[x[i], y, 0.5 + 2 * x[i]] for i, y in ((0, -1), (1, -1), (1, 1), (0, 1))]
    plane = Mesh(np.array(points), np.array([[0, 1, 2], [0, 2, 3]]))
    picture = render(CAMERA, [(plane, Pose.identity())])
    seen = picture.depth[46] > 0
    slope = (np.arange(CAMERA.width) - CAMERA.cx) / CAMERA.fx
    assert seen.sum() > 40
    assert np.allclose(picture.depth[46][seen], (0.5 / (1 - 2 * slope))[seen], rtol=1e-5)


def test_no_gap_opens_between_triangles() -> None:
    sphere = as_mesh(trimesh.creation.icosphere(5, 0.08))
    for seed in range(4):
        turn = Pose.exp([*np.random.default_rng(seed).uniform(-3, 3, 3), 0, 0, 0])
        front = Mesh(sphere.vertices, sphere.faces)
        seen = render(CAMERA, [(front, Pose.from_translation(0, 0, 0.3) @ turn)]).part_id > 0
        assert np.array_equal(ndimage.binary_fill_holes(seen), seen)
    # One layer of triangles, with nothing behind that could hide a gap.
    n = 40
    grid = np.random.default_rng(6).uniform(-0.2, 0.2, (n, n, 2)) + np.stack(
        np.meshgrid(np.arange(n), np.arange(n)), axis=-1
    )
    points = np.column_stack([(grid.reshape(-1, 2) - n / 2) * 0.01, np.full(n * n, 0.3)])
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + n], 1), np.stack([a + 1, a + n + 1, a + n], 1)])
    seen = render(CAMERA, [(Mesh(points, faces), Pose.identity())]).part_id > 0
    assert seen[10:-10, 10:-10].all()


def test_what_crosses_the_near_plane_is_clipped() -> None:
    room = as_mesh(trimesh.creation.box((4, 4, 4)))
    inside = Pose.exp([0.2, 0.3, 0.1, 0.1, 0.2, 0.3])
    picture = render(CAMERA, [(room, inside)], normals=True)
    depth, _, _ = cast_rays(CAMERA, [(room, inside)])
    assert (picture.part_id == 1).all()
    assert np.allclose(picture.depth, depth, rtol=1e-5)


def test_a_floor_that_passes_under_the_camera_is_clipped() -> None:
    points = np.array([[-5, 0.1, -3], [5, 0.1, -3], [5, 0.1, 9], [-5, 0.1, 9]])
    floor = Mesh(points, np.array([[0, 1, 2], [0, 2, 3]]))
    picture = render(CAMERA, [(floor, Pose.identity())])
    rows = np.arange(CAMERA.height)
    expected = 0.1 * CAMERA.fy / (rows[60:] - CAMERA.cy)
    assert np.allclose(picture.depth[60:], expected[:, None], rtol=1e-5)
    assert not picture.part_id[:47].any()


@pytest.mark.parametrize("z_m", [-1.0, 0.0])
def test_what_is_behind_the_camera_is_not_drawn(z_m: float) -> None:
    box = as_mesh(trimesh.creation.box((0.1, 0.1, 0.0005)))
    picture = render(CAMERA, [(box, Pose.from_translation(0, 0, z_m))])
    assert not picture.part_id.any()
    assert not picture.depth.any()


def test_what_is_beside_the_image_is_not_drawn() -> None:
    box = as_mesh(trimesh.creation.box((0.1, 0.1, 0.1)))
    for shift in [(3, 0), (-3, 0), (0, 3), (0, -3)]:
        picture = render(CAMERA, [(box, Pose.from_translation(*shift, 1.0))])
        assert not picture.part_id.any()


def test_a_part_of_the_image_only() -> None:
    box = as_mesh(trimesh.creation.box((0.1, 0.1, 0.1)))
    corner = Pose.from_translation(-0.22, -0.17, 0.5)
    depth, part, _ = cast_rays(CAMERA, [(box, corner)])
    picture = render(CAMERA, [(box, corner)])
    assert part[0, 0] == 1
    assert (picture.part_id != part).sum() <= 1
    assert np.allclose(picture.depth[0, 0], depth[0, 0])


def test_faces_without_area_are_left_out() -> None:
    points = np.array([[0, 0, 1], [0.1, 0, 1], [0.2, 0, 1], [0, 0, 1]], dtype=float)
    line = Mesh(points, np.array([[0, 1, 2], [0, 3, 1], [0, 0, 0]]))
    picture = render(CAMERA, [(line, Pose.identity())], normals=True)
    assert np.isfinite(picture.depth).all()
    assert picture.part_id.sum() == 0


def test_buffers_can_be_used_again() -> None:
    box = as_mesh(trimesh.creation.box((0.1, 0.1, 0.1)))
    buffers = Rendering.empty(CAMERA, normals=True)
    render(CAMERA, [(box, Pose.from_translation(0, 0, 0.3))], normals=True, out=buffers)
    moved = [(box, Pose.from_translation(0.1, 0, 0.5))]
    again = render(CAMERA, moved, normals=True, out=buffers)
    fresh = render(CAMERA, moved, normals=True)
    assert again is buffers
    assert np.array_equal(again.depth, fresh.depth)
    assert np.array_equal(again.part_id, fresh.part_id)
    assert np.array_equal(again.normal, fresh.normal)


def test_nothing_gives_an_empty_picture() -> None:
    picture = render(CAMERA, [], normals=True)
    assert picture.depth.shape == (90, 120)
    assert not picture.depth.any()


def test_buffers_of_another_size_are_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \(90, 120\)"):
        render(CAMERA.scaled(0.5), [], out=Rendering.empty(CAMERA))
    with pytest.raises(ValueError, match="has no normals"):
        render(CAMERA, [], normals=True, out=Rendering.empty(CAMERA))


def test_more_bodies_than_ids_are_refused() -> None:
    box = as_mesh(trimesh.creation.box((0.1, 0.1, 0.1)))
    with pytest.raises(ValueError, match="at most 255"):
        render(CAMERA, [(box, Pose.identity())] * 256)
