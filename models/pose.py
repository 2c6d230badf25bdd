"""Rigid motions: the group SE(3), its exponential, logarithm and adjoint.

Variations are ordered rotation first (rad), then translation (m), and act on the right:
`pose.perturbed(xi) = pose @ Pose.exp(xi)`. Quaternions are unit, in the order x, y, z, w.
Sources: Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics" (2018).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from snapfit.models.errors import PoseError

Array = npt.NDArray[np.float64]

_SMALL_ANGLE_RAD = 1e-4
_ORTHONORMAL_TOLERANCE = 1e-3


@dataclass(frozen=True, eq=False)
class Pose:
    """A rigid motion `a_from_b`: maps points of frame b into frame a.

    Attributes:
        matrix: (4, 4) float64, row-major, metres; read-only.
    """

    matrix: Array

    def __post_init__(self) -> None:
        matrix = np.array(self.matrix, dtype=np.float64)
        if matrix.shape != (4, 4):
            raise PoseError(f"a pose is a 4x4 matrix, this has the shape {matrix.shape}")
        if not np.isfinite(matrix).all():
            raise PoseError("a pose must be finite, this has NaN or infinite entries")
        matrix.setflags(write=False)
        object.__setattr__(self, "matrix", matrix)

    @staticmethod
    def identity() -> Pose:
        """The motion that leaves everything in its place."""
        return Pose(np.eye(4))

    @staticmethod
    def from_matrix(matrix: npt.ArrayLike) -> Pose:
        """A pose from outside (a file, a request): checked, then made exactly orthonormal.

        Args:
            matrix: (4, 4), metres; the rotation may be off by rounding, up to 1e-3.

        Raises:
            PoseError: not 4x4, not finite, mirrored, scaled, or the last row is not 0 0 0 1.
        """
        try:
            values = np.array(matrix, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise PoseError(f"a pose is a 4x4 matrix of numbers: {error}") from error
        pose = Pose(values)
        rotation = pose.matrix[:3, :3]
        if np.abs(pose.matrix[3] - (0, 0, 0, 1)).max() > _ORTHONORMAL_TOLERANCE:
            raise PoseError(f"the last row of a pose is 0 0 0 1, this has {values[3].tolist()}")
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > _ORTHONORMAL_TOLERANCE:
            raise PoseError("the rotation is not orthonormal: is the pose scaled, or transposed?")
        if np.linalg.det(rotation) < 0:
            raise PoseError("the rotation is mirrored (determinant -1): check the handedness")
        u, _, vt = np.linalg.svd(rotation)
        return Pose.from_rotation_translation(u @ vt, pose.translation)

    @staticmethod
    def from_rotation_translation(rotation: Array, translation: npt.ArrayLike) -> Pose:
        """A pose from a rotation matrix (3, 3) and a translation (3,), metres, unchecked."""
        matrix = np.eye(4)
        matrix[:3, :3] = rotation
        matrix[:3, 3] = translation
        return Pose(matrix)

    @staticmethod
    def from_translation(x_m: float, y_m: float, z_m: float) -> Pose:
        """A pure translation, metres."""
        return Pose.from_rotation_translation(np.eye(3), (x_m, y_m, z_m))

    @staticmethod
    def from_quaternion(quaternion: npt.ArrayLike, translation: npt.ArrayLike) -> Pose:
        """A pose from a quaternion (4,) x, y, z, w (normalised here) and a translation (3,), m.

        Raises:
            PoseError: the quaternion has no length.
        """
        q = np.asarray(quaternion, dtype=np.float64)
        norm = float(np.linalg.norm(q))
        if q.shape != (4,) or not np.isfinite(norm) or norm < 1e-9:
            raise PoseError(f"a quaternion is four numbers x, y, z, w of length 1, this is {q}")
        x, y, z, w = q / norm
        imaginary = skew(np.array([x, y, z]))
        rotation = np.eye(3) + 2 * w * imaginary + 2 * imaginary @ imaginary
        return Pose.from_rotation_translation(rotation, translation)

    @staticmethod
    def exp(variation: npt.ArrayLike) -> Pose:
        """The exponential map: (6,) rotation (rad), translation (m), to a pose.

        Sola et al.; a Taylor branch near zero.
        """
        xi = np.asarray(variation, dtype=np.float64)
        omega, rho = xi[:3], xi[3:]
        rotation, left_jacobian = _rotation_and_left_jacobian(omega)
        return Pose.from_rotation_translation(rotation, left_jacobian @ rho)

    def log(self) -> Array:
        """The logarithm: (6,) rotation (rad, at most pi long), translation (m); inverts `exp`."""
        omega = rotation_vector(self.rotation)
        _, left_jacobian = _rotation_and_left_jacobian(omega)
        return np.concatenate([omega, np.linalg.solve(left_jacobian, self.translation)])

    @property
    def rotation(self) -> Array:
        """(3, 3) rotation matrix, a view."""
        return self.matrix[:3, :3]

    @property
    def translation(self) -> Array:
        """(3,) translation, metres, a view."""
        return self.matrix[:3, 3]

    @property
    def quaternion(self) -> Array:
        """(4,) unit quaternion x, y, z, w with w >= 0."""
        r = self.rotation
        # Shepperd's method: divide by the largest of the four, so that nothing cancels.
        squares = np.array(
            [
                1 + r[0, 0] - r[1, 1] - r[2, 2],
                1 - r[0, 0] + r[1, 1] - r[2, 2],
                1 - r[0, 0] - r[1, 1] + r[2, 2],
                1 + r[0, 0] + r[1, 1] + r[2, 2],
            ]
        )
        products = np.array(
            [
                [squares[0], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
                [r[0, 1] + r[1, 0], squares[1], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
                [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], squares[2], r[1, 0] - r[0, 1]],
                [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], squares[3]],
            ]
        )
        q: Array = products[int(np.argmax(squares))]
        q = q / np.linalg.norm(q)
        return -q if q[3] < 0 else q

    def inverse(self) -> Pose:
        """`b_from_a` of this `a_from_b`."""
        rotation = self.rotation.T
        return Pose.from_rotation_translation(rotation, -rotation @ self.translation)

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(self.matrix @ other.matrix)

    def transform(self, points: npt.NDArray[Any]) -> Array:
        """Points (..., 3) of frame b, metres, in frame a."""
        result: Array = points @ self.rotation.T + self.translation
        return result

    def adjoint(self) -> Array:
        """(6, 6): `pose @ exp(xi) = exp(pose.adjoint() @ xi) @ pose`."""
        result = np.zeros((6, 6))
        result[:3, :3] = result[3:, 3:] = self.rotation
        result[3:, :3] = skew(self.translation) @ self.rotation
        return result

    def perturbed(self, variation: npt.ArrayLike) -> Pose:
        """This pose with a variation (6,) of the body frame, on the right."""
        return self @ Pose.exp(variation)

    def angle_to(self, other: Pose) -> float:
        """The angle between two rotations, rad (the paper's e_rot)."""
        return float(np.linalg.norm(rotation_vector(self.rotation.T @ other.rotation)))

    def distance_to(self, other: Pose) -> float:
        """The distance between two translations, metres (the paper's e_trans)."""
        return float(np.linalg.norm(self.translation - other.translation))


def skew(vector: Array) -> Array:
    """(3, 3) matrix of the cross product: `skew(a) @ b = a x b`."""
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=np.float64)


