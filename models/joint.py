"""The motion that a link leaves its child: none, a turn, a travel, or both.

A joint stands at its zero where the child is at the link's `parent_from_child`. Its coordinates are
turns (rad) and travels (m) along twists of the child's frame, as in Stoiber et al., "Mb-ICG"
(2022): `parent_from_child(q) = parent_from_child @ exp(twists.T @ q)`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from snapfit.models.errors import PoseError
from snapfit.models.manifest import Joint, JointType, Link
from snapfit.models.pose import Array, Pose, skew

# How much a turn weighs beside a travel where both tell of one coordinate (a screw): what a point
# at this distance from the axis moves.
_LEVER_M = 0.03
_WHOLE_TURN_RAD = 2 * math.pi


class JointResidual(NamedTuple):
    """What remains of a relative pose when the joint has moved as near to it as it can.

    Attributes:
        translation_m: distance of the child's origin from where the joint would have it.
        rotation_rad: angle to the rotation that the joint would give it.
    """

    translation_m: float
    rotation_rad: float


@dataclass(frozen=True, eq=False)
class JointMotion:
    """A link's joint, ready to compute with.

    Attributes:
        type: kind of joint.
        zero: `parent_from_child` with all coordinates zero.
        axis: (3,) float64, unit, child's frame; zeros for a fixed joint.
        point_m: (3,) float64, a point on the axis, child's frame.
        pitch_m: travel of a whole turn of a screw; zero for other joints.
        twists: (n_dof, 6) float64, right perturbations of the child in its own frame, rotation
            then translation, for a unit of each coordinate. A screw has its turn as coordinate, a
            cylindrical joint turn and travel in this order.
        limits: (n_dof, 2) float64, least and largest coordinate, rad or m; infinite where free.
    """

    type: JointType
    zero: Pose
    axis: Array
    point_m: Array
    pitch_m: float
    twists: Array
    limits: Array

    @staticmethod
    def of(link: Link) -> JointMotion:
        """The joint of a link of the manifest.

        Raises:
            PoseError: a screw whose limits of turn and travel exclude each other.
        """
        joint = link.joint
        axis = np.array(joint.axis or (0, 0, 0), dtype=np.float64)
        axis /= max(float(np.linalg.norm(axis)), 1e-12)
        point_m = np.array(joint.point_m, dtype=np.float64)
        pitch_m = joint.pitch_m or 0.0
        turning = np.concatenate([axis, -np.cross(axis, point_m)])
        sliding = np.concatenate([np.zeros(3), axis])
        match joint.type:
            case JointType.FIXED:
                twists = np.zeros((0, 6))
            case JointType.REVOLUTE:
                twists = turning[None]
            case JointType.PRISMATIC:
                twists = sliding[None]
            case JointType.CYLINDRICAL:
                twists = np.stack([turning, sliding])
            case JointType.SCREW:
                twists = (turning + pitch_m / _WHOLE_TURN_RAD * sliding)[None]
        limits = _limits(joint)
        if (limits[:, 0] > limits[:, 1]).any():
            ends = f"the joint of {link.child!r} on {link.parent!r}"
            raise PoseError(f"{ends}: turn_deg and travel_m exclude each other at this pitch_m")
        zero = link.parent_from_child
        return JointMotion(joint.type, zero, axis, point_m, pitch_m, twists, limits)

    @property
    def n_dof(self) -> int:
        """How many coordinates the joint has."""
        return len(self.twists)

    def parent_from_child(self, q: Array) -> Pose:
        """Where the child stands at the coordinates q (n_dof,); not clipped to the limits."""
        return self.zero @ Pose.exp(self.twists.T @ np.asarray(q, dtype=np.float64))

    def closest(self, parent_from_child: Pose) -> tuple[Array, JointResidual]:
        """The coordinates within the limits that come nearest to a measured relative pose.

        Returns:
            (q (n_dof,), what remains).
        """
        zero_from_child = self.zero.inverse().matrix @ parent_from_child.matrix
        q, translation_m, rotation_rad = self.closest_of(zero_from_child[None])
        return q[0], JointResidual(float(translation_m[0]), float(rotation_rad[0]))

    def closest_of(self, zero_from_child: Array) -> tuple[Array, Array, Array]:
        """As `closest` for many poses at once.

        Args:
            zero_from_child: (K, 4, 4) `zero.inverse() @ parent_from_child`.

        Returns:
            (q (K, n_dof), translation_m (K,), rotation_rad (K,)).
        """
        q = self.coordinates(zero_from_child)
        joint_rotation, joint_translation = self.moved(q)
        apart = zero_from_child[:, :3, 3] - joint_translation
        translation_m = np.sqrt((apart * apart).sum(axis=1))
        remaining = np.swapaxes(joint_rotation, 1, 2) @ zero_from_child[:, :3, :3]
        return q, translation_m, angles(remaining)

    def coordinates(self, zero_from_child: Array, turn_seen: bool = True) -> Array:
        """(K, n_dof) coordinates within the limits that come nearest to poses (K, 4, 4).

        A turn comes from the rotation, a travel from the way, a screw's turn from both.

        Args:
            zero_from_child: `zero.inverse() @ parent_from_child`.
            turn_seen: False for a body whose turn about the joint's axis cannot be seen, because it
                is symmetric about it: a screw is then known by its travel alone, and other turns
                count as zero.
        """
        rotation = zero_from_child[:, :3, :3]
        travel = zero_from_child[:, :3, 3] @ self.axis
        if self.type is JointType.FIXED:
            return np.zeros((len(rotation), 0))
        if self.type is JointType.PRISMATIC:
            return _within(travel, self.limits[0])[:, None]
        turn = turns_about(self.axis, rotation) if turn_seen else np.zeros(len(rotation))
        if self.type is JointType.SCREW:
            if not turn_seen:
                travelled = travel * _WHOLE_TURN_RAD / self.pitch_m
                return _within(travelled, self.limits[0])[:, None]
            return self._screwed(turn, travel)[:, None]
        turn = _clip_turn(turn, self.limits[0])
        if self.type is JointType.REVOLUTE:
            return turn[:, None]
        return np.stack([turn, _within(travel, self.limits[1])], axis=1)

    def moved(self, q: Array) -> tuple[Array, Array]:
        """How the joint moves the child from its zero, at coordinates (K, n_dof).

        Returns:
            (rotations (K, 3, 3), translations (K, 3), m).
        """
        if self.type is JointType.FIXED:
            return np.broadcast_to(np.eye(3), (len(q), 3, 3)), np.zeros((len(q), 3))
        if self.type is JointType.PRISMATIC:
            return np.broadcast_to(np.eye(3), (len(q), 3, 3)), q * self.axis
        rotation = rotations_about(self.axis, q[:, 0])
        translation = self.point_m - rotation @ self.point_m
        if self.type is JointType.SCREW:
            translation = translation + q * self.pitch_m / _WHOLE_TURN_RAD * self.axis
        if self.type is JointType.CYLINDRICAL:
            translation = translation + q[:, 1:] * self.axis
        return rotation, translation

    def _screwed(self, turn: Array, travel: Array) -> Array:
        """The turn (K,) of a screw that fits both its turn, known up to whole ones, and travel."""
        advance_m = self.pitch_m / _WHOLE_TURN_RAD
        n_whole = np.round((travel / advance_m - turn) / _WHOLE_TURN_RAD)
        turns = turn[:, None] + _WHOLE_TURN_RAD * (n_whole[:, None] + (-1, 0, 1))
        weight = _LEVER_M**2
        fits = (weight * turns + advance_m * travel[:, None]) / (weight + advance_m**2)
        fits = np.clip(fits, *self.limits[0])
        costs = weight * (turns - fits) ** 2 + (travel[:, None] - advance_m * fits) ** 2
        best: Array = fits[np.arange(len(fits)), costs.argmin(axis=1)]
        return best


def turns_about(axis: Array, rotation: Array) -> Array:
    """The turns (K,) about a unit axis (3,) that come nearest to rotations (K, 3, 3), rad.

    The trace of R_a(t)^T R is a^T R a + cos t (tr R - a^T R a) + sin t (a . v) with v the vector
    of the skew part of R; its largest value has the smallest angle.
    """
    along = (rotation @ axis) @ axis
    trace = rotation[:, 0, 0] + rotation[:, 1, 1] + rotation[:, 2, 2]
    turn: Array = np.arctan2(_skew_part(rotation) @ axis, trace - along)
    return turn


def rotations_about(axis: Array, turn: Array) -> Array:
    """Rotations (K, 3, 3) by turns (K,), rad, about a unit axis (3,); Rodrigues' formula."""
    hat = skew(axis)
    sine, versine = np.sin(turn)[:, None, None], (1 - np.cos(turn))[:, None, None]
    rotation: Array = np.eye(3) + sine * hat + versine * (hat @ hat)
    return rotation


