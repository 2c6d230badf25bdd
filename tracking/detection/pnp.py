"""A part's pose from its keypoints in the image: RANSAC PnP, refined on the inliers.

Fischler and Bolles, "Random Sample Consensus", 1981; Lepetit et al., "EPnP", IJCV 2009; the
refinement is Levenberg and Marquardt's, all by OpenCV.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Array, Pose
from snapfit.tracking.detection.parameters import PnpParameters

# PnP needs four points: three leave up to four poses.
_FEWEST = 4


class Rejection(StrEnum):
    """Why a candidate gave no pose."""

    NOT_FINITE = "not_finite"
    FEW_KEYPOINTS = "few_keypoints"
    FEW_INLIERS = "few_inliers"
    BEHIND_CAMERA = "behind_camera"
    DISTANCE = "distance"


@dataclass(frozen=True, eq=False)
class PnpPose:
    """A pose from keypoints.

    Attributes:
        camera_from_body: the pose.
        is_inlier: (K,) keypoints that agree with it.
        error_px: root mean square of the inliers' distances in the image.
    """

    camera_from_body: Pose
    is_inlier: npt.NDArray[np.bool_]
    error_px: float


def pose_from_keypoints(
    points_m: Array,
    pixels: Array,
    presence: npt.NDArray[np.floating],
    camera: PinholeCamera,
    parameters: PnpParameters,
) -> PnpPose | Rejection:
    """The pose, or why there is none.

    Args:
        points_m: (K, 3) keypoints, body frame, m.
        pixels: (K, 2) where they are seen.
        presence: (K,) 0 to 1, how surely each is in the image.
        camera: that took it.
        parameters: of RANSAC, and what is rejected.
    """
    if not (np.isfinite(pixels).all() and np.isfinite(presence).all()):
        return Rejection.NOT_FINITE
    used = np.flatnonzero(presence >= parameters.least_presence)
    if len(used) < max(parameters.least_inliers, _FEWEST):
        return Rejection.FEW_KEYPOINTS
    found = _ransac(points_m[used], pixels[used], camera, parameters)
    if found is None:
        return Rejection.FEW_INLIERS
    refined = _refined(points_m, pixels, used, found, camera, parameters)
    if isinstance(refined, Rejection):
        return refined
    distance_m = float(np.linalg.norm(refined.camera_from_body.transform(points_m.mean(axis=0))))
    if not parameters.nearest_m <= distance_m <= parameters.farthest_m:
        return Rejection.DISTANCE
    return refined


def _ransac(
    points_m: Array, pixels: Array, camera: PinholeCamera, parameters: PnpParameters
) -> tuple[Array, Array] | None:
    """Rotation vector and translation, (3, 1) each; None where nothing agrees."""
    try:
        is_found, rotation, translation, _ = cv2.solvePnPRansac(
            points_m,
            pixels,
            camera.matrix,
            None,
            iterationsCount=parameters.iterations,
            reprojectionError=parameters.threshold_px,
            confidence=parameters.sureness,
            flags=cv2.SOLVEPNP_EPNP,
        )
    except cv2.error:
        # Points that fall together or lie on a line: there is no pose.
        return None
    if not is_found or not (np.isfinite(rotation).all() and np.isfinite(translation).all()):
        return None
    return rotation, translation


def _refined(
    points_m: Array,
    pixels: Array,
    used: npt.NDArray[np.int64],
    found: tuple[Array, Array],
    camera: PinholeCamera,
    parameters: PnpParameters,
) -> PnpPose | Rejection:
    """Refined on the inliers, which are then judged anew."""
    pose = _pose(*found)
    for _ in range(2):
        if not (pose.transform(points_m)[:, 2] > 0).all():
            return Rejection.BEHIND_CAMERA
        near = _distances(pose, points_m[used], pixels[used], camera) <= parameters.threshold_px
        inliers = used[near]
        if len(inliers) < max(parameters.least_inliers, _FEWEST):
            return Rejection.FEW_INLIERS
        rotation, translation = cv2.Rodrigues(pose.rotation)[0], pose.translation[:, None].copy()
        arrays = points_m[inliers], pixels[inliers], camera.matrix, None, rotation, translation
        pose = _pose(*cv2.solvePnPRefineLM(*arrays))
        if not np.isfinite(pose.matrix).all():
            return Rejection.NOT_FINITE
    if not (pose.transform(points_m)[:, 2] > 0).all():
        return Rejection.BEHIND_CAMERA
    errors = _distances(pose, points_m, pixels, camera)
    is_inlier = np.zeros(len(points_m), dtype=np.bool_)
    is_inlier[used] = errors[used] <= parameters.threshold_px
    if is_inlier.sum() < max(parameters.least_inliers, _FEWEST):
        return Rejection.FEW_INLIERS
    return PnpPose(pose, is_inlier, float(np.sqrt((errors[is_inlier] ** 2).mean())))


def _pose(rotation: Array, translation: Array) -> Pose:
    return Pose.from_rotation_translation(cv2.Rodrigues(rotation)[0], np.ravel(translation))


def _distances(pose: Pose, points_m: Array, pixels: Array, camera: PinholeCamera) -> Array:
    result: Array = np.linalg.norm(camera.project(pose.transform(points_m)) - pixels, axis=1)
    return result
