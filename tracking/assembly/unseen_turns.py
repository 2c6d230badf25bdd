"""Takes turns that nobody can see out of the poses of parts: those about an axis of symmetry.

An estimate of a plain knob goes on turning about its axis while the knob lies still: there is
nothing in the image to hold it. Of all poses that look the same the one is told that is turned
least against the one before.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

from snapfit.models.joint import turns_about
from snapfit.models.pose import Pose, skew
from snapfit.models.symmetry import Symmetry, SymmetryAxis


class UnseenTurns:
    """Remembers how parts with an axis of symmetry were turned.

    Args:
        symmetries: by part.
    """

    def __init__(self, symmetries: Mapping[str, Symmetry]) -> None:
        self._axes = {name: each.axis for name, each in symmetries.items() if each.axis is not None}
        self._told: dict[str, Pose] = {}

    def taken_out(self, poses: Mapping[str, Pose], joined: Collection[str]) -> Mapping[str, Pose]:
        """Poses, of all that look the same, that are turned least.

        Args:
            poses: `camera_from_body` by part.
            joined: parts whose turn does count, because something is linked to them.
        """
        told = dict(poses)
        for name, axis in self._axes.items():
            if name in joined or name not in poses:
                continue
            before = self._told.get(name)
            if before is not None:
                told[name] = _turned_back(poses[name], before, axis)
            self._told[name] = told[name]
        return told

    def forget(self, names: Collection[str]) -> tuple[str, ...]:
        """Parts that are joined, or come off; returns those that are told by another pose now."""
        return tuple(name for name in names if self._told.pop(name, None) is not None)


def _turned_back(pose: Pose, before: Pose, axis: SymmetryAxis) -> Pose:
    """A pose turned about the body's axis until it is nearest to an earlier one."""
    matrix = pose.matrix
    rotation = matrix[:3, :3]
    turn = -float(turns_about(axis.direction, (before.matrix[:3, :3].T @ rotation)[None])[0])
    hat = skew(axis.direction)
    motion = np.eye(3) + math.sin(turn) * hat + (1 - math.cos(turn)) * (hat @ hat)
    turned = matrix.copy()
    turned[:3, :3] = rotation @ motion
    turned[:3, 3] += rotation @ (axis.point_m - motion @ axis.point_m)
    return Pose(turned)
