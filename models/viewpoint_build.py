"""Generating the viewpoint model of a mesh with the software rasteriser, on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed

import numpy as np
import numpy.typing as npt

from snapfit.models.errors import ViewpointModelError
from snapfit.models.mesh import Mesh, simplified
from snapfit.models.viewpoint_contour import make_crossings
from snapfit.models.viewpoint_grid import N_DIVISIONS, geodesic_grid, viewpoint_pose
from snapfit.models.viewpoint_kernels import fill_views
from snapfit.models.viewpoint_model import (
    N_POINTS,
    OCCLUSION_RADIUS_M,
    SATURATED,
    ViewpointModel,
)

VIEWPOINT_DISTANCE_M = 0.8
IMAGE_SIZE_PX = 500
_MARGIN_PX = 4
_DISTANCE_IN_RADII = 4.0
_CELLS_IN_OCCLUSION_RADIUS = 6
_VIEWS_AT_ONCE = 32
# Of the largest coordinate, so that every distance within a body fits below the saturation.
_LONGEST_IN_COORDINATES = 4.0
# Beyond this a finer mesh moves the outline by less than the image can show.
_MAX_FACES = 30_000


def build_viewpoint_model(
    mesh: Mesh,
    progress: Callable[[float], None] | None = None,
    *,
    n_divisions: int = N_DIVISIONS,
) -> ViewpointModel:
    """Generate the viewpoint model of a body; takes seconds.

    Args:
        mesh: closed or not, body frame.
        progress: called from time to time with the share that is done, up to 1.
        n_divisions: of the geodesic grid; 4 gives 2562 views.

    Raises:
        ViewpointModelError: the mesh is empty, or no view shows anything of it.
    """
    if len(mesh.faces) == 0 or mesh.radius_m == 0:
        raise ViewpointModelError("the mesh is empty or a point: it has no outline to track")
    mesh = simplified(mesh, _MAX_FACES)
    directions, neighbours = geodesic_grid(n_divisions)
    center_m = mesh.center_m
    distance_m = max(VIEWPOINT_DISTANCE_M, _DISTANCE_IN_RADII * mesh.radius_m)
    unit_m = _LONGEST_IN_COORDINATES * float(np.abs(mesh.vertices).max()) / SATURATED
    poses = np.stack([viewpoint_pose(d, center_m, distance_m).matrix for d in directions])
    camera = _camera(mesh.radius_m, distance_m)
    contour, surface, extents = _fill(mesh, poses, camera, distance_m, unit_m, progress)
    if not extents[:, 1].any():
        raise ViewpointModelError("no view shows anything of the mesh: do its faces have no area?")
    return ViewpointModel(
        center_m=center_m,
        radius_m=distance_m,
        directions=directions.astype(np.float32),
        neighbours=neighbours,
        unit_m=unit_m,
        contour=contour,
        surface=surface,
        contour_length_m=extents[:, 0].copy(),
        surface_area_m2=extents[:, 1] * np.float32((distance_m / camera[0]) ** 2),
    )


def mesh_edges(faces: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """The edges of a mesh: (E, 5) two vertices, two faces, 1 where both run in one direction.

    An edge of one face, or each face at an edge of three and more, has -1 as its second face.
    """
    ends = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(np.int64)
    keys = ends.min(axis=1) << 32 | ends.max(axis=1)
    order = np.argsort(keys, kind="stable")
    ends, keys = ends[order], keys[order]
    face = np.repeat(np.arange(len(faces)), 3)[order]
    _, first, counts = np.unique(keys, return_index=True, return_counts=True)
    one = first[counts == 2]
    two = one + 1
    paired = np.column_stack(
        [ends[one], face[one], face[two], (ends[one, 0] == ends[two, 0]).astype(np.int64)]
    )
    rest = np.repeat(counts != 2, counts)
    alone = np.full((int(rest.sum()), 5), -1)
    alone[:, :2], alone[:, 2] = ends[rest], face[rest]
    return np.ascontiguousarray(np.concatenate([paired, alone]), dtype=np.int32)


def _fill(
    mesh: Mesh,
    poses: npt.NDArray[np.float64],
    camera: npt.NDArray[np.float64],
    distance_m: float,
    unit_m: float,
    progress: Callable[[float], None] | None,
) -> tuple[npt.NDArray[np.int16], npt.NDArray[np.int16], npt.NDArray[np.float32]]:
    """Contour, surface and extents of the views from `poses`, on all cores."""
    contour = np.zeros((len(poses), N_POINTS, 9), dtype=np.int16)
    surface = np.zeros((len(poses), N_POINTS, 7), dtype=np.int16)
    extents = np.zeros((len(poses), 2), dtype=np.float32)
    radius_px = OCCLUSION_RADIUS_M * camera[0] / distance_m
    cell_px = max(1, round(radius_px / _CELLS_IN_OCCLUSION_RADIUS))
    edges, normals = mesh_edges(mesh.faces), _unit_normals(mesh)

    def fill(start: int) -> int:
        views = slice(start, start + _VIEWS_AT_ONCE)
        fill_views(
            poses[views],
            mesh.vertices,
            mesh.faces,
            edges,
            normals,
            camera,
            cell_px,
            OCCLUSION_RADIUS_M,
            unit_m,
            make_crossings(IMAGE_SIZE_PX),
            contour[views],
            surface[views],
            extents[views],
        )
        return len(poses[views])

    _in_threads(fill, len(poses), progress)
    return contour, surface, extents


def _camera(radius_m: float, distance_m: float) -> npt.NDArray[np.float64]:
    """(4,) fx, fy, cx, cy in px of an image that the bounding sphere just fits."""
    half_width = radius_m / np.sqrt(distance_m**2 - radius_m**2)
    focal_px = (IMAGE_SIZE_PX / 2 - _MARGIN_PX) / half_width
    middle = (IMAGE_SIZE_PX - 1) / 2
    return np.array([focal_px, focal_px, middle, middle])


def _unit_normals(mesh: Mesh) -> npt.NDArray[np.float32]:
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return (normals / np.where(lengths > 0, lengths, 1)).astype(np.float32)


def _in_threads(
    fill: Callable[[int], int], n_views: int, progress: Callable[[float], None] | None
) -> None:
    """Call `fill` for each bunch of views, on as many threads as there are cores."""
    n_done = 0
    with ThreadPoolExecutor(max_workers=os.cpu_count() or 1) as pool:
        waiting = [pool.submit(fill, start) for start in range(0, n_views, _VIEWS_AT_ONCE)]
        for future in as_completed(waiting):
            n_done += future.result()
            if progress is not None:
                progress(n_done / n_views)
