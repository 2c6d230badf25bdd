"""Symmetries of a body: the motions that map it onto itself, and errors judged without them.

The meaning is that of BOP's `models_info.json`: a list of discrete motions, and an axis about
which any angle leaves the body as it is. Both may stand together (a plain cylinder: an axis,
and a turn that swaps its ends). Source: Hodan et al., "BOP Challenge 2020".
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.errors import PoseError
from snapfit.models.pose import Array, Pose


@dataclass(frozen=True, eq=False)
class SymmetryAxis:
    """A line of the body about which it may turn by any angle.

    Attributes:
        direction: (3,) float64, unit, body frame.
        point_m: (3,) float64, a point on the line, metres, body frame.

    Raises:
        PoseError: the direction has no length, or a value is not finite.
    """

    direction: Array
    point_m: Array

    def __post_init__(self) -> None:
        direction = np.array(self.direction, dtype=np.float64)
        point_m = np.array(self.point_m, dtype=np.float64)
        length = float(np.linalg.norm(direction))
        if direction.shape != (3,) or not math.isfinite(length) or length < 1e-9:
            raise PoseError(f"a symmetry axis is a direction x, y, z, this is {direction}")
        if point_m.shape != (3,) or not np.isfinite(point_m).all():
            raise PoseError(f"a point on a symmetry axis is x, y, z in metres, this is {point_m}")
        object.__setattr__(self, "direction", direction / length)
        object.__setattr__(self, "point_m", point_m)

    def turn(self, angle_rad: float) -> Pose:
        """The motion of the body, in its own frame, that turns it about this axis."""
        rotation = Pose.exp([*(self.direction * angle_rad), 0, 0, 0]).rotation
        return Pose.from_rotation_translation(rotation, self.point_m - rotation @ self.point_m)


@dataclass(frozen=True, eq=False)
class Symmetry:
    """The motions that map a body onto itself.

    Attributes:
        motions: discrete motions in the body frame (`body_from_body`); the identity is implied.
        axis: the continuous axis, None without one.
    """

    motions: tuple[Pose, ...] = ()
    axis: SymmetryAxis | None = None

    @property
    def is_none(self) -> bool:
        """Whether every pose of the body looks different."""
        return not self.motions and self.axis is None

    @property
    def kind(self) -> str:
        """In a word, for tables: none, discrete, axis, or axis + discrete."""
        words = (["axis"] if self.axis else []) + (["discrete"] if self.motions else [])
        return " + ".join(words) or "none"

    @staticmethod
    def from_bop(info: Mapping[str, Any]) -> Symmetry:
        """From one object of BOP's `models_info.json` (millimetres).

        Raises:
            PoseError: a transform that is no rigid motion, or an axis without direction.
        """
        motions = []
        for numbers in info.get("symmetries_discrete", []):
            matrix = np.array(numbers, dtype=np.float64).reshape(4, 4)
            matrix[:3, 3] *= 0.001
            motions.append(Pose.from_matrix(matrix))
        axis = None
        for entry in info.get("symmetries_continuous", [])[:1]:
            point_m = np.array(entry.get("offset", [0, 0, 0]), dtype=np.float64) * 0.001
            axis = SymmetryAxis(np.array(entry["axis"], dtype=np.float64), point_m)
        return Symmetry(tuple(motions), axis)

    def sampled(self, step_m: float, radius_m: float) -> tuple[Pose, ...]:
        """All motions, the identity first, with the axis cut into equal angles.

        Args:
            step_m: how far the outermost point may travel from one angle to the next.
            radius_m: distance of that point from the axis (half the diameter is safe).
        """
        discrete = (Pose.identity(), *self.motions)
        if self.axis is None:
            return discrete
        n_angles = max(math.ceil(2 * math.pi * radius_m / step_m), 2)
        turns = [self.axis.turn(2 * math.pi * i / n_angles) for i in range(n_angles)]
        return tuple(motion @ turn for motion in discrete for turn in turns)

    def nearest(self, pose: Pose, reference: Pose) -> Pose:
        """Of all poses that look like `pose`, the one whose rotation is nearest to `reference`.

        Both are `a_from_body` with the same frame a.
        """
        candidates = [pose @ motion for motion in (Pose.identity(), *self.motions)]
        if self.axis is not None:
            candidates = [_turned_nearest(each, reference, self.axis) for each in candidates]
        return min(candidates, key=reference.angle_to)


NO_SYMMETRY = Symmetry()


def distance_modulo_symmetry(pose_a: Pose, pose_b: Pose, symmetry: Symmetry) -> tuple[float, float]:
    """How far two poses of one body are apart, its symmetry taken out.

    Of all poses that look like `pose_b` the one with the smallest angle to `pose_a` counts; the
    translation is that of the body's origin to the same one. Without symmetry these are the
    e_trans and e_rot of the GBOT paper (section 4.4).

    Returns:
        (translation_m, rotation_rad).
    """
    nearest = symmetry.nearest(pose_b, pose_a)
    return pose_a.distance_to(nearest), pose_a.angle_to(nearest)


def mean_distance_modulo_symmetry(
    points: npt.NDArray[np.floating[Any]],
    pose_a: Pose,
    pose_b: Pose,
    symmetry: Symmetry,
    step_m: float = 0.001,
) -> float:
    """ADD with the symmetry taken out: the least mean distance over all equivalent poses, m.

    Unlike ADD-S, which pairs every point with its closest, it cannot forgive a wrong pose whose
    surfaces happen to lie near each other.

    Args:
        points: (N, 3) points of the body, metres, body frame.
        pose_a: `camera_from_body`.
        pose_b: `camera_from_body`.
        symmetry: of the body.
        step_m: how finely a continuous axis is cut.
    """
    center = (points.max(axis=0) + points.min(axis=0)) / 2
    radius_m = float(np.linalg.norm(points - center, axis=1).max())
    moved_a = pose_a.transform(points)
    return min(
        float(np.linalg.norm(moved_a - (pose_b @ motion).transform(points), axis=1).mean())
        for motion in symmetry.sampled(step_m, radius_m)
    )


def _turned_nearest(pose: Pose, reference: Pose, axis: SymmetryAxis) -> Pose:
    """`pose` turned about its axis until its rotation is nearest to `reference`.

    With q = (v, w) the quaternion of R_ref^T R, a turn by t about the axis a has the real part
    w cos(t/2) - (v . a) sin(t/2); its magnitude is largest at t = -2 atan2(v . a, w).
    """
    relative = Pose.from_rotation_translation(reference.rotation.T @ pose.rotation, np.zeros(3))
    q = relative.quaternion
    return pose @ axis.turn(-2 * math.atan2(float(q[:3] @ axis.direction), float(q[3])))
