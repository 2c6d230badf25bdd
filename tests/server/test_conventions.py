"""The conventions: against the golden file, which knows nothing of the code, and as properties."""

from __future__ import annotations

import json
from typing import Any

import golden_conventions
import numpy as np
import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st

from snapfit.models.pose import Pose
from snapfit.server import quaternion
from snapfit.server.answers import SnapshotAnswers
from snapfit.server.conventions import AXES, Convention
from snapfit.server.rigid import Rigid
from snapfit.server.view import View

GOLDEN: dict[str, Any] = json.loads(golden_conventions.FILE.read_text(encoding="utf-8"))
NUMBERS = ("position", "orientation", "linear_velocity", "angular_velocity", "covariance")

conventions = st.sampled_from(list(Convention))
numbers = st.floats(-2, 2)
vectors = st.lists(numbers, min_size=3, max_size=3)
turns = st.lists(st.floats(-3, 3), min_size=3, max_size=3)


@st.composite
def rigids(draw: st.DrawFn) -> Rigid:
    return Rigid(draw(vectors), quaternion.exp(draw(turns)))


def matrix(motion: Rigid) -> np.ndarray[Any, Any]:
    return Pose.from_quaternion(motion.orientation, motion.position).matrix


def test_the_golden_file_is_what_its_matrices_say() -> None:
    made = flat(golden_conventions.document())
    assert made == flat(GOLDEN), "run tests/server/golden_conventions.py"


def flat(value: Any) -> list[Any]:
    if isinstance(value, dict):
        return [each for key in sorted(value) for each in [key, *flat(value[key])]]
    if isinstance(value, list):
        return [each for item in value for each in flat(item)]
    return [round(value, 9) + 0.0] if isinstance(value, float) else [value]


@pytest.mark.parametrize("convention", Convention)
def test_the_code_has_the_golden_matrices(convention: Convention) -> None:
    assert set(GOLDEN["conventions"]) == set(Convention)
    golden = GOLDEN["conventions"][convention]["convention_from_opencv"]
    assert AXES[convention].matrix == golden
    assert AXES[convention].handedness == round(np.linalg.det(golden))


@pytest.mark.parametrize("frame", ["camera", "anchor"])
@pytest.mark.parametrize("convention", Convention)
@pytest.mark.parametrize("case", GOLDEN["cases"], ids=lambda case: str(case["name"]))
def test_the_server_answers_what_the_golden_file_says(
    case: dict[str, Any], convention: Convention, frame: str
) -> None:
    part = {"part": "it", **{key: case["camera"]["opencv"][key] for key in NUMBERS}}
    snapshot = {"boot_id": "b", "seq": 1, "captured_at_us": 0, "parts": [part]}
    anchor = GOLDEN["anchor_from_camera"]["opencv"]
    place = Rigid(anchor["position"], anchor["orientation"]) if frame == "anchor" else None
    view = View(convention, "camera" if place is None else "anchor:a", place)
    answer = SnapshotAnswers(1, orjson.dumps(snapshot)).all_parts(stale=False, view=view)
    given_answer = orjson.loads(answer.body(0))
    assert (given_answer["convention"], given_answer["frame"]) == (convention, view.frame)
    said, wanted = given_answer["parts"][0], case[frame][convention]
    for key in NUMBERS:
        expected = np.array(wanted[key])
        if key == "orientation":
            expected = expected * np.sign(np.dot(expected, said[key]))
        np.testing.assert_allclose(said[key], expected, atol=1e-9, err_msg=key)
    vertex = Rigid(said["position"], said["orientation"]).transform(wanted["vertex_in_body"])
    np.testing.assert_allclose(vertex, wanted["vertex_in_frame"], atol=1e-9)


@given(rigids(), conventions)
def test_there_and_back_is_the_same(motion: Rigid, convention: Convention) -> None:
    back = motion.along(AXES[convention]).along(AXES[convention].inverse)
    np.testing.assert_array_equal(back.position, motion.position)
    np.testing.assert_array_equal(back.orientation, motion.orientation)


