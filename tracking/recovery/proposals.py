"""Poses to try out for a part that is looked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snapfit.models.pose import Array, Pose
from snapfit.tracking.body import Body
from snapfit.tracking.recovery.places import Place

_BACK, _FORESHORTENED = 0.4, 0.5
_TURNS_RAD, _HALF_TURNS = 1.2, 0.3
_CLIMB, _JITTER_RAD, _JITTER_M = 0.6, 0.12, 0.006


@dataclass(frozen=True, eq=False)
class Wanted:
    """A body that is looked for.

    Attributes:
        expected: `camera_from_body` where it was seen last, or was carried to.
        left: where it was seen last.
        unseen_frames: since it was seen.
        usual_confidence: of its pose, when all is well.
        proposed: poses to be tried out; far ones need clear evidence.
        is_searched: whether it is to be looked for beside them.
        is_doubted: whether it is seen where it is expected, but what is seen agrees badly.
    """

    expected: Pose
    left: Pose
    unseen_frames: int
    usual_confidence: float
    proposed: tuple[Pose, ...] = ()
    is_searched: bool = True
    is_doubted: bool = False

    @property
    def reach_m(self) -> float:
        """How far it may have gone: hands move parts by some 3 mm a frame, 10 mm at most."""
        return min(0.03 + 0.006 * self.unseen_frames, 0.25)

    @property
    def reach_rad(self) -> float:
        """How far it may have turned."""
        return min(0.35 + 0.05 * self.unseen_frames, np.pi)


class Proposer:
    """Draws poses at random, from what is known of a part.

    Args:
        bodies: all that are tracked.
        rng: source of the poses.
    """

    def __init__(self, bodies: Sequence[Body], rng: np.random.Generator) -> None:
        self._rng = rng
        self._centers = [np.asarray(body.mesh.center_m, dtype=np.float64) for body in bodies]
        self._long = [_longest(body) for body in bodies]

    def center(self, body: int, pose: Pose) -> Array:
        """(3,) the middle of a body at a pose, camera frame, m."""
        center: Array = pose.transform(self._centers[body][None])[0]
        return center

    def pose(
        self, body: int, wanted: Wanted, places: Sequence[Place], promising: Pose | None
    ) -> Pose:
        """A pose to start from: where it is expected, or at one of the places, turned or not.

        Args:
            body: its index.
            wanted: what is known of it.
            places: where its colours are seen.
            promising: the likeliest pose so far.
        """
        if promising is not None and self._rng.random() < _CLIMB:
            return self._jittered(promising, body)
        choice, pose = self._rng.random(), wanted.expected
        if self._rng.random() < _BACK:
            pose = wanted.left
        if not places or choice < 0.2:
            return pose if choice < 0.1 else self._turned(pose, body, wanted.reach_rad)
        place = places[int(self._rng.integers(len(places)))]
        if choice < 0.6:
            pose = self._aligned(pose, body, place)
        if choice > 0.4:
            pose = self._turned(pose, body, wanted.reach_rad)
        return Pose.from_translation(*(place.middle - self.center(body, pose))) @ pose

    def _jittered(self, pose: Pose, body: int) -> Pose:
        """Moved a little, as far as a refinement may come back from."""
        center = Pose.from_translation(*self._centers[body])
        twist = self._rng.standard_normal(6) * np.repeat((_JITTER_RAD, _JITTER_M), 3)
        return pose @ center @ Pose.exp(twist) @ center.inverse()

    def _aligned(self, pose: Pose, body: int, place: Place) -> Pose:
        """Turned about the line of sight until it is long where the place is long."""
        long = pose.rotation @ self._long[body]
        if np.hypot(long[0], long[1]) < _FORESHORTENED or place.direction_rad is None:
            return pose
        turn = place.direction_rad - float(np.arctan2(long[1], long[0]))
        turn = (turn + np.pi / 2) % np.pi - np.pi / 2
        center = Pose.from_translation(*self.center(body, pose))
        return center @ Pose.exp([0, 0, turn, 0, 0, 0]) @ center.inverse() @ pose

    def _turned(self, pose: Pose, body: int, reach_rad: float) -> Pose:
        """Turned about the body's middle: anyhow, or half way round about one of its axes."""
        direction = self._rng.standard_normal(3)
        angle = min(_TURNS_RAD, reach_rad) * float(np.sqrt(self._rng.random()))
        if self._rng.random() < _HALF_TURNS:
            direction, angle = np.eye(3)[self._rng.integers(3)], np.pi
        turn = Pose.exp([*(angle * direction / np.linalg.norm(direction)), 0, 0, 0])
        center = Pose.from_translation(*self._centers[body])
        return pose @ center @ turn @ center.inverse()


def _longest(body: Body) -> Array:
    """(3,) direction in which a body is longest, its frame."""
    points = np.asarray(body.mesh.vertices, dtype=np.float64)
    _, vectors = np.linalg.eigh(np.cov(points.T))
    longest: Array = vectors[:, -1]
    return longest
