"""Fixes a part's distance by measured depth: what the image says least of, depth says best."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.rasteriser import render
from snapfit.tracking.detection.parameters import RangeParameters

NO_DEPTH = (0, 65535)


def ranged(
    camera_from_body: Pose,
    mesh: Mesh,
    depth: npt.NDArray[np.uint16],
    camera: RgbdCamera,
    parameters: RangeParameters,
) -> Pose | None:
    """The pose, moved along the ray to the part until its surface lies where depth is measured.

    The part is drawn at the pose; the measured depth of its pixels is compared, and the distance
    on which most of them agree is taken: a hand in front and the bench behind are in the minority
    or out of the window.

    Args:
        camera_from_body: from PnP.
        mesh: of the part.
        depth: (H, W) in the camera's units.
        camera: with a depth camera.
        parameters: of the comparison.

    Returns:
        The pose; None where too little of the part is measured.
    """
    if camera.depth is None:
        return None
    small = camera.depth.scaled(parameters.scale)
    depth_from_color = camera.color_from_depth.inverse()
    pose = depth_from_color @ camera_from_body
    for _ in range(parameters.rounds):
        drawn = render(small, [(mesh, pose)]).depth
        rows, columns = np.nonzero(drawn > 0)
        measured_m = _measured(depth, camera, small, rows, columns)
        factor = _agreed(drawn[rows, columns].astype(np.float64), measured_m, parameters)
        if factor is None:
            return None
        moved = pose.translation * factor
        pose = Pose.from_rotation_translation(pose.rotation, moved)
    return camera.color_from_depth @ pose


def _measured(
    depth: npt.NDArray[np.uint16],
    camera: RgbdCamera,
    small: PinholeCamera,
    rows: npt.NDArray[np.int64],
    columns: npt.NDArray[np.int64],
) -> Array:
    """(N,) m at the middles of pixels of the small image; not a number where there is none."""
    height, width = depth.shape
    y = np.clip(np.rint((rows + 0.5) * height / small.height - 0.5).astype(np.int64), 0, height - 1)
    x = np.clip(np.rint((columns + 0.5) * width / small.width - 0.5).astype(np.int64), 0, width - 1)
    raw = depth[y, x]
    result: Array = np.where(np.isin(raw, NO_DEPTH), np.nan, raw * camera.depth_scale_m)
    return result


def _agreed(drawn_m: Array, measured_m: Array, parameters: RangeParameters) -> float | None:
    """By what the distance has to be multiplied; None where too few pixels agree on one.

    The densest stretch of differences wins: sorted, it is the one with the most of them within
    twice the tolerance.
    """
    with np.errstate(invalid="ignore"):
        is_near = np.abs(measured_m / drawn_m - 1) < parameters.window
    differences = np.sort((measured_m - drawn_m)[is_near])
    if len(differences) < parameters.least_pixels:
        return None
    ends = np.searchsorted(differences, differences + 2 * parameters.agreement_m, side="right")
    counts = ends - np.arange(len(differences))
    first = int(np.argmax(counts))
    if counts[first] < max(parameters.least_pixels, parameters.least_share * len(drawn_m)):
        return None
    shift_m = float(np.median(differences[first : ends[first]]))
    return 1 + shift_m / float(np.median(drawn_m))
