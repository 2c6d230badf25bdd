"""Where a turned part is, by the box it was found in: its drawn outline has to fill that box.

Keypoints that a network is unsure of are said too near to the part's middle. That is a smaller
part, so PnP puts it too far away, while its rotation may still be right. The box says the size
well, also of a part that is half hidden: it is that of the whole outline.
"""

from __future__ import annotations

import numpy as np

from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Array, Pose
from snapfit.tracking.detection.candidates import overlaps
from snapfit.tracking.detection.parameters import BoxParameters

_LEAST_SIDES = 3


def placed_by_box(
    camera_from_body: Pose,
    outline_m: Array,
    box_px: Array,
    camera: PinholeCamera,
    parameters: BoxParameters,
) -> Pose | None:
    """The pose with the same rotation whose outline fills the box; None where there is none.

    A pose whose outline fills it already is returned as it is.

    Args:
        camera_from_body: from keypoints.
        outline_m: (N, 3) corners of the part's convex hull, body frame, m.
        box_px: (4,) left, top, right, bottom that the network says, px of the image.
        camera: that took it.
        parameters: how well is well enough.
    """
    turned = outline_m @ camera_from_body.rotation.T
    if (turned[:, 2] + camera_from_body.translation[2] > parameters.nearest_m).all():
        drawn = _drawn_box(turned + camera_from_body.translation, camera)
        if overlaps(_inside(box_px, camera), _inside(drawn, camera)[None])[0] >= parameters.fills:
            return camera_from_body
    size = np.array([camera.width, camera.height, camera.width, camera.height])
    far = np.array([False, False, True, True])
    # A side at the border of the image is not the part's own.
    is_cut = np.where(far, box_px > size - parameters.border_px, box_px < parameters.border_px)
    if np.count_nonzero(~is_cut) < _LEAST_SIDES:
        return None
    place = _first_place(turned, box_px, camera)
    for _ in range(parameters.rounds):
        points = turned + place
        if not (points[:, 2] > parameters.nearest_m).all():
            return None
        place = place + _step(points, box_px, ~is_cut, camera)
    if not (turned[:, 2] + place[2] > parameters.nearest_m).all():
        return None
    return Pose.from_rotation_translation(camera_from_body.rotation, place)


def _first_place(turned: Array, box_px: Array, camera: PinholeCamera) -> Array:
    """(3,) m, as if all points were equally far: by the diagonals of outline and box."""
    near, far = turned.min(axis=0), turned.max(axis=0)
    focal = np.array([camera.fx, camera.fy])
    sides = np.maximum(box_px[2:] - box_px[:2], 1.0) / focal
    depth = np.linalg.norm(far[:2] - near[:2]) / np.linalg.norm(sides)
    middle = ((box_px[:2] + box_px[2:]) / 2 - (camera.cx, camera.cy)) / focal * depth
    return np.array([*(middle - (near[:2] + far[:2]) / 2), depth - (near[2] + far[2]) / 2])


def _step(points: Array, box_px: Array, used: Array, camera: PinholeCamera) -> Array:
    """(3,) m, Gauss-Newton: the outermost points move to the sides of the box."""
    pixels = camera.project(points)
    extreme = np.concatenate([pixels.argmin(axis=0), pixels.argmax(axis=0)])
    axis = np.array([0, 1, 0, 1])
    x, y, z = points[extreme].T
    focal = np.where(axis == 0, camera.fx, camera.fy)
    along = np.where(axis == 0, x, y)
    rows = np.zeros((4, 3))
    rows[range(4), axis] = focal / z
    rows[:, 2] = -focal * along / z**2
    errors = box_px - pixels[extreme, axis]
    step: Array = np.linalg.lstsq(rows[used], errors[used], rcond=None)[0]
    return step


def _drawn_box(points: Array, camera: PinholeCamera) -> Array:
    pixels = camera.project(points)
    return np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])


def _inside(box: Array, camera: PinholeCamera) -> Array:
    """A box as far as it lies in the image."""
    clipped: Array = np.clip(box, 0, (camera.width, camera.height, camera.width, camera.height))
    return clipped