def rotation_vector(rotation: Array) -> Array:
    """The logarithm of a rotation matrix (3, 3): axis times angle, (3,), rad.

    Goes through the quaternion, which stays exact near 0 and near pi.
    """
    q = Pose.from_rotation_translation(rotation, np.zeros(3)).quaternion
    sine = float(np.linalg.norm(q[:3]))
    if sine < _SMALL_ANGLE_RAD:
        small: Array = 2 * q[:3] / q[3]
        return small
    vector: Array = q[:3] * (2 * np.arctan2(sine, q[3]) / sine)
    return vector


def _rotation_and_left_jacobian(omega: Array) -> tuple[Array, Array]:
    """Rodrigues' formula and the left Jacobian of SO(3) (Sola et al.)."""
    angle = float(np.linalg.norm(omega))
    hat = skew(omega)
    if angle < _SMALL_ANGLE_RAD:
        a, b, c = 1 - angle**2 / 6, 0.5 - angle**2 / 24, 1 / 6 - angle**2 / 120
    else:
        a = np.sin(angle) / angle
        b = 2 * np.sin(angle / 2) ** 2 / angle**2
        c = (angle - np.sin(angle)) / angle**3
    hat2 = hat @ hat
    return np.eye(3) + a * hat + b * hat2, np.eye(3) + b * hat + c * hat2
