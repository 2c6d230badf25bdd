"""A rigid motion as the API writes it: a position and a unit quaternion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from snapfit.server import quaternion
from snapfit.server.conventions import Axes


class Rigid(NamedTuple):
    """`a_from_b`: maps points of frame b into frame a.

    Attributes:
        position: of b's origin in a, (3,), metres.
        orientation: unit quaternion x, y, z, w.
    """

    position: Sequence[float]
    orientation: Sequence[float]

    def __matmul__(self, other: Rigid) -> Rigid:
        return Rigid(
            self.transform(other.position),
            quaternion.normalised(quaternion.multiply(self.orientation, other.orientation)),
        )

    def transform(self, point: Sequence[float]) -> list[float]:
        """A point (3,) of frame b, metres, in frame a."""
        turned = quaternion.rotate(self.orientation, point)
        return [each + way for each, way in zip(turned, self.position, strict=True)]

    def inverse(self) -> Rigid:
        """`b_from_a`."""
        back = quaternion.inverse(self.orientation)
        return Rigid([-each for each in quaternion.rotate(back, self.position)], back)

    def along(self, axes: Axes) -> Rigid:
        """The same motion in another convention's components."""
        return Rigid(axes.vector(self.position), axes.quaternion(self.orientation))
