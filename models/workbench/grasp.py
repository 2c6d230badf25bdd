"""Where the hand is at each moment: on the part that moves, before it, or on its way to the next.

World frame as in `script`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose
from snapfit.models.workbench.hand import Body, Person, hand_bodies
from snapfit.models.workbench.motion import minimum_jerk
from snapfit.models.workbench.script import Move, Script

_AWAY_M = np.array([0.24, -0.50, 0.10])
_ENTER_S = 0.45
_RAMP_S, _COVER_S = 0.22, (0.62, 0.74)
# Seconds of holding for each time that the hand comes before a part.
_COVER_EVERY_S = 4.0
# A part with less reach than this is held with the fingertips, this much further out.
_SMALL_M, _PINCH_M = 0.080, 0.055
_CURL_OPEN, _CURL_CLOSED = 0.28, 0.62
_FOLLOW, _MOST_FOLLOW_RAD = 0.35, 0.5


@dataclass(frozen=True, eq=False)
class Grasp:
    """One time that the hand holds a part.

    Attributes:
        part: its name.
        start_s: when the hand is there.
        end_s: when it lets go.
        shoulder_m: (3,) where the arm comes from.
        side_m: (3,) from the part's middle to where the palm's middle is, beside the line of sight.
        covers_s: from when to when the hand is before the part; may be empty.
    """

    part: str
    start_s: float
    end_s: float
    shoulder_m: Array
    side_m: Array
    covers_s: tuple[tuple[float, float], ...]


class HandScript:
    """A hand that does what a script says.

    Args:
        script: who moves when.
        meshes: by part.
        eye_m: (3,) where the camera is, world frame.
        rng: of the person and the grips.
        hidden: parts that the hand comes before now and then; None is all.
    """

    def __init__(
        self,
        script: Script,
        meshes: Mapping[str, Mesh],
        eye_m: Array,
        rng: np.random.Generator,
        hidden: Collection[str] | None = None,
    ) -> None:
        self._script = script
        self._eye_m = eye_m
        self._person = Person.sampled(rng)
        self._middles, self._points = {}, {}
        for name, mesh in meshes.items():
            low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
            self._middles[name] = ((low + high) / 2).astype(np.float64)
            stride = max(len(mesh.vertices) // 300, 1)
            self._points[name] = mesh.vertices[::stride].astype(np.float64)
        self.grasps, owed = [], 0.75
        for group in _groups(script):
            if hidden is None or group[0].part in hidden:
                owed += (group[-1].end_s - group[0].start_s) / _COVER_EVERY_S
            self.grasps.append(_grasp(group, int(owed), rng))
            owed -= int(owed)

    def bodies_at(self, time_s: float) -> list[Body]:
        """The hand's bodies; they may be out of view."""
        pose, curl = self._posture(time_s)
        near = min(self.grasps, key=lambda each: max(each.start_s - time_s, time_s - each.end_s))
        return hand_bodies(pose, curl, self._person, near.shoulder_m)

    def _posture(self, time_s: float) -> tuple[Pose, float]:
        for grasp in self.grasps:
            if grasp.start_s <= time_s <= grasp.end_s:
                return self._holding(grasp, time_s), _CURL_CLOSED
        before = [grasp for grasp in self.grasps if grasp.end_s < time_s]
        after = [grasp for grasp in self.grasps if grasp.start_s > time_s]
        left = self._holding(before[-1], before[-1].end_s) if before else None
        right = self._holding(after[0], after[0].start_s) if after else None
        start_s = before[-1].end_s if before else after[0].start_s - _ENTER_S
        end_s = after[0].start_s if after else start_s + _ENTER_S
        away = _moved((left or right or Pose.identity()), _AWAY_M)
        share = minimum_jerk((time_s - start_s) / max(end_s - start_s, 1e-3))
        pose = _between(left or away, right or away, share)
        back = (_AWAY_M - pose.translation) * 0.35 * math.sin(math.pi * share)
        back[2] += 0.03 * math.sin(math.pi * share)
        opened = math.sin(math.pi * share)
        return (
            _moved(pose, pose.translation + back),
            _CURL_CLOSED + (_CURL_OPEN - _CURL_CLOSED) * opened,
        )

    def _holding(self, grasp: Grasp, time_s: float) -> Pose:
        world_from_part = self._script.poses_at(time_s)[grasp.part]
        middle = world_from_part.transform(self._middles[grasp.part][None])[0]
        points = world_from_part.transform(self._points[grasp.part]) - middle
        to_eye = _unit(self._eye_m - middle)
        forward = _unit(middle - grasp.shoulder_m)
        begun = self._script.poses_at(grasp.start_s)[grasp.part]
        turned = _clipped_turn(begun, world_from_part)
        beside = self._beside(grasp, middle, points, forward)
        beside = _moved(
            Pose.from_rotation_translation(turned @ beside.rotation, (0, 0, 0)), beside.translation
        )
        return _between(
            beside, self._before(middle, points, forward, to_eye), _cover_share(grasp, time_s)
        )

    def _beside(self, grasp: Grasp, middle: Array, points: Array, forward: Array) -> Pose:
        """Palm down on the part's near side, fingers over it."""
        side = _unit(grasp.side_m)
        reach = float((points @ side).max())
        up = np.array([0.0, 0.0, 1.0])
        dorsal = _unit(0.8 * up + 0.75 * side)
        radius = float(np.linalg.norm(points, axis=1).max())
        pinch_m = _PINCH_M * min(max(1 - radius / _SMALL_M, 0.0), 1.0)
        place = middle + side * (0.55 * reach + 0.6 * pinch_m)
        place = place + dorsal * 0.030 - (0.062 + pinch_m) * forward
        return Pose.from_rotation_translation(_frame(forward, dorsal), place)

    def _before(self, middle: Array, points: Array, forward: Array, to_eye: Array) -> Pose:
        """Between the part and the camera, its back to the camera."""
        depth = min(float((points @ to_eye).max()), 0.05)
        along = _long_axis(points - np.outer(points @ to_eye, to_eye))
        along = along if along @ forward > 0 else -along
        rotation = _frame(forward + 1.6 * along, to_eye + np.array([0, 0, 0.25]))
        spread = points @ rotation
        # The middle of palm and bent fingers comes before the middle of the part.
        center = (spread.max(axis=0) + spread.min(axis=0)) / 2
        place = middle + to_eye * (depth + 0.030) + rotation[:, 1] * center[1]
        place = place + rotation[:, 0] * (center[0] - 0.022)
        return Pose.from_rotation_translation(rotation, place)


