"""A hidden part that was being moved goes where the hand before it goes.

The image around the part's middle, which then shows the hand, is looked for in the next frame;
its shift and the change of its depth move the part. A part that lay still when it was hidden is
left where it lay: a hand passes over many things.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Array, Pose
from snapfit.tracking.body import Body
from snapfit.tracking.frame import Frame

_SHRINK = 2
_LEAST_PX, _MOST_PX = 20, 48
_SEARCH_PX = 16
_LEAST_SCORE = 0.6
_SPEED_RATE = 0.3


@dataclass(frozen=True, eq=False)
class _Cover:
    """What was seen before a hidden part: grey image around (row, column), shrunk; depth, m."""

    image: npt.NDArray[np.uint8]
    row: int
    column: int
    depth_m: float


class CarriedParts:
    """Moves hidden parts with what hides them.

    Args:
        bodies: all that are tracked.
        camera: where the frames come from.
        least_step_m: a part that moved by less from frame to frame, lately, lay still.
    """

    def __init__(
        self, bodies: Sequence[Body], camera: RgbdCamera, least_step_m: float = 0.0012
    ) -> None:
        self._camera = camera
        self._least_step_m = least_step_m
        self._centers = [np.asarray(body.mesh.center_m, dtype=np.float64) for body in bodies]
        self._radii = [float(body.mesh.radius_m) for body in bodies]
        self._steps = np.zeros(len(bodies))
        self._last: dict[int, Array] = {}
        self._covers: dict[int, _Cover] = {}

    def follow(
        self, frame: Frame, seen: Mapping[int, Pose], hidden: Mapping[int, Pose]
    ) -> dict[int, Pose]:
        """Take in a frame; returns where hidden parts were carried.

        Args:
            frame: the newest.
            seen: bodies that are tracked, with their poses.
            hidden: bodies that are not, with the poses that are expected.
        """
        for body, pose in seen.items():
            center = pose.transform(self._centers[body][None])[0]
            if body in self._last and body not in self._covers:
                step = float(np.linalg.norm(center - self._last[body]))
                self._steps[body] += _SPEED_RATE * (min(step, 0.02) - self._steps[body])
            self._last[body] = center
            self._covers.pop(body, None)
        carried = {}
        for body, pose in hidden.items():
            if self._steps[body] < self._least_step_m:
                continue
            moved = self._shift(frame, body) if body in self._covers else np.zeros(3)
            if moved is not None and body in self._covers:
                carried[body] = Pose.from_translation(*moved) @ pose
            now = carried.get(body, pose)
            cover = self._cover(frame, body, now.transform(self._centers[body][None])[0])
            if cover is None:
                self._covers.pop(body, None)
            else:
                self._covers[body] = cover
        return carried

    def _cover(self, frame: Frame, body: int, center: Array) -> _Cover | None:
        """What is seen around a place; None at the border of the image."""
        if center[2] <= 0:
            return None
        camera = self._camera.color
        u, v = camera.project(center[None])[0]
        reach = int(np.clip(0.6 * self._radii[body] * camera.fx / center[2], _LEAST_PX, _MOST_PX))
        grey = _grey(frame, int(v) - reach, int(u) - reach, 2 * reach)
        if grey is None:
            return None
        return _Cover(grey, int(v) - reach, int(u) - reach, self._depth(frame, v, u, reach))

    def _shift(self, frame: Frame, body: int) -> Array | None:
        """(3,) how far the cover has moved, m; None where it is not found again."""
        cover = self._covers[body]
        margin = _SEARCH_PX * _SHRINK
        size = cover.image.shape[0] * _SHRINK
        grey = _grey(frame, cover.row - margin, cover.column - margin, size + 2 * margin)
        if grey is None or cover.depth_m <= 0:
            return None
        scores = cv2.matchTemplate(grey, cover.image, cv2.TM_CCOEFF_NORMED)
        _, best, _, (x, y) = cv2.minMaxLoc(scores)
        if best < _LEAST_SCORE:
            return None
        du, dv = (x - _SEARCH_PX) * _SHRINK, (y - _SEARCH_PX) * _SHRINK
        v, u = cover.row + size / 2 + dv, cover.column + size / 2 + du
        depth_m = self._depth(frame, v, u, size // 2)
        nearer_m = depth_m - cover.depth_m if depth_m > 0 else 0.0
        camera = self._camera.color
        return np.array(
            [
                du * cover.depth_m / camera.fx,
                dv * cover.depth_m / camera.fy,
                float(np.clip(nearer_m, -0.015, 0.015)),
            ]
        )

    def _depth(self, frame: Frame, v: float, u: float, reach: int) -> float:
        """Median depth around a place of the colour image, m; 0 where nothing is measured.

        The shift between the cameras is left out: only changes of the depth count.
        """
        camera, color = self._camera.depth, self._camera.color
        if camera is None or frame.depth is None:
            return 0.0
        column = int((u - color.cx) / color.fx * camera.fx + camera.cx)
        row = int((v - color.cy) / color.fy * camera.fy + camera.cy)
        half = max(reach // 2, 4)
        window = frame.depth[
            max(row - half, 0) : row + half : 3, max(column - half, 0) : column + half : 3
        ]
        known = window[(window > 0) & (window < 65535)]
        return float(np.median(known)) * self._camera.depth_scale_m if known.size else 0.0


def _grey(frame: Frame, row: int, column: int, size: int) -> npt.NDArray[np.uint8] | None:
    """A square of the image, grey and shrunk; None where it leaves the image."""
    height, width = frame.color.shape[:2]
    if row < 0 or column < 0 or row + size > height or column + size > width:
        return None
    square = frame.color[row : row + size, column : column + size]
    small = cv2.resize(square, None, fx=1 / _SHRINK, fy=1 / _SHRINK, interpolation=cv2.INTER_AREA)
    grey: npt.NDArray[np.uint8] = cv2.cvtColor(small, cv2.COLOR_BGR2GRAY)
    return grey
