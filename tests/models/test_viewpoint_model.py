"""Viewpoint models of bodies whose outlines are known exactly."""

from functools import cache

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from snapfit.models.errors import ViewpointModelError
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.viewpoint_build import build_viewpoint_model, mesh_edges
from snapfit.models.viewpoint_grid import viewpoint_pose
from snapfit.models.viewpoint_model import NORMAL_UNIT, SATURATED, ViewpointModel

N_DIVISIONS = 2
BOX_M = np.array([0.16, 0.09, 0.04])


def as_mesh(surface: trimesh.Trimesh) -> Mesh:
    return Mesh(surface.vertices, surface.faces)


@cache
def box() -> Mesh:
    return as_mesh(trimesh.creation.box(BOX_M))


@cache
def box_model() -> ViewpointModel:
    return build_viewpoint_model(box(), n_divisions=N_DIVISIONS)


@cache
def washer_model() -> ViewpointModel:
    washer = as_mesh(trimesh.creation.annulus(r_min=0.02, r_max=0.04, height=0.004, sections=256))
    return build_viewpoint_model(washer, n_divisions=1)


def view_along(model: ViewpointModel, direction: tuple[float, float, float]) -> int:
    view = int(np.argmax(model.directions @ np.array(direction)))
    assert np.allclose(model.directions[view], direction, atol=1e-6)
    return view


def pose_of(model: ViewpointModel, view: int) -> Pose:
    return viewpoint_pose(model.directions[view], model.center_m, model.radius_m)


