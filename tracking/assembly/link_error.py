"""How far a measured relative pose is from a link.

The joint's own free motion and the symmetries of both parts are taken out. Without them and with
the joint at zero this is the e_trans and e_rot by which the GBOT paper judges a step (section 3.3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snapfit.models.joint import JointMotion, angles, rotations_about, turns_about
from snapfit.models.manifest import JointType, Link
from snapfit.models.pose import Array, Pose
from snapfit.models.symmetry import NO_SYMMETRY, Symmetry, SymmetryAxis

# Turns about two axes that are not the same are found one after the other, so often.
_ALTERNATIONS = 4
_SAME_LINE = 1e-3


@dataclass(frozen=True, eq=False)
class LinkFit:
    """A relative pose measured against a link.

    Attributes:
        link: the link.
        translation_m: distance of the child's origin from where the joint would have it.
        rotation_rad: angle to the rotation that the joint would give it.
        q: (n_dof,) coordinates of the joint that come nearest.
        parent_symmetry: `body_from_body` of the parent: `camera_from_parent @ parent_symmetry` is
            the pose of the parent, of all that look the same, for which the above holds.
        child_symmetry: the same of the child.
    """

    link: Link
    translation_m: float
    rotation_rad: float
    q: Array
    parent_symmetry: Pose
    child_symmetry: Pose

    @property
    def is_within_tolerance(self) -> bool:
        """Whether the manifest counts the link as made."""
        tolerance_rad = np.radians(self.link.rotation_tolerance_deg)
        near = self.translation_m < self.link.translation_tolerance_m
        return near and bool(self.rotation_rad < tolerance_rad)

    def is_within(self, translation_m: float, rotation_rad: float) -> bool:
        """Whether both errors are below limits."""
        return self.translation_m < translation_m and self.rotation_rad < rotation_rad


class LinkMeasure:
    """Measures relative poses against one link.

    Args:
        link: of the manifest.
        child: symmetry of the child; `NO_SYMMETRY` where its links to others fix its pose.
        parent: symmetry of the parent, likewise.
    """

    def __init__(self, link: Link, child: Symmetry, parent: Symmetry = NO_SYMMETRY) -> None:
        self.link = link
        self.joint = JointMotion.of(link)
        self.goal = link.parent_from_child
        motions = (Pose.identity(), *child.motions)
        parent_motions = (Pose.identity(), *parent.motions)
        zero_from_parent = self.goal.inverse()
        lefts = [(zero_from_parent @ each.inverse()).matrix for each in parent_motions]
        self._lefts = np.repeat(np.stack(lefts), len(motions), axis=0)
        self._rights = np.tile(np.stack([m.matrix for m in motions]), (len(lefts), 1, 1))
        self._motions = [(p, c) for p in parent_motions for c in motions]
        self._parent_axis, self._child_axis = parent.axis, child.axis
        self._zero_axis = (
            None if parent.axis is None else _moved_axis(zero_from_parent, parent.axis)
        )
        own_axes = [axis for axis in (self._child_axis, self._zero_axis) if axis is not None]
        self._turn_seen = not any(_is_joint_axis(axis, self.joint) for axis in own_axes)
        is_turned = self.joint.type.turns and self._turn_seen
        self._n_rounds = _ALTERNATIONS if is_turned and own_axes else 1
        # What a radian weighs beside a metre when the best of the symmetric poses is chosen.
        tolerance_rad = np.radians(link.rotation_tolerance_deg)
        self._lever_m = float(link.translation_tolerance_m / tolerance_rad)
        self._reach_m = self._farthest_m(child, parent)

    @property
    def is_slow(self) -> bool:
        """Whether only its travel tells how far a screw is turned in."""
        return self.joint.type is JointType.SCREW and not self._turn_seen

    def is_far(self, parent_from_child: Array, margin_m: float) -> bool:
        """Whether a relative pose (4, 4) is surely farther away than a margin; quick."""
        x, y, z = parent_from_child[:3, 3] - self.goal.matrix[:3, 3]
        return bool(x * x + y * y + z * z > (self._reach_m + margin_m) ** 2)

    def fit(self, parent_from_child: Array) -> LinkFit:
        """The error of a relative pose (4, 4), the joint's free motion taken out."""
        return self._best(self._lefts @ parent_from_child @ self._rights, free=True)

    def fit_at_zero(self, parent_from_child: Array) -> LinkFit:
        """The error of a relative pose (4, 4) against the joint at zero."""
        return self._best(self._lefts @ parent_from_child @ self._rights, free=False)

    def _best(self, zero_from_child: Array, free: bool) -> LinkFit:
        """Of the (K, 4, 4) poses that look the same, that which fits best."""
        joint = self.joint
        q = np.zeros((len(zero_from_child), joint.n_dof))
        parent_turn = child_turn = np.zeros(len(zero_from_child))
        turns_freely = free and joint.type.turns
        for _ in range(self._n_rounds if turns_freely else 1):
            if turns_freely:
                q = joint.coordinates(zero_from_child, self._turn_seen)
            rotation, _shift = joint.moved(q)
            zero_from_child, *turns = self._turned(zero_from_child, rotation)
            parent_turn, child_turn = parent_turn + turns[0], child_turn + turns[1]
        if free and not turns_freely:
            q = joint.coordinates(zero_from_child)
        rotation, translation = joint.moved(q)
        apart = zero_from_child[:, :3, 3] - translation
        translation_m = np.sqrt((apart * apart).sum(axis=1))
        rotation_rad = angles(np.swapaxes(rotation, 1, 2) @ zero_from_child[:, :3, :3])
        best = int((translation_m**2 + (self._lever_m * rotation_rad) ** 2).argmin())
        parent_symmetry, child_symmetry = self._motions[best]
        if self._parent_axis is not None:
            parent_symmetry = parent_symmetry @ self._parent_axis.turn(float(parent_turn[best]))
        if self._child_axis is not None:
            child_symmetry = child_symmetry @ self._child_axis.turn(float(child_turn[best]))
        errors = float(translation_m[best]), float(rotation_rad[best])
        return LinkFit(self.link, *errors, q[best], parent_symmetry, child_symmetry)

    def _turned(self, zero_from_child: Array, rotation: Array) -> tuple[Array, Array, Array]:
        """Turned about the axes of symmetry until nearest to the joint's rotations (K, 3, 3).

        Returns:
            (turned poses (K, 4, 4), turns of the parent (K,), turns of the child (K,), rad).
        """
        parent_turn = child_turn = np.zeros(len(zero_from_child))
        if self._zero_axis is not None:
            excess = zero_from_child[:, :3, :3] @ np.swapaxes(rotation, 1, 2)
            parent_turn = turns_about(self._zero_axis.direction, excess)
            zero_from_child = _turns(self._zero_axis, -parent_turn) @ zero_from_child
        if self._child_axis is not None:
            excess = np.swapaxes(rotation, 1, 2) @ zero_from_child[:, :3, :3]
            child_turn = -turns_about(self._child_axis.direction, excess)
            zero_from_child = zero_from_child @ _turns(self._child_axis, child_turn)
        return zero_from_child, parent_turn, child_turn

    def _farthest_m(self, child: Symmetry, parent: Symmetry) -> float:
        """How far from its place the child's origin may be while it fulfils the link."""
        reach = 0.0
        if self.joint.type.slides:
            travel = self.joint.limits[-1]
            if self.joint.type is JointType.SCREW:
                travel = travel * self.joint.pitch_m / (2 * np.pi)
            reach += float(np.abs(travel).max())
        if self.joint.type.turns:
            reach += 2 * float(np.linalg.norm(np.cross(self.joint.axis, self.joint.point_m)))
        origin, place = np.zeros(3), self.goal.translation
        for symmetry, point in ((child, origin), (parent, place)):
            moved = [each.transform(point) - point for each in symmetry.motions]
            reach += max((float(np.linalg.norm(each)) for each in moved), default=0.0)
            if symmetry.axis is not None:
                arm = np.cross(symmetry.axis.direction, point - symmetry.axis.point_m)
                reach += 2 * float(np.linalg.norm(arm))
        return reach


def _turns(axis: SymmetryAxis, turn: Array) -> Array:
    """(K, 4, 4) turns (K,), rad, about an axis."""
    motion = np.zeros((len(turn), 4, 4))
    motion[:, :3, :3] = rotation = rotations_about(axis.direction, turn)
    motion[:, :3, 3] = axis.point_m - rotation @ axis.point_m
    motion[:, 3, 3] = 1
    return motion


def _moved_axis(pose: Pose, axis: SymmetryAxis) -> SymmetryAxis:
    return SymmetryAxis(pose.rotation @ axis.direction, pose.transform(axis.point_m))


def _is_joint_axis(axis: SymmetryAxis, joint: JointMotion) -> bool:
    """Whether a turn about an axis of symmetry is the joint's own turn."""
    if not joint.type.turns:
        return False
    aside = np.linalg.norm(np.cross(axis.direction, joint.axis))
    offset = np.linalg.norm(np.cross(joint.axis, axis.point_m - joint.point_m))
    return bool(aside < _SAME_LINE and offset < _SAME_LINE)
