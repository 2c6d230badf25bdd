"""Axis conventions: one matrix each, which every frame and every vector goes through.

`convention_from_opencv` (3x3, a signed permutation) takes components along OpenCV's axes (x right,
y down, z forward) to those of another convention. It holds for every frame alike, the camera's, a
part's, an anchor's, so that a pose becomes B @ pose @ B^T and products still cancel. Mesh points
and anchors of annotations go through the same matrix. glTF files have glTF's own axes, which are
those of `openxr`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum


class Convention(StrEnum):
    """Axes and handedness that numbers are given in."""

    OPENCV = "opencv"
    OPENXR = "openxr"
    UNITY = "unity"
    ROS = "ros"
    ROS_OPTICAL = "ros_optical"


@dataclass(frozen=True)
class Axes:
    """How one convention's components follow from OpenCV's.

    Attributes:
        source: for each of its axes, the axis of OpenCV that it lies along (0, 1, 2).
        sign: and in which direction, 1 or -1.
    """

    source: tuple[int, int, int]
    sign: tuple[int, int, int]

    @property
    def matrix(self) -> list[list[int]]:
        """`convention_from_opencv`, 3x3, by rows."""
        return [
            [sign if column == source else 0 for column in range(3)]
            for source, sign in zip(self.source, self.sign, strict=True)
        ]

    @property
    def handedness(self) -> int:
        """The determinant: 1 for right-handed axes, -1 for left-handed ones."""
        is_even = self.source in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
        return (1 if is_even else -1) * self.sign[0] * self.sign[1] * self.sign[2]

    @property
    def inverse(self) -> Axes:
        """`opencv_from_convention`."""
        place = [self.source.index(axis) for axis in range(3)]
        return Axes(
            (place[0], place[1], place[2]),
            (self.sign[place[0]], self.sign[place[1]], self.sign[place[2]]),
        )

    def vector(self, values: Sequence[float]) -> list[float]:
        """A point, way or velocity (3,); zero has no sign."""
        return [
            sign * values[source] + 0.0 for source, sign in zip(self.source, self.sign, strict=True)
        ]

    def axial(self, values: Sequence[float]) -> list[float]:
        """A rotation vector or angular velocity (3,): a mirror turns its sense round."""
        turned = self.handedness
        return [turned * value + 0.0 for value in self.vector(values)]

    def quaternion(self, values: Sequence[float]) -> list[float]:
        """A rotation B @ R @ B^T, as unit quaternion x, y, z, w."""
        return [*self.axial(values[:3]), values[3]]

    def covariance(self, values: Sequence[float]) -> list[float]:
        """6x6, row-major, of the right perturbation in the body frame: rotation, translation."""
        turned = self.handedness
        source = (*self.source, *(3 + axis for axis in self.source))
        sign = (*(turned * each for each in self.sign), *self.sign)
        return [
            sign[row] * sign[column] * values[6 * source[row] + source[column]] + 0.0
            for row in range(6)
            for column in range(6)
        ]


AXES: dict[Convention, Axes] = {
    # x right, y down, z forward
    Convention.OPENCV: Axes((0, 1, 2), (1, 1, 1)),
    # x right, y up, z backward; also WebXR's, OpenGL's, ARKit's and glTF's
    Convention.OPENXR: Axes((0, 1, 2), (1, -1, -1)),
    # x right, y up, z forward: left-handed
    Convention.UNITY: Axes((0, 1, 2), (1, -1, 1)),
    # x forward, y left, z up (REP 103, body)
    Convention.ROS: Axes((2, 0, 1), (1, -1, -1)),
    # x right, y down, z forward (REP 103, suffix _optical): OpenCV's
    Convention.ROS_OPTICAL: Axes((0, 1, 2), (1, 1, 1)),
}