def contour_errors(model: ViewpointModel, mesh: Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of a convex body: distance to the true outline, m; angle to its normal, deg; slope."""
    distances, angles, slopes = [], [], []
    for view in range(model.n_views):
        pose = pose_of(model, view)
        corners = pose.transform(mesh.vertices)
        lines = ConvexHull(corners[:, :2] / corners[:, 2:]).equations
        points = pose.transform(model.contour[view, :, :3] * model.unit_m)
        offsets = points[:, :2] / points[:, 2:] @ lines[:, :2].T + lines[:, 2]
        nearest = offsets.argmax(axis=1)
        normals = model.contour[view, :, 3:6] * NORMAL_UNIT @ pose.rotation.T
        cosines = np.einsum("ij,ij->i", normals[:, :2], lines[nearest, :2])
        distances.append(offsets.max(axis=1) * model.radius_m)
        angles.append(np.degrees(np.arccos(np.clip(cosines, -1, 1))))
        slopes.append(normals[:, 2])
    return np.array(distances), np.array(angles), np.array(slopes)


def test_shapes() -> None:
    model = box_model()
    assert model.n_views == 162
    assert (model.contour.shape, model.contour.dtype) == ((162, 300, 9), np.int16)
    assert (model.surface.shape, model.surface.dtype) == ((162, 300, 7), np.int16)
    assert (model.neighbours.shape, model.neighbours.dtype) == ((162, 6), np.int16)
    assert model.directions.dtype == model.contour_length_m.dtype == np.float32
    assert model.radius_m == 0.8


def test_contour_points_lie_on_the_outline() -> None:
    distances, _, _ = contour_errors(box_model(), box())
    assert abs(distances.mean()) < 2e-6
    assert np.abs(distances).max() < 2e-5


def test_contour_points_lie_on_the_surface() -> None:
    model = box_model()
    points = (model.contour[::9, :, :3] * model.unit_m).reshape(-1, 3)
    _, distances, _ = trimesh.proximity.closest_point(trimesh.creation.box(BOX_M), points)
    assert distances.max() < 2e-5


def test_contour_normals_point_outwards_in_the_image_plane() -> None:
    _, angles, slopes = contour_errors(box_model(), box())
    assert np.abs(slopes).max() < 1e-3
    assert np.median(angles) < 0.2
    assert np.percentile(angles, 97) < 7
    lengths = np.linalg.norm(box_model().contour[..., 3:6] * NORMAL_UNIT, axis=-1)
    assert np.allclose(lengths, 1, atol=1e-3)


def test_the_outline_of_a_finely_curved_body_is_exact_too() -> None:
    egg = trimesh.creation.icosphere(4, 0.05)
    egg.vertices *= (1.0, 1.4, 0.7)
    mesh = as_mesh(egg)
    distances, angles, _ = contour_errors(build_viewpoint_model(mesh, n_divisions=1), mesh)
    assert np.abs(distances).max() < 2e-5
    assert np.percentile(angles, 95) < 4


def test_a_face_turned_inside_out_does_not_move_the_outline() -> None:
    faces = box().faces.copy()
    faces[3] = faces[3, ::-1]
    mesh = Mesh(box().vertices, faces)
    assert (mesh_edges(mesh.faces)[:, 4] == 1).sum() == 3
    distances, _, _ = contour_errors(build_viewpoint_model(mesh, n_divisions=1), mesh)
    assert np.abs(distances).max() < 2e-5


def test_surface_points_lie_on_faces_and_normals_look_at_the_viewpoint() -> None:
    model, surface = box_model(), trimesh.creation.box(BOX_M)
    for view in range(0, model.n_views, 12):
        points = model.surface[view, :, :3] * model.unit_m
        normals = model.surface[view, :, 3:6] * NORMAL_UNIT
        _, distances, faces = trimesh.proximity.closest_point(surface, points)
        assert distances.max() < 2e-5
        inner = np.sort(np.abs(np.abs(points) - BOX_M / 2), axis=1)[:, 1] > 1e-3
        assert inner.mean() > 0.5
        assert np.allclose(normals[inner], surface.face_normals[faces][inner], atol=1e-4)
        to_viewpoint = model.center_m + model.radius_m * model.directions[view] - points
        assert (np.einsum("ij,ij->i", normals, to_viewpoint) > 0).all()


def test_distances_lengths_and_areas_of_a_box_seen_from_above() -> None:
    model = box_model()
    view = view_along(model, (0, 0, 1))
    normals = model.contour[view, :, 3:6] * NORMAL_UNIT
    inside_m, outside = model.contour[view, :, 6] * model.unit_m, model.contour[view, :, 7]
    for axis in (0, 1):
        across = np.abs(normals[:, axis]) > 0.999
        assert across.sum() > 50
        assert np.allclose(inside_m[across], BOX_M[axis], atol=5e-4)
    assert (outside == SATURATED).all()
    assert model.contour_length_m[view] == pytest.approx(2 * (BOX_M[0] + BOX_M[1]), rel=0.005)
    nearer = 0.8 / (0.8 - BOX_M[2] / 2)
    assert model.surface_area_m2[view] == pytest.approx(BOX_M[0] * BOX_M[1] * nearer**2, rel=0.01)


def test_distances_on_a_ring() -> None:
    model = washer_model()
    view = view_along(model, (0, 0, 1))
    points = model.contour[view, :, :2] * model.unit_m
    radii = np.linalg.norm(points, axis=1)
    outwards = np.einsum("ij,ij->i", points, model.contour[view, :, 3:5] * NORMAL_UNIT) / radii
    inside_m, outside_m = (model.contour[view, :, 6:8] * model.unit_m).T
    outer = radii > 0.03
    assert outer.mean() == pytest.approx(2 / 3, abs=0.02)
    assert np.allclose(radii, np.where(outer, 0.04, 0.02), atol=2e-5)
    assert np.allclose(outwards, np.where(outer, 1, -1), atol=0.01)
    assert np.allclose(inside_m, 0.02, atol=5e-4)
    assert np.allclose(outside_m[~outer], 0.04, atol=5e-4)
    assert (model.contour[view, outer, 7] == SATURATED).all()
    assert model.contour_length_m[view] == pytest.approx(2 * np.pi * 0.06, rel=0.005)


def test_depth_offsets_beside_a_post() -> None:
    plate = trimesh.creation.box((0.12, 0.12, 0.01))
    post = trimesh.creation.cylinder(radius=0.005, segment=[(0, 0, 0), (0, 0, 0.035)])
    mesh = as_mesh(trimesh.boolean.union([plate, post], engine="manifold"))
    model = build_viewpoint_model(mesh, n_divisions=1)
    view = view_along(model, (0, 0, 1))
    points = model.surface[view, :, :3] * model.unit_m
    offsets_m = model.surface[view, :, 6] * model.unit_m
    from_axis = np.linalg.norm(points[:, :2], axis=1)
    on_plate = np.abs(points[:, 2] - 0.005) < 1e-4
    beside, away = on_plate & (from_axis < 0.0125), on_plate & (from_axis > 0.018)
    assert min(beside.sum(), away.sum()) > 5
    assert np.allclose(offsets_m[beside], 0.03, atol=2e-4)
    assert offsets_m[away].max() < 2e-4
    assert (model.contour[view, :, 8] * model.unit_m).max() < 2e-4


@pytest.mark.parametrize(("k", "share"), [(30, 0.1), (100, 0.04)])
def test_the_first_points_are_a_fair_sample(k: int, share: float) -> None:
    model = box_model()
    for rows in (model.contour, model.surface):
        positions = rows[..., :3] * model.unit_m
        shift = positions[:, :k].mean(axis=1) - positions.mean(axis=1)
        assert np.linalg.norm(shift, axis=1).max() < share * box().diameter_m


def test_the_same_mesh_gives_the_same_model() -> None:
    again = build_viewpoint_model(box(), n_divisions=N_DIVISIONS)
    for name in ("directions", "contour", "surface", "contour_length_m", "surface_area_m2"):
        assert np.array_equal(getattr(again, name), getattr(box_model(), name)), name


def test_an_open_mesh_has_an_outline_from_everywhere() -> None:
    sphere = trimesh.creation.icosphere(3, 0.08)
    half = Mesh(sphere.vertices, sphere.faces[sphere.triangles_center[:, 2] > 0])
    model = build_viewpoint_model(half, n_divisions=1)
    assert (model.contour_length_m > 0.2).all()
    points = model.contour[..., :3] * model.unit_m
    assert np.linalg.norm(points, axis=-1) == pytest.approx(0.08, abs=6e-4)


def test_a_body_frame_far_from_the_body_keeps_the_outline() -> None:
    mesh = Mesh(box().vertices + np.array([0.7, 0, 0]), box().faces)
    model = build_viewpoint_model(mesh, n_divisions=1)
    assert np.allclose(model.center_m, (0.7, 0, 0), atol=1e-6)
    distances, _, _ = contour_errors(model, mesh)
    assert np.abs(distances).max() < 1.5e-4


def test_a_large_part_is_seen_from_further_away() -> None:
    mesh = Mesh(box().vertices * 10, box().faces)
    model = build_viewpoint_model(mesh, n_divisions=0)
    assert model.radius_m == pytest.approx(4 * mesh.radius_m)
    distances, _, _ = contour_errors(model, mesh)
    assert np.abs(distances).max() < 2e-4


def test_a_tiny_part_has_an_exact_outline_too() -> None:
    mesh = Mesh(box().vertices * 0.02, box().faces)
    distances, _, _ = contour_errors(build_viewpoint_model(mesh, n_divisions=0), mesh)
    assert np.abs(distances).max() < 1e-6


def test_progress_grows_to_one() -> None:
    shares: list[float] = []
    build_viewpoint_model(box(), shares.append, n_divisions=N_DIVISIONS)
    assert len(shares) > 3
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize(
    "mesh",
    [
        Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]])),
        Mesh(np.array([[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]]), np.array([[0, 1, 2]])),
        Mesh(np.eye(3), np.zeros((0, 3), dtype=np.int32)),
    ],
    ids=["point", "line", "no faces"],
)
def test_what_has_no_outline_is_refused(mesh: Mesh) -> None:
    with pytest.raises(ViewpointModelError, match="mesh"):
        build_viewpoint_model(mesh, n_divisions=0)
