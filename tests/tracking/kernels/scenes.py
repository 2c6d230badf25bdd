"""What the kernels work on: a camera, random poses, correspondence lines and surface points."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.viewpoint_model import ViewpointModel
from snapfit.tracking.body import Body
from snapfit.tracking.depth_modality import empty_points
from snapfit.tracking.kernel_cameras import kernel_cameras
from snapfit.tracking.kernels.geometry import intrinsics
from snapfit.tracking.kernels.types import (
    Bodies,
    Cameras,
    Images,
    Intrinsics,
    Lines,
    Models,
    OcclusionSettings,
    Points,
)
from snapfit.tracking.region_modality import empty_lines

Array = npt.NDArray[Any]
F32 = npt.NDArray[np.float32]

CAMERA = PinholeCamera(240, 200, fx=230.0, fy=225.0, cx=118.3, cy=101.2)


def kernel_camera(camera: PinholeCamera = CAMERA) -> Intrinsics:
    """A camera as the kernels take it."""
    values = (camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height)
    packed: Intrinsics = intrinsics(np.array(values, dtype=np.float32))
    return packed


def focal_and_center(camera: PinholeCamera = CAMERA) -> Array:
    """(4,) fx, fy, cx, cy."""
    return np.array([camera.fx, camera.fy, camera.cx, camera.cy])


def both_cameras(
    color: PinholeCamera = CAMERA,
    depth: PinholeCamera | None = CAMERA,
    color_from_depth: Pose | None = None,
) -> Cameras:
    """An RGB-D camera as the kernels take it, with millimetres as its unit."""
    return kernel_cameras(
        RgbdCamera(color, depth, 0.001, color_from_depth or Pose.from_translation(0, 0, 0))
    )


def random_pose(rng: np.random.Generator, depth_m: float = 0.6) -> Pose:
    """Any rotation, about the middle of the image."""
    translation = [*rng.uniform(-0.05, 0.05, 2), depth_m * rng.uniform(0.8, 1.2)]
    return Pose.from_quaternion(rng.normal(size=4), translation)


def random_image(rng: np.random.Generator, camera: PinholeCamera = CAMERA) -> Array:
    """(H, W, 3) uint8, every pixel another colour."""
    return rng.integers(0, 256, (camera.height, camera.width, 3), dtype=np.uint8)


def unit_vectors(rng: np.random.Generator, shape: tuple[int, ...]) -> Array:
    """Spread evenly over the directions of the last axis."""
    vectors = rng.normal(size=shape)
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def random_lines(rng: np.random.Generator, n: int, pose: Pose, body: int = 1) -> Lines:
    """Lines of two bodies; those of `body` lie near where `pose` puts their points."""
    lines = empty_lines(2, n)
    points = rng.uniform(-0.06, 0.06, (n, 3))
    lines.point[body] = points
    lines.place[body, :, :2] = CAMERA.project(pose.transform(points)) + rng.normal(size=(n, 2))
    lines.place[body, :, 2:4] = unit_vectors(rng, (n, 2))
    lines.place[body, :, 4] = rng.uniform(-0.7, 0.7, n)
    lines.place[body, :, 5] = rng.uniform(0.15, 1.0, n)
    lines.place[body, :, 6:8] = rng.uniform(0, 40, (n, 2))
    lines.posterior[body] = rng.dirichlet(np.ones(12), n)
    lines.moments[body, :, 0] = rng.uniform(-4, 4, n)
    lines.moments[body, :, 1] = rng.uniform(0.5, 12, n)
    lines.valid[body] = rng.random(n) < 0.8
    return lines


def random_points(rng: np.random.Generator, n: int, pose: Pose, body: int = 1) -> Points:
    """Surface points of two bodies; those of `body` have something measured near them."""
    points = empty_points(2, n)
    places = rng.uniform(-0.06, 0.06, (n, 3))
    points.point[body] = places
    points.normal[body] = unit_vectors(rng, (n, 3))
    points.measured[body] = pose.transform(places) + rng.normal(scale=0.01, size=(n, 3))
    points.weight[body] = rng.uniform(1e3, 1e4, n)
    points.valid[body] = rng.random(n) < 0.8
    return points


def bodies_at(poses: list[Pose], tables: Array | None = None) -> Bodies:
    """The state of bodies that all take part; colours say nothing where no table is given."""
    n = len(poses)
    matrices = np.array([pose.matrix for pose in poses])
    even = np.full((n, 4096), 0.5)
    return Bodies(
        active=np.ones(n, dtype=np.uint8),
        poses=matrices,
        color_poses=matrices.astype(np.float32),
        depth_poses=matrices.astype(np.float32),
        views=np.zeros(n, dtype=np.int64),
        tables=(even if tables is None else tables).astype(np.float32),
        depth_scales=np.ones(n, dtype=np.float32),
        solved=np.ones(n, dtype=np.uint8),
        gradients=np.zeros((n, 6)),
        hessians=np.zeros((n, 6, 6)),
    )


def images_of(color: Array | None = None, depth: Array | None = None, n_bodies: int = 1) -> Images:
    """What is seen, and no body near another."""
    nothing = np.zeros((CAMERA.height, CAMERA.width), dtype=np.uint16)
    return Images(
        color=np.zeros((*nothing.shape, 3), dtype=np.uint8) if color is None else color,
        depth=nothing if depth is None else depth.astype(np.uint16),
        near_depth=np.zeros((1, 1), dtype=np.float32),
        near_id=np.zeros((1, 1), dtype=np.uint8),
        neighboured=np.zeros(n_bodies, dtype=np.uint8),
        alike=np.zeros((n_bodies, n_bodies), dtype=np.uint8),
        hiding=np.full(n_bodies, 0.02, dtype=np.float32),
    )


def occlusion(*, measured: bool = False, modelled: bool = False) -> OcclusionSettings:
    """Radius 10 mm, thresholds 20 and 5 mm, a small rendering of half the size."""
    return OcclusionSettings(
        measured=measured,
        modelled=modelled,
        radius=np.float32(0.01),
        modelled_threshold=np.float32(0.005),
        image_scale=np.float32(0.5),
    )


def counted_models(line_counts: list[int], point_counts: list[int]) -> Models:
    """Viewpoint models of one view without points: how many lines and points each body has."""
    n = len(line_counts)
    return Models(
        directions=np.array([[0, 0, -1]], dtype=np.float32),
        neighbours=np.zeros((1, 6), dtype=np.int16),
        contours=np.zeros(n, dtype=np.int64),
        surfaces=np.zeros(n, dtype=np.int64),
        n_rows=0,
        units=np.ones(n, dtype=np.float32),
        centers=np.zeros((n, 3), dtype=np.float32),
        line_counts=np.array(line_counts, dtype=np.int64)[:, None],
        point_counts=np.array(point_counts, dtype=np.int64)[:, None],
    )


def body_without_views(name: str, mesh: Mesh) -> Body:
    """A body that is only to be drawn."""
    nothing = np.zeros((0, 0), dtype=np.float32)
    counts = nothing.astype(np.int16)
    views = ViewpointModel(
        mesh.center_m, 0.8, nothing, counts, 1e-5, counts, counts, nothing[0:0, 0:0], nothing
    )
    return Body(name, mesh, views)