def _groups(script: Script) -> list[list[Move]]:
    """Moves of one part without a pause between them."""
    groups: list[list[Move]] = []
    for move in script.moves:
        last = groups[-1][-1] if groups else None
        if last and last.part == move.part and move.start_s - last.end_s < 0.05:
            groups[-1].append(move)
        else:
            groups.append([move])
    return groups


def _grasp(group: list[Move], n_covers: int, rng: np.random.Generator) -> Grasp:
    start_s, end_s = group[0].start_s, group[-1].end_s
    duration_s = end_s - start_s
    shoulder = np.array([rng.uniform(0.10, 0.45), -0.70, rng.uniform(0.08, 0.16)])
    side = np.array([rng.uniform(0.4, 1.0), rng.uniform(-0.6, 0.3), 0.25])
    covers = []
    for i in range(n_covers):
        half_s = rng.uniform(*_COVER_S) / 2
        middle_s = start_s + duration_s * (i + rng.uniform(0.45, 0.6)) / n_covers
        covers.append((middle_s - half_s, middle_s + half_s))
    return Grasp(group[0].part, start_s, end_s, shoulder, side, tuple(covers))


def _cover_share(grasp: Grasp, time_s: float) -> float:
    """0 where the hand is beside the part, 1 where it is before it."""
    shares = [0.0]
    for start_s, end_s in grasp.covers_s:
        rising = (time_s - start_s) / _RAMP_S + 0.5
        falling = (end_s - time_s) / _RAMP_S + 0.5
        shares.append(minimum_jerk(rising) * minimum_jerk(falling))
    return max(shares)


def _clipped_turn(begun: Pose, now: Pose) -> Array:
    """(3, 3) the share of a part's turn that the wrist follows."""
    between = Pose.from_rotation_translation(now.rotation @ begun.rotation.T, (0, 0, 0))
    turn = between.log()[:3] * _FOLLOW
    angle = float(np.linalg.norm(turn))
    if angle > _MOST_FOLLOW_RAD:
        turn = turn * (_MOST_FOLLOW_RAD / angle)
    return Pose.exp([*turn, 0, 0, 0]).rotation


def _between(a: Pose, b: Pose, share: float) -> Pose:
    turn = (a.inverse() @ b).log()[:3] * share
    rotation = a.rotation @ Pose.exp([*turn, 0, 0, 0]).rotation
    place = a.translation + share * (b.translation - a.translation)
    return Pose.from_rotation_translation(rotation, place)


def _long_axis(points: Array) -> Array:
    """(3,) the direction in which points (N, 3) spread most, times how much more than across."""
    _, spreads, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    longer: Array = axes[0] * min(max(1 - float(spreads[1] / spreads[0]), 0.0), 1.0)
    return longer


def _moved(pose: Pose, place: Array) -> Pose:
    return Pose.from_rotation_translation(pose.rotation, place)


def _frame(x: Array, z: Array) -> Array:
    """(3, 3) rotation whose x is as near as can be to a direction, its z that given."""
    z = _unit(z)
    x = _unit(x - (x @ z) * z)
    return np.column_stack([x, np.cross(z, x), z])


def _unit(vector: Array) -> Array:
    unit: Array = vector / max(float(np.linalg.norm(vector)), 1e-9)
    return unit