@given(rigids(), rigids(), conventions)
def test_products_cancel_in_every_convention(a: Rigid, b: Rigid, convention: Convention) -> None:
    axes = AXES[convention]
    np.testing.assert_allclose(
        matrix((a @ b).along(axes)), matrix(a.along(axes) @ b.along(axes)), atol=1e-9
    )


@given(rigids(), vectors, conventions)
def test_points_go_the_same_way(motion: Rigid, point: list[float], convention: Convention) -> None:
    axes = AXES[convention]
    np.testing.assert_allclose(
        axes.vector(motion.transform(point)),
        motion.along(axes).transform(axes.vector(point)),
        atol=1e-9,
    )


@given(vectors, vectors, conventions)
def test_only_unity_is_left_handed(a: list[float], b: list[float], convention: Convention) -> None:
    axes = AXES[convention]
    cross = np.cross(axes.vector(a), axes.vector(b))
    sign = -1 if convention is Convention.UNITY else 1
    np.testing.assert_allclose(cross, sign * np.array(axes.vector(np.cross(a, b))), atol=1e-9)


@given(rigids(), vectors, conventions)
def test_an_angular_velocity_turns_the_converted_pose_as_it_turns_the_pose(
    motion: Rigid, angular: list[float], convention: Convention
) -> None:
    axes = AXES[convention]
    turned = quaternion.multiply(quaternion.exp(angular), motion.orientation)
    converted = motion.along(axes)
    np.testing.assert_allclose(
        quaternion.multiply(quaternion.exp(axes.axial(angular)), converted.orientation),
        axes.quaternion(turned),
        atol=1e-9,
    )


@given(rigids(), vectors, vectors, conventions)
def test_a_perturbation_keeps_its_likelihood(
    motion: Rigid, turn: list[float], way: list[float], convention: Convention
) -> None:
    """x^T C^-1 x is a number that no choice of axes changes."""
    axes = AXES[convention]
    covariance = golden_conventions.covariance()
    converted = np.array(axes.covariance(list(covariance.ravel()))).reshape(6, 6)
    before = np.array([*turn, *way])
    after = np.array([*axes.axial(turn), *axes.vector(way)])
    np.testing.assert_allclose(
        after @ np.linalg.solve(converted, after), before @ np.linalg.solve(covariance, before)
    )
    assert np.linalg.eigvalsh(converted).min() > 0


@given(rigids(), rigids(), vectors)
def test_rigid_agrees_with_the_matrices(a: Rigid, b: Rigid, point: list[float]) -> None:
    np.testing.assert_allclose(matrix(a @ b), matrix(a) @ matrix(b), atol=1e-9)
    np.testing.assert_allclose(matrix(a.inverse()), np.linalg.inv(matrix(a)), atol=1e-9)
    np.testing.assert_allclose(a.transform(point), (matrix(a) @ [*point, 1])[:3], atol=1e-9)


@given(turns)
def test_exp_and_log_agree_with_the_matrices(vector: list[float]) -> None:
    q = quaternion.exp(vector)
    np.testing.assert_allclose(
        Pose.from_quaternion(q, [0, 0, 0]).rotation,
        Pose.exp([*vector, 0, 0, 0]).rotation,
        atol=1e-9,
    )
    np.testing.assert_allclose(
        Pose.exp([*quaternion.log(q), 0, 0, 0]).rotation,
        Pose.exp([*vector, 0, 0, 0]).rotation,
        atol=1e-9,
    )


@given(st.lists(st.floats(-1e-7, 1e-7), min_size=3, max_size=3))
def test_log_inverts_exp_near_zero(vector: list[float]) -> None:
    np.testing.assert_allclose(quaternion.log(quaternion.exp(vector)), vector, atol=1e-15)
