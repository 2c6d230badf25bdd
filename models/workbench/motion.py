"""Hand-like motion of a part: carried along an arc, slid along a line, turned in as a screw.

A motion maps a share of its duration (0 to 1) to `world_from_part`. It starts and ends at rest with
the minimum-jerk profile of human arm movements (Flash and Hogan, 1985).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from snapfit.models.pose import Array, Pose

_TREMOR_TRANSLATION_M = 0.00025
_TREMOR_ROTATION_RAD = 0.002
_TREMOR_WAVES = 4


class Motion(Protocol):
    """A way from one place to another."""

    def at(self, share: float) -> Pose:
        """`world_from_part` after a share of the duration, 0 to 1."""


def minimum_jerk(share: float) -> float:
    """Progress 0 to 1 after a share of the duration (Flash and Hogan, 1985)."""
    u = min(max(share, 0.0), 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


@dataclass(frozen=True, eq=False)
class Tremor:
    """A hand's small involuntary motion: a few sines on each of six axes.

    Attributes:
        waves: (waves, 6, 3) amplitude (rad or m), cycles in the motion, phase (rad).
    """

    waves: Array

    @staticmethod
    def sampled(rng: np.random.Generator, duration_s: float) -> Tremor:
        """Waves of 2 to 7 Hz."""
        waves = np.empty((_TREMOR_WAVES, 6, 3))
        scale = np.repeat([_TREMOR_ROTATION_RAD, _TREMOR_TRANSLATION_M], 3)
        waves[..., 0] = rng.uniform(0.3, 1.0, (_TREMOR_WAVES, 6)) * scale
        waves[..., 1] = rng.uniform(2.0, 7.0, (_TREMOR_WAVES, 6)) * duration_s
        waves[..., 2] = rng.uniform(0, 2 * math.pi, (_TREMOR_WAVES, 6))
        return Tremor(waves)

    def at(self, share: float) -> Array:
        """(6,) variation of the body, rotation (rad) and translation (m)."""
        amplitude, cycles, phase = np.moveaxis(self.waves, -1, 0)
        total: Array = (amplitude * np.sin(2 * math.pi * cycles * share + phase)).sum(axis=0)
        return total


@dataclass(frozen=True, eq=False)
class Slide:
    """Pushed along a line.

    Attributes:
        start: `world_from_part`.
        goal: `world_from_part`, with the rotation of the start.
    """

    start: Pose
    goal: Pose

    def at(self, share: float) -> Pose:
        """`world_from_part` after a share of the duration, 0 to 1."""
        way = self.goal.translation - self.start.translation
        position = self.start.translation + minimum_jerk(share) * way
        return Pose.from_rotation_translation(self.start.rotation, position)


@dataclass(frozen=True, eq=False)
class Twist:
    """Screwed in with a few twists of the wrist; between them the hand takes a new hold.

    Attributes:
        goal: `world_from_part` at the end.
        axis: (3,) unit, part's frame; a positive turn drives the screw on.
        turn_rad: whole turn.
        pitch_m: advance of one turn.
        n_twists: how often the hand takes hold.
        hold_share: share of a twist's duration in which the hand only changes its hold.
        point_m: (3,) a point on the axis, part's frame.
    """

    goal: Pose
    axis: Array
    turn_rad: float
    pitch_m: float
    n_twists: int
    hold_share: float = 0.18
    point_m: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def at(self, share: float) -> Pose:
        """`world_from_part` after a share of the duration, 0 to 1."""
        # The last twist needs no new hold after it, so that the motion ends with it.
        period = 1 / (self.n_twists - self.hold_share)
        done = min(int(share / period), self.n_twists - 1)
        within = minimum_jerk((share / period - done) / (1 - self.hold_share))
        missing = self.turn_rad * (1 - (done + within) / self.n_twists)
        advance = self.pitch_m * missing / (2 * math.pi)
        back = Pose.exp([*(-missing * self.axis), *(-advance * self.axis)])
        to_axis = Pose.from_translation(*self.point_m)
        return self.goal @ to_axis @ back @ to_axis.inverse()


@dataclass(frozen=True, eq=False)
class Swing:
    """Moved freely in the air along a Bezier curve while it turns.

    Attributes:
        start: `world_from_part`.
        goal: `world_from_part`.
        leave_m: (3,) from the start to the curve's second control point, world frame.
        arrive_m: (3,) from the goal back to the curve's third control point, world frame.
        tremor: of the hand; fades towards both ends.
    """

    start: Pose
    goal: Pose
    leave_m: Array
    arrive_m: Array
    tremor: Tremor

    @cached_property
    def curve(self) -> tuple[Array, Array]:
        """Lengths (N,), m, along the curve and its points (N, 3), world frame."""
        a, d = self.start.translation, self.goal.translation
        controls = np.stack([a, a + self.leave_m, d + self.arrive_m, d])
        t = np.linspace(0, 1, 65)[:, None]
        bernstein = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
        points = bernstein @ controls
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        return np.concatenate([[0], np.cumsum(steps)]), points

    def at(self, share: float) -> Pose:
        """`world_from_part` after a share of the duration, 0 to 1."""
        lengths, points = self.curve
        done = minimum_jerk(share)
        position = [np.interp(done * lengths[-1], lengths, points[:, k]) for k in range(3)]
        turn = (self.start.inverse() @ self.goal).log()[:3]
        rotation = self.start.rotation @ Pose.exp([*(done * turn), 0, 0, 0]).rotation
        pose = Pose.from_rotation_translation(rotation, position)
        return pose.perturbed(math.sin(math.pi * min(max(share, 0), 1)) * self.tremor.at(share))
