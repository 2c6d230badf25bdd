"""Tells that a part cannot be where it is believed: the depth camera sees what lies behind it.

A contour alone may fit the image of another thing, nearer or farther. Where next to no point of
the surface agrees with the depth image, the points are looked up one by one: depth that is missing
says nothing, something nearer may hide the part, but what is measured behind it was seen through.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Array, Pose
from snapfit.tracking.body import Body
from snapfit.tracking.confidence import Evidence
from snapfit.tracking.frame import Frame

_SUPPORTING, _ENOUGH_POINTS = 0.2, 20
_BEHIND_M = 0.025
_SEEN_THROUGH = 0.5
_SURFACE_M, _VACANT, _SEEN_SHARE = 0.006, 0.35, 0.5


class SeenThrough:
    """Compares parts' surfaces with depth images of one camera.

    Args:
        bodies: all that are tracked.
        camera: where the frames come from.
    """

    def __init__(self, bodies: Sequence[Body], camera: RgbdCamera) -> None:
        self._camera = camera
        self._views = [body.views for body in bodies]
        self._depth_from_color = camera.color_from_depth.inverse()

    def contradicts(self, frame: Frame, body: int, pose: Pose, evidence: Evidence) -> bool:
        """Whether a body is not where its pose puts it, as the depth image says.

        Args:
            frame: that the pose was refined in.
            body: its index.
            pose: `camera_from_body`.
            evidence: of this pose; where enough points agree, nothing is looked up.
        """
        few = evidence.supporting_points < _SUPPORTING * evidence.visible_points
        if evidence.visible_points < _ENOUGH_POINTS or not few:
            return False
        behind_m, has_depth = self._behind(frame, body, pose)
        # What lies in front hides the part: those points are not to be asked.
        asked = ~has_depth | (behind_m > -_BEHIND_M)
        through = has_depth & (behind_m > _BEHIND_M)
        return bool(through.sum() > max(_SEEN_THROUGH * asked.sum(), _ENOUGH_POINTS))

    def is_vacant(self, frame: Frame, body: int, pose: Pose) -> bool:
        """Whether a place where a body was is seen, and nothing of the body is there.

        A place behind a hand is not seen: nobody can tell. Nor without depth.

        Args:
            frame: that is looked at.
            body: its index.
            pose: `camera_from_body` of the place.
        """
        behind_m, has_depth = self._behind(frame, body, pose)
        asked = has_depth & (behind_m > -_SURFACE_M)
        there = asked & (behind_m < _SURFACE_M)
        enough = asked.sum() > max(_SEEN_SHARE * len(behind_m), _ENOUGH_POINTS)
        return bool(enough and there.sum() < _VACANT * asked.sum())

    def _behind(self, frame: Frame, body: int, pose: Pose) -> tuple[Array, npt.NDArray[np.bool_]]:
        """For each surface point in the image, how far behind it something is measured, m.

        And whether anything is: (P,) both, empty without depth.
        """
        camera, depth = self._camera.depth, frame.depth
        if camera is None or depth is None:
            return np.zeros(0), np.zeros(0, dtype=np.bool_)
        points = (self._depth_from_color @ pose).transform(self._surface(body, pose))
        points = points[points[:, 2] > 0]
        column, row = np.rint(camera.project(points)).astype(np.int64).T
        inside = (column >= 0) & (row >= 0) & (column < camera.width) & (row < camera.height)
        counts = depth[row[inside], column[inside]]
        behind_m = counts * self._camera.depth_scale_m - points[inside, 2]
        return behind_m, (counts > 0) & (counts < np.iinfo(np.uint16).max)

    def _surface(self, body: int, pose: Pose) -> Array:
        """(300, 3) points of a body's surface that the camera sees, body frame, m."""
        views = self._views[body]
        to_camera = pose.inverse().translation - views.center_m
        view = int(np.argmax(views.directions @ to_camera))
        points: Array = views.surface[view, :, :3].astype(np.float64) * views.unit_m
        return points
