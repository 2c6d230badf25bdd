"""One frame of all bodies, compiled: correspond, differentiate, solve; coarse to fine.

The work is cut into (body, part of its lines and points) and spread over the threads; Python is
entered once a frame.
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from snapfit.tracking.kernels.depth import find_points
from snapfit.tracking.kernels.geometry import intrinsics, multiply_poses
from snapfit.tracking.kernels.normal_equations import add_depth, add_region
from snapfit.tracking.kernels.pointers import view_rows
from snapfit.tracking.kernels.region import find_lines
from snapfit.tracking.kernels.structure import step_structure
from snapfit.tracking.kernels.types import (
    CONTOUR_WIDTH,
    F64,
    I64,
    SURFACE_WIDTH,
    Bodies,
    Cameras,
    DepthSettings,
    Images,
    Lines,
    Models,
    OcclusionSettings,
    Points,
    RegionSettings,
    Structures,
)
from snapfit.tracking.kernels.view import closest_view


@njit(cache=True, nogil=True)
def place_body(body: int, cameras: Cameras, models: Models, bodies: Bodies) -> None:
    """Closest view and single-precision poses of a body."""
    bodies.views[body] = closest_view(
        models.directions,
        models.neighbours,
        bodies.poses[body],
        models.centers[body],
        bodies.views[body],
    )
    bodies.color_poses[body] = bodies.poses[body]
    multiply_poses(cameras.depth_from_color, bodies.poses[body], bodies.depth_poses[body])


@njit(cache=True, nogil=True)
def correspond(
    body: int,
    part: int,
    n_parts: int,
    iteration: int,
    images: Images,
    cameras: Cameras,
    models: Models,
    bodies: Bodies,
    region: RegionSettings,
    depth: DepthSettings,
    occlusion: OcclusionSettings,
    lines: Lines,
    points: Points,
    counts: I64,
) -> None:
    """Find one part in `n_parts` of a body's lines and points; counts (2, 4) are written anew."""
    view = bodies.views[body]
    unit = models.units[body]
    scratch = np.empty(64, dtype=np.float32)
    counts[:] = 0
    n = models.line_counts[body, view]
    find_lines(
        body,
        part * n // n_parts,
        (part + 1) * n // n_parts,
        iteration,
        images,
        cameras,
        bodies,
        view_rows(models.contours[body], view, models.n_rows, CONTOUR_WIDTH),
        unit,
        region,
        occlusion,
        lines,
        counts[0],
        scratch,
    )
    n = models.point_counts[body, view]
    find_points(
        body,
        part * n // n_parts,
        (part + 1) * n // n_parts,
        iteration,
        images,
        cameras,
        bodies,
        view_rows(models.surfaces[body], view, models.n_rows, SURFACE_WIDTH),
        unit,
        depth,
        occlusion,
        points,
        counts[1],
        scratch,
    )


@njit(cache=True, nogil=True)
def differentiate(
    body: int,
    iteration: int,
    update: int,
    cameras: Cameras,
    models: Models,
    bodies: Bodies,
    region: RegionSettings,
    lines: Lines,
    points: Points,
) -> None:
    """Gradient and Hessian of a body at its pose, into `bodies`."""
    gradient = bodies.gradients[body]
    gradient[:] = 0.0
    bodies.hessians[body] = 0.0
    bodies.color_poses[body] = bodies.poses[body]
    pose = bodies.color_poses[body]
    jacobian = np.empty(6, dtype=np.float32)
    add_region(
        body,
        models.line_counts[body, bodies.views[body]],
        pose,
        intrinsics(cameras.color),
        region,
        iteration,
        update < region.global_updates,
        lines,
        gradient,
        bodies.hessians[body],
        jacobian,
    )
    add_depth(
        body,
        models.point_counts[body, bodies.views[body]],
        pose,
        points,
        gradient,
        bodies.hessians[body],
        jacobian,
    )


@njit(cache=True, nogil=True, parallel=True)
def correspond_all(
    iteration: int,
    n_parts: int,
    images: Images,
    cameras: Cameras,
    models: Models,
    bodies: Bodies,
    region: RegionSettings,
    depth: DepthSettings,
    occlusion: OcclusionSettings,
    lines: Lines,
    points: Points,
    counts: I64,
) -> None:
    """Find the correspondences of all active bodies in what one camera sees; see `refine`."""
    active = np.flatnonzero(bodies.active)
    n_active = len(active)
    for i in range(n_active):
        place_body(active[i], cameras, models, bodies)
    # Each thread gets one stretch of the tasks. Points lie in random order, so that the first
    # parts of all bodies cost as much as the last parts of all, whatever each body costs.
    for task in prange(n_parts * n_active):
        part = task // n_active
        body = active[task - part * n_active]
        correspond(
            body,
            part,
            n_parts,
            iteration,
            images,
            cameras,
            models,
            bodies,
            region,
            depth,
            occlusion,
            lines,
            points,
            counts[body, part],
        )


@njit(cache=True, nogil=True, parallel=True)
def differentiate_all(
    iteration: int,
    update: int,
    cameras: Cameras,
    models: Models,
    bodies: Bodies,
    region: RegionSettings,
    lines: Lines,
    points: Points,
) -> None:
    """Gradients and Hessians of all active bodies by one camera's correspondences."""
    active = np.flatnonzero(bodies.active)
    for i in prange(len(active)):
        differentiate(
            active[i],
            iteration,
            update,
            cameras,
            models,
            bodies,
            region,
            lines,
            points,
        )


@njit(cache=True, nogil=True, parallel=True)
def step_all(structures: Structures, bodies: Bodies, tikhonov: F64) -> None:
    """A Newton step of all structures."""
    for structure in prange(bodies.poses.shape[0]):
        step_structure(structure, structures, bodies, tikhonov)


@njit(cache=True, nogil=True)
def refine(
    n_iterations: int,
    n_updates: int,
    n_parts: int,
    images: Images,
    cameras: Cameras,
    models: Models,
    bodies: Bodies,
    structures: Structures,
    region: RegionSettings,
    depth: DepthSettings,
    occlusion: OcclusionSettings,
    tikhonov: F64,
    lines: Lines,
    points: Points,
    counts: I64,
) -> None:
    """Refine the poses of all structures against one frame (ICG, Mb-ICG).

    Args:
        n_iterations, n_updates: correspondence and update iterations.
        n_parts: parts that a body's lines and points are cut into, for the threads.
        images, cameras, models: what is seen, by what, of what.
        bodies: poses are refined in place.
        structures: how they are linked; the coordinates of their joints are refined in place.
        region, depth, occlusion: parameters.
        tikhonov: (2,) of rotation and translation.
        lines, points: working arrays; hold the last correspondences afterwards.
        counts: (B, n_parts, 2, 4) of lines and points, of the last iteration.
    """
    bodies.solved[:] = 1
    for iteration in range(n_iterations):
        correspond_all(
            iteration,
            n_parts,
            images,
            cameras,
            models,
            bodies,
            region,
            depth,
            occlusion,
            lines,
            points,
            counts,
        )
        for update in range(n_updates):
            differentiate_all(iteration, update, cameras, models, bodies, region, lines, points)
            step_all(structures, bodies, tikhonov)