def angles(rotation: Array) -> Array:
    """Angles (K,) of rotations (K, 3, 3), rad; exact near zero and near a half turn."""
    vector = _skew_part(rotation)
    trace = rotation[:, 0, 0] + rotation[:, 1, 1] + rotation[:, 2, 2]
    angle: Array = np.arctan2(np.sqrt((vector * vector).sum(axis=1)), trace - 1)
    return angle


def _within(values: Array, limits: Array) -> Array:
    clipped: Array = np.clip(values, limits[0], limits[1])
    return clipped


def _skew_part(rotation: Array) -> Array:
    """(K, 3) vectors 2 sin(angle) axis of rotations (K, 3, 3)."""
    r = rotation
    return np.stack(
        [r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1
    )


def _clip_turn(turn: Array, limits: Array) -> Array:
    """Turns (K,), known up to whole ones, brought within limits (2,), or to the nearer of both."""
    if not np.isfinite(limits).all():
        return _within(turn, limits)
    n_whole = np.round((limits.mean() - turn) / _WHOLE_TURN_RAD)
    turns = turn[:, None] + _WHOLE_TURN_RAD * (n_whole[:, None] + (0, -1, 1))
    clipped = np.clip(turns, *limits)
    best: Array = clipped[np.arange(len(turns)), np.abs(clipped - turns).argmin(axis=1)]
    return best


def _limits(joint: Joint) -> Array:
    """(n_dof, 2) limits of the coordinates."""
    free = (-math.inf, math.inf)
    turn = np.radians(joint.turn_deg or free)
    travel = np.array(joint.travel_m or free)
    match joint.type:
        case JointType.FIXED:
            return np.zeros((0, 2))
        case JointType.REVOLUTE:
            return turn[None]
        case JointType.PRISMATIC:
            return travel[None]
        case JointType.CYLINDRICAL:
            return np.stack([turn, travel])
        case JointType.SCREW:
            as_turn = np.sort(travel / (joint.pitch_m or math.nan) * _WHOLE_TURN_RAD)
            return np.array([[max(turn[0], as_turn[0]), min(turn[1], as_turn[1])]])
