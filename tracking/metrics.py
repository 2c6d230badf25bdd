"""Errors of poses and scores over frames, each with the paper and equation it comes from.

Poses are `camera_from_body`; points are of the body, (N, 3), metres, body frame. A frame without
an estimate has the error infinity, so that it counts as a failure in every score.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from snapfit.models.camera import PinholeCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Pose
from snapfit.models.symmetry import Symmetry

Points = npt.NDArray[np.float64]
Errors = npt.NDArray[np.floating[Any]]


def surface_points(mesh: Mesh, n_points: int, rng: np.random.Generator) -> Points:
    """(N, 3) float64 points spread evenly over a mesh, metres, body frame.

    The papers take vertices, which on a CAD mesh crowd at fillets and leave flat faces bare.
    """
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = np.linalg.norm(np.cross(first, second), axis=1)
    chosen = rng.choice(len(areas), size=n_points, p=areas / areas.sum())
    u, v = rng.random((2, n_points, 1))
    # A point beyond the diagonal of the parallelogram goes back into the triangle.
    beyond = u + v > 1
    u, v = np.where(beyond, 1 - u, u), np.where(beyond, 1 - v, v)
    points: Points = corners[chosen, 0] + u * first[chosen] + v * second[chosen]
    return points


def add_m(points: Points, estimate: Pose, truth: Pose) -> float:
    """ADD: mean distance of the same points (Hinterstoisser et al. 2012, eq. 2; GBOT, e_ADD)."""
    return float(_distances(points, estimate, truth).mean())


def add_s_m(points: Points, estimate: Pose, truth: Pose) -> float:
    """ADD-S: mean distance to the closest point (Hinterstoisser et al. 2012, eq. 3)."""
    # In the true body frame the tree needs no rebuilding for other estimates.
    moved = (truth.inverse() @ estimate).transform(points)
    distances, _ = cKDTree(points).query(moved)
    return float(np.mean(distances))


def add_or_add_s_m(points: Points, estimate: Pose, truth: Pose, symmetry: Symmetry) -> float:
    """ADD(-S): ADD-S for a part with a symmetry, ADD for any other (GBOT, section 5.2)."""
    if symmetry.is_none:
        return add_m(points, estimate, truth)
    return add_s_m(points, estimate, truth)


def mssd_m(
    points: Points, estimate: Pose, truth: Pose, symmetry: Symmetry, step_m: float = 0.001
) -> float:
    """MSSD: the largest distance, least over the symmetries (Hodan et al. 2020, eq. 2).

    Args:
        points: of the body.
        estimate, truth: `camera_from_body`.
        symmetry: of the body.
        step_m: how finely a continuous axis is cut.
    """
    motions = symmetry.sampled(step_m, _radius_m(points))
    return min(float(_distances(points, estimate, truth @ motion).max()) for motion in motions)


def mspd_px(
    points: Points,
    estimate: Pose,
    truth: Pose,
    symmetry: Symmetry,
    camera: PinholeCamera,
    step_m: float = 0.001,
) -> float:
    """MSPD: the largest distance in the image, least over the symmetries (Hodan 2020, eq. 3).

    Args:
        points: of the body.
        estimate, truth: `camera_from_body`.
        symmetry: of the body.
        camera: into which points are projected.
        step_m: how finely a continuous axis is cut.
    """
    moved = camera.project(estimate.transform(points))
    errors_px = []
    for motion in symmetry.sampled(step_m, _radius_m(points)):
        true = camera.project((truth @ motion).transform(points))
        errors_px.append(float(np.linalg.norm(moved - true, axis=1).max()))
    return min(errors_px)


def recall(errors: Errors, threshold: float) -> float:
    """Share of errors below a threshold, 0 to 1; not a number without any."""
    errors = np.asarray(errors)
    return float((errors < threshold).mean()) if errors.size else float("nan")


def area_under_curve(errors: Errors, largest: float) -> float:
    """Area under the curve of recall over thresholds from 0 to `largest`, 0 to 1.

    It equals the mean of max(1 - e / largest, 0): with 0.1 m this is the GBOT paper's score s_i.
    """
    errors = np.asarray(errors)
    return float(np.clip(1 - errors / largest, 0, 1).mean()) if errors.size else float("nan")


def quantile(errors: Errors, share: float) -> float:
    """The least error that `share` of all do not exceed; infinity if it falls on a failure."""
    errors = np.asarray(errors)
    if not errors.size:
        return float("nan")
    return float(np.quantile(errors, share, method="inverted_cdf"))


def _distances(points: Points, estimate: Pose, truth: Pose) -> Points:
    distances: Points = np.linalg.norm(estimate.transform(points) - truth.transform(points), axis=1)
    return distances


def _radius_m(points: Points) -> float:
    center = (points.max(axis=0) + points.min(axis=0)) / 2
    return float(np.linalg.norm(points - center, axis=1).max())
