"""Outlines of bodies with holes and of scanned ones, against silhouettes drawn much finer."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy import ndimage

from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh, load_mesh
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import render
from snapfit.models.viewpoint_build import build_viewpoint_model
from snapfit.models.viewpoint_grid import viewpoint_pose
from snapfit.models.viewpoint_model import NORMAL_UNIT, ViewpointModel

SIZE_PX = 1600


def outline_errors(mesh: Mesh, model: ViewpointModel, view: int) -> tuple[np.ndarray, np.ndarray]:
    """Signed distances of contour points to the silhouette's border, m; whose sides are right."""
    pose = viewpoint_pose(model.directions[view], model.center_m, model.radius_m)
    focal_px = 0.45 * SIZE_PX * model.radius_m / mesh.radius_m
    middle = (SIZE_PX - 1) / 2
    camera = PinholeCamera(SIZE_PX, SIZE_PX, focal_px, focal_px, middle, middle)
    seen = render(camera, [(mesh, pose)]).part_id > 0
    inside, outside = ndimage.distance_transform_edt(seen), ndimage.distance_transform_edt(~seen)
    signed_px = np.where(seen, inside - 0.5, 0.5 - outside)
    pixels = camera.project(pose.transform(model.contour[view, :, :3] * model.unit_m))
    errors_px = ndimage.map_coordinates(signed_px, pixels[:, ::-1].T, order=1)
    normals = (model.contour[view, :, 3:6] * NORMAL_UNIT @ pose.rotation.T)[:, :2]
    beyond, within = np.round(pixels + 3 * normals), np.round(pixels - 3 * normals)
    right = ~seen[tuple(beyond[:, ::-1].T.astype(int))] & seen[tuple(within[:, ::-1].T.astype(int))]
    return errors_px * model.radius_m / focal_px, right


def check_outline(mesh: Mesh) -> None:
    model = build_viewpoint_model(mesh, n_divisions=1)
    results = [outline_errors(mesh, model, view) for view in range(0, model.n_views, 6)]
    errors_m = np.concatenate([errors for errors, _ in results])
    fine_pixel_m = mesh.radius_m / (0.45 * SIZE_PX)
    assert abs(errors_m.mean()) < 0.1 * fine_pixel_m
    assert np.abs(errors_m).max() < fine_pixel_m
    assert np.concatenate([right for _, right in results]).mean() > 0.995


def test_a_block_with_holes() -> None:
    block = trimesh.creation.box((0.14, 0.06, 0.03))
    for x in (-0.04, 0.04):
        place = trimesh.transformations.translation_matrix((x, 0, 0))
        drill = trimesh.creation.cylinder(radius=0.012, height=0.1, transform=place, sections=100)
        block = trimesh.boolean.difference([block, drill], engine="manifold")
    check_outline(Mesh(block.vertices, block.faces))


def test_two_bodies_that_cut_through_each_other() -> None:
    one = trimesh.creation.box((0.14, 0.03, 0.03))
    other = trimesh.creation.cylinder(radius=0.02, height=0.12, sections=80)
    cross = trimesh.util.concatenate([one, other])
    check_outline(Mesh(cross.vertices, cross.faces))


@pytest.mark.parametrize("name", ["triangle", "schauma"])
def test_real_meshes(real_frames: Path, name: str) -> None:
    bodies = json.loads((real_frames / "sequence.json").read_text())["bodies"]
    body = next(b for b in bodies.values() if name in b["mesh"])
    mesh = load_mesh(
        real_frames / body["mesh"],
        unit_m=body["mesh_unit_m"],
        body_from_mesh=Pose.from_matrix(body["geometry2body"]),
        require_closed=False,
    )
    check_outline(mesh)
