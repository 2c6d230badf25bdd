"""SE(3): the axioms of a group, exponential and logarithm, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snapfit.models.errors import PoseError
from snapfit.models.pose import Pose, rotation_vector, skew

coordinate = st.floats(-1.0, 1.0, allow_subnormal=False)


@st.composite
def variations(draw: st.DrawFn, largest_angle: float = 3.1) -> np.ndarray:
    axis = np.array([draw(coordinate) for _ in range(3)])
    norm = np.linalg.norm(axis)
    axis = axis / norm if norm > 1e-6 else np.array([0.0, 0.0, 1.0])
    angle = draw(st.floats(0.0, largest_angle))
    translation = [draw(coordinate) for _ in range(3)]
    return np.concatenate([axis * angle, translation])


poses = variations().map(Pose.exp)


def close(a: Pose, b: Pose, tolerance: float = 1e-9) -> bool:
    return bool(np.abs(a.matrix - b.matrix).max() < tolerance)


@given(poses, poses)
def test_closure(a: Pose, b: Pose) -> None:
    product = a @ b
    assert np.allclose(product.rotation @ product.rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(product.rotation) == pytest.approx(1.0)
    assert product.matrix[3].tolist() == [0, 0, 0, 1]


@given(poses)
def test_identity_and_inverse(pose: Pose) -> None:
    assert close(pose @ Pose.identity(), pose)
    assert close(Pose.identity() @ pose, pose)
    assert close(pose @ pose.inverse(), Pose.identity())
    assert close(pose.inverse() @ pose, Pose.identity())


@given(poses, poses, poses)
def test_associativity(a: Pose, b: Pose, c: Pose) -> None:
    assert close((a @ b) @ c, a @ (b @ c))


@given(poses, poses)
def test_transform_follows_the_product(a: Pose, b: Pose) -> None:
    points = np.array([[0.1, -0.2, 0.3], [0.0, 0.5, -0.4]])
    assert np.allclose((a @ b).transform(points), a.transform(b.transform(points)))
    assert np.allclose(a.inverse().transform(a.transform(points)), points)


@given(variations())
def test_log_inverts_exp(variation: np.ndarray) -> None:
    assert np.allclose(Pose.exp(variation).log(), variation, atol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 9.9e-5, 1.01e-4, 1e-3])
def test_log_inverts_exp_near_zero(angle: float) -> None:
    variation = np.array([0.6 * angle, -0.8 * angle, 0.0, 0.1, 0.2, -0.3])
    # Relative to the angle, so that a variation lost to rounding does not pass.
    assert np.allclose(Pose.exp(variation).log(), variation, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("gap", [1e-2, 1e-5, 1e-8, 0.0])
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, -2, 2), (-3, 4, 12)])
def test_log_inverts_exp_near_pi(gap: float, axis: tuple[int, int, int]) -> None:
    direction = np.array(axis) / np.linalg.norm(axis)
    pose = Pose.exp(np.concatenate([direction * (np.pi - gap), [0.1, 0.2, 0.3]]))
    logarithm = pose.log()
    assert np.linalg.norm(logarithm[:3]) == pytest.approx(np.pi - gap, abs=1e-9)
    assert close(Pose.exp(logarithm), pose, 1e-8)


@given(variations(largest_angle=0.5))
def test_exp_agrees_with_the_series(variation: np.ndarray) -> None:
    generator = np.zeros((4, 4))
    generator[:3, :3], generator[:3, 3] = skew(variation[:3]), variation[3:]
    series, term = np.eye(4), np.eye(4)
    for k in range(1, 20):
        term = term @ generator / k
        series += term
    assert np.allclose(Pose.exp(variation).matrix, series, atol=1e-12)


@given(poses, variations())
def test_adjoint_moves_a_variation_to_the_other_side(pose: Pose, variation: np.ndarray) -> None:
    moved = Pose.exp(pose.adjoint() @ variation)
    assert close(pose.perturbed(variation), moved @ pose)


@given(poses, poses)
def test_adjoint_of_a_product(a: Pose, b: Pose) -> None:
    assert np.allclose((a @ b).adjoint(), a.adjoint() @ b.adjoint())
    assert np.allclose(a.inverse().adjoint() @ a.adjoint(), np.eye(6))


@given(variations(largest_angle=float(np.pi)))
def test_quaternion_round_trip(variation: np.ndarray) -> None:
    pose = Pose.exp(variation)
    quaternion = pose.quaternion
    assert np.linalg.norm(quaternion) == pytest.approx(1.0)
    assert quaternion[3] >= 0
    for sign in (1, -1):
        assert close(Pose.from_quaternion(sign * 2.5 * quaternion, pose.translation), pose)


def test_quaternion_order_is_x_y_z_w() -> None:
    quarter_turn_about_z = Pose.from_quaternion([0, 0, np.sqrt(0.5), np.sqrt(0.5)], [0, 0, 0])
    assert np.allclose(quarter_turn_about_z.transform(np.array([1.0, 0, 0])), [0, 1, 0])
    assert np.allclose(quarter_turn_about_z.quaternion, [0, 0, np.sqrt(0.5), np.sqrt(0.5)])


@given(poses, variations())
def test_angle_and_distance(pose: Pose, variation: np.ndarray) -> None:
    turned = pose.perturbed(np.concatenate([variation[:3], np.zeros(3)]))
    assert pose.angle_to(turned) == pytest.approx(np.linalg.norm(variation[:3]), abs=1e-7)
    shifted = pose.perturbed(np.concatenate([np.zeros(3), variation[3:]]))
    assert pose.distance_to(shifted) == pytest.approx(np.linalg.norm(variation[3:]), abs=1e-12)


def test_rotation_vector_of_a_quarter_turn() -> None:
    rotation = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    assert np.allclose(rotation_vector(rotation), [0, 0, np.pi / 2])


def test_from_matrix_repairs_rounding() -> None:
    rounded = np.round(Pose.exp([0.3, -0.4, 0.5, 0.1, 0.2, 0.3]).matrix, 5)
    pose = Pose.from_matrix(rounded.tolist())
    assert np.allclose(pose.rotation @ pose.rotation.T, np.eye(3), atol=1e-14)
    assert np.allclose(pose.matrix, rounded, atol=2e-5)


def test_a_pose_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        Pose.identity().matrix[0, 3] = 1.0


def changed(row: int, column: int, value: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[row, column] = value
    return matrix


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.eye(3), "4x4"),
        ("not a matrix", "4x4"),
        ([[1, 0], [0]], "4x4"),
        (changed(0, 3, np.nan), "finite"),
        (changed(1, 1, np.inf), "finite"),
        (changed(3, 0, 0.5), "last row"),
        (np.diag([1000.0, 1000, 1000, 1]), "scaled"),
        (np.diag([1.0, 1, -1, 1]), "mirrored"),
        (np.zeros((4, 4)), "last row"),
    ],
)
def test_what_is_no_rigid_motion_is_refused(matrix: object, message: str) -> None:
    with pytest.raises(PoseError, match=message):
        Pose.from_matrix(matrix)  # type: ignore[arg-type]


@pytest.mark.parametrize("quaternion", [[0, 0, 0, 0], [0, 0, 1], [np.nan, 0, 0, 1]])
def test_what_is_no_quaternion_is_refused(quaternion: list[float]) -> None:
    with pytest.raises(PoseError, match="quaternion"):
        Pose.from_quaternion(quaternion, [0, 0, 0])
