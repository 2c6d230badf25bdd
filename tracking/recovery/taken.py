"""Tells whether there is another part already where a part is said to be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from snapfit.models.pose import Array, Pose
from snapfit.tracking.body import Body

_POINTS, _FEW = 400, 60
_SAME_SURFACE, _TAKEN = 0.16, 0.7


class TakenPlaces:
    """Compares the surfaces of parts with each other.

    Args:
        bodies: all that are tracked.
    """

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._centers = [np.asarray(body.mesh.center_m, dtype=np.float64) for body in bodies]
        self._radii = [float(body.mesh.radius_m) for body in bodies]
        self._surfaces = [_surface(body) for body in bodies]

    def is_taken(self, body: int, pose: Pose, known: Mapping[int, Pose]) -> bool:
        """Whether a body would lie in another one: a twin of a part is not the part.

        Args:
            body: its index.
            pose: where it would be.
            known: where others are.
        """
        return any(
            self.lies_in(body, pose, other, other_pose)
            for other, other_pose in known.items()
            if other != body
        )

    def lies_in(self, body: int, pose: Pose, other: int, other_pose: Pose) -> bool:
        """Whether a body's surface lies in another one's; both may be the same body.

        Args:
            body, other: indices.
            pose, other_pose: where they are.
        """
        apart = self._center(body, pose) - self._center(other, other_pose)
        if np.linalg.norm(apart) > self._radii[other]:
            return False
        tolerance_m = max(_SAME_SURFACE * self._radii[body], 0.002)
        points = pose.transform(self._surfaces[body][:_FEW])
        theirs = other_pose.transform(self._surfaces[other])
        squares = ((points[:, None] - theirs[None]) ** 2).sum(axis=-1).min(axis=1)
        return bool((squares < tolerance_m**2).mean() > _TAKEN)

    def _center(self, body: int, pose: Pose) -> Array:
        center: Array = pose.transform(self._centers[body][None])[0]
        return center


def _surface(body: Body) -> Array:
    """(P, 3) points all over a body's surface, its frame, m."""
    views = body.views
    rng = np.random.default_rng(0)
    chosen = rng.integers(0, views.surface.shape[:2], size=(_POINTS, 2))
    points: Array = views.surface[chosen[:, 0], chosen[:, 1], :3].astype(np.float64) * views.unit_m
    return points
