"""Errors of poses and scores over frames, each with the paper and equation it comes from.

Poses are `camera_from_body`; points are vertices of the body, (N, 3), metres, body frame. The
definitions are those of the public BOP toolkit (`pose_error.py`), to rounding. A frame without
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
from snapfit.tracking.kernels.metrics import least_largest_distance_m, least_largest_distance_px

Points = npt.NDArray[np.float64]
Errors = npt.NDArray[np.floating[Any]]

MOST_VERTICES = 1000
"""ADD(-S) is the mean over at most so many of a mesh's vertices."""

SYMMETRY_STEP = 0.01
"""A continuous axis is cut so that no point travels further than this share of the diameter."""

_SEED = 0


def model_vertices(mesh: Mesh, most: int | None = MOST_VERTICES) -> Points:
    """(N, 3) float64 vertices of a mesh, those that stick out first, metres, body frame.

    Of a larger mesh `most` vertices are drawn without replacement, the same ones every time.
    """
    vertices = mesh.vertices.astype(np.float64)
    if most is not None and len(vertices) > most:
        rng = np.random.default_rng(_SEED)
        vertices = vertices[np.sort(rng.choice(len(vertices), most, replace=False))]
    order = np.argsort(-np.linalg.norm(vertices - mesh.center_m, axis=1), kind="stable")
    return np.ascontiguousarray(vertices[order])


def symmetry_motions(symmetry: Symmetry, diameter_m: float) -> Points:
    """(S, 4, 4) motions that map a body onto itself, the identity first, metres.

    A continuous axis is cut into 315 angles, as the BOP toolkit does (`max_sym_disc_step` 0.01).
    """
    motions = symmetry.sampled(SYMMETRY_STEP * diameter_m, diameter_m / 2)
    return np.array([motion.matrix for motion in motions])


def add_m(points: Points, estimate: Pose, truth: Pose) -> float:
    """ADD: mean distance of the same points (Hinterstoisser et al. 2012, eq. 2; GBOT, e_ADD)."""
    moved = estimate.transform(points) - truth.transform(points)
    return float(np.linalg.norm(moved, axis=1).mean())


def add_s_m(points: Points, estimate: Pose, truth: Pose, tree: cKDTree | None = None) -> float:
    """ADD-S: mean distance from true points to the closest estimated (Hinterstoisser, eq. 3).

    The GBOT paper's e_ADD-S goes from estimated points to true ones; this is the direction of
    the BOP toolkit, with which its published figures were computed.

    Args:
        points: of the body.
        estimate, truth: `camera_from_body`.
        tree: of the points among which the closest is looked for, body frame: all vertices, where
            `points` are a sample of them. It serves every pose. Of `points` if absent.
    """
    true = (estimate.inverse() @ truth).transform(points)
    distances, _ = (tree or cKDTree(points)).query(true)
    return float(np.mean(distances))


def mssd_m(points: Points, estimate: Pose, truth: Pose, motions: Points) -> float:
    """MSSD: the largest distance, least over the symmetries (Hodan et al. 2020, eq. 2).

    Args:
        points: of the body.
        estimate, truth: `camera_from_body`.
        motions: (S, 4, 4), from `symmetry_motions`.
    """
    moved = (truth.inverse() @ estimate).transform(points)
    return float(least_largest_distance_m(moved, points, motions))


def mspd_px(
    points: Points, estimate: Pose, truth: Pose, motions: Points, camera: PinholeCamera
) -> float:
    """MSPD: the largest distance in the image, least over the symmetries (Hodan 2020, eq. 3).

    Infinite where the estimate has a point behind the camera.

    Args:
        points: of the body.
        estimate, truth: `camera_from_body`.
        motions: (S, 4, 4), from `symmetry_motions`.
        camera: into which points are projected.
    """
    moved = estimate.transform(points)
    if moved[:, 2].min() <= 0:
        return float("inf")
    intrinsics = np.array([camera.fx, camera.fy, camera.cx, camera.cy], dtype=np.float64)
    poses = truth.matrix @ motions
    return float(least_largest_distance_px(camera.project(moved), points, poses, intrinsics))


def recall(errors: Errors, threshold: float) -> float:
    """Share of errors below a threshold, 0 to 1; not a number without any."""
    errors = np.asarray(errors)
    return float((errors < threshold).mean()) if errors.size else float("nan")


def average_recall(errors: Errors, thresholds: Errors) -> float:
    """BOP's AR: mean recall over several thresholds, 0 to 1 (Hodan et al. 2020)."""
    return float(np.mean([recall(errors, threshold) for threshold in thresholds]))


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
