"""Anchors: a headset's world against the camera, by themselves and through a real server."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from event_client import EventClient
from harness import Server, running, wait_for
from hypothesis import given
from hypothesis import strategies as st
from patience import within
from scripted_pipeline import CAMERA_FROM_MARKER, MARKER
from test_api import assert_problem

from snapfit.models.pose import Pose
from snapfit.server import quaternion
from snapfit.server.alignment import deviation, mean_of
from snapfit.server.anchor_shelf import LocalShelf
from snapfit.server.anchors import DRIFT_M, Anchor, Anchors
from snapfit.server.boards import Board, CharucoBoard
from snapfit.server.conventions import AXES, Convention
from snapfit.server.marker_message import MarkerMessage, SeenMarker
from snapfit.server.problems import ProblemError
from snapfit.server.rigid import Rigid
from snapfit.server.schemas_anchors import AnchorInfo, AnchorList

PATH = "/v1/anchors/headset"
WORLD_FROM_CAMERA = Pose.exp([0.3, -1.2, 0.5, 1.5, 0.2, -0.7])
BOARD = MARKER.model_dump(mode="json")

vectors = st.lists(st.floats(-1, 1), min_size=3, max_size=3)


def rigid(pose: Pose) -> Rigid:
    return Rigid(pose.translation.tolist(), pose.quaternion.tolist())


def matrix(motion: Rigid) -> np.ndarray[Any, Any]:
    return Pose.from_quaternion(motion.orientation, motion.position).matrix


@given(vectors, vectors, vectors)
def test_the_average_lies_in_the_middle(
    turn: list[float], at: list[float], off: list[float]
) -> None:
    middle = Pose.exp([*turn, *at])
    step = np.array([*(0.05 * each for each in off), *(0.01 * each for each in off)])
    poses = [rigid(middle.perturbed(step)), rigid(middle.perturbed(-step)), rigid(middle)]
    poses[1] = Rigid(poses[1].position, [-each for each in poses[1].orientation])
    np.testing.assert_allclose(matrix(mean_of(poses)), middle.matrix, atol=2e-3)


@given(vectors, vectors)
def test_deviation_is_the_papers_two_errors(turn: list[float], way: list[float]) -> None:
    a, b = Pose.exp([*turn, *way]), Pose.exp([*way, *turn])
    apart = deviation(rigid(a), rigid(b))
    assert apart.translation_m == pytest.approx(a.distance_to(b), abs=1e-9)
    assert apart.rotation_rad == pytest.approx(a.angle_to(b), abs=1e-6)


class Bench:
    """Anchors with a clock, a camera and ears of their own."""

    def __init__(self, shelf: LocalShelf | None = None) -> None:
        self.now_us = 0
        self.boards: list[Board] = []
        self.drifted: list[str] = []
        self.shelf = shelf or LocalShelf()
        self.anchors = Anchors(
            "bench",
            lambda: self.now_us,
            self.shelf,
            self._look_for,
            lambda it: self.drifted.append(it.name),
        )
        self.anchors.update()

    def _look_for(self, boards: list[Board]) -> None:
        self.boards = boards

    def put(
        self, name: str, camera_from_marker: Pose, off: Pose | None = None, **more: Any
    ) -> Anchor:
        """As a headset whose world is off by something."""
        world = (off or Pose.identity()) @ WORLD_FROM_CAMERA @ camera_from_marker
        arguments = {"ttl_s": 60.0, "restart": False, "board": MARKER, **more}
        return asyncio.run(self.anchors.put(name, world=rigid(world), **arguments))[0]

    def see(self, camera_from_marker: Pose) -> None:
        position, orientation = rigid(camera_from_marker)
        seen = SeenMarker(
            board=MARKER, position=position, orientation=orientation, error_px=0.1, corners=4
        )
        message = MarkerMessage(boot_id="b", captured_at_us=self.now_us, seen=(seen,))
        self.shelf.see(MarkerMessage.model_validate_json(message.model_dump_json()))
        self.anchors.update()


PLACE = Pose.exp([0.5, 0.4, 0.3, 0.02, 0.01, 0.6])


def test_both_see_the_board_and_the_worlds_are_aligned() -> None:
    bench = Bench()
    anchor = bench.put("headset", PLACE)
    assert bench.boards == [MARKER]
    with pytest.raises(ProblemError, match="has not seen the board") as refused:
        bench.anchors.frame_from_camera("headset")
    assert refused.value.status == 409
    bench.see(PLACE)
    pose, _ = bench.anchors.frame_from_camera("headset")
    np.testing.assert_allclose(matrix(pose), WORLD_FROM_CAMERA.matrix, atol=1e-9)
    assert anchor.drift is not None
    assert anchor.drift.translation_m < 1e-9


def test_noise_is_averaged_and_the_residual_tells_of_it() -> None:
    bench, rng = Bench(), np.random.default_rng(3)
    for _ in range(20):
        anchor = bench.put("headset", PLACE.perturbed(rng.normal(0, 0.002, 6)))
        bench.see(PLACE.perturbed(rng.normal(0, 0.002, 6)))
    aligned = anchor.world_from_camera()
    assert aligned is not None
    at_marker = matrix(aligned) @ PLACE.matrix
    off = Pose.from_matrix(at_marker).distance_to(WORLD_FROM_CAMERA @ PLACE)
    assert off < 0.0025
    residual = anchor.worlds.scatter()
    assert residual is not None
    assert 0.002 < residual.translation_m < 0.006
    assert not bench.drifted


def test_a_headset_that_drifts_is_told_once_and_can_begin_anew() -> None:
    bench = Bench()
    bench.see(PLACE)
    for _ in range(5):
        bench.put("headset", PLACE)
        bench.see(PLACE)
    shifted = Pose.from_translation(3 * DRIFT_M, 0, 0)
    anchor = bench.put("headset", PLACE, shifted)
    assert (bench.drifted, anchor.is_drifting) == (["headset"], True)
    bench.see(PLACE)
    bench.put("headset", PLACE, shifted)
    assert bench.drifted == ["headset"]
    anchor = bench.put("headset", PLACE, shifted, restart=True)
    assert (len(anchor.worlds), anchor.is_drifting) == (1, False)
    aligned = anchor.world_from_camera()
    assert aligned is not None
    np.testing.assert_allclose(matrix(aligned), (shifted @ WORLD_FROM_CAMERA).matrix, atol=1e-9)


def test_a_camera_that_was_knocked_is_told_and_followed() -> None:
    bench = Bench()
    bench.put("headset", PLACE)
    for _ in range(20):
        bench.see(PLACE)
    knocked = Pose.exp([0, 0.1, 0, 0, 0, 0]) @ PLACE
    bench.see(knocked)
    assert bench.drifted == ["headset"]
    for _ in range(20):
        bench.see(knocked)
    anchor = bench.anchors.named("headset")
    assert not anchor.is_drifting
    aligned = anchor.world_from_camera()
    assert aligned is not None
    np.testing.assert_allclose(
        matrix(aligned) @ knocked.matrix, (WORLD_FROM_CAMERA @ PLACE).matrix, atol=1e-9
    )


def test_an_anchor_that_nobody_speaks_for_expires() -> None:
    bench = Bench()
    bench.put("headset", PLACE, ttl_s=10.0)
    bench.now_us = 9_000_000
    bench.put("headset", PLACE, ttl_s=10.0)
    bench.now_us = 18_000_000
    assert len(bench.anchors.all()) == 1
    bench.now_us = 19_000_001
    assert bench.anchors.all() == []
    assert bench.boards == []
    with pytest.raises(ProblemError, match="expired"):
        bench.anchors.named("headset")


def test_there_is_a_limit_and_another_board_begins_anew() -> None:
    bench = Bench()
    for number in range(32):
        bench.put(f"headset-{number}", PLACE)
    with pytest.raises(ProblemError, match="delete one"):
        bench.put("one-more", PLACE)
    anchor = bench.put("headset-0", PLACE, board=CharucoBoard())
    assert (len(anchor.worlds), len(bench.boards)) == (1, 2)
    asyncio.run(bench.anchors.delete("headset-0"))
    assert bench.boards == [MARKER]


def test_anchors_outlive_the_server_and_the_camera_has_to_look_again(tmp_path: Path) -> None:
    file = tmp_path / "keys" / "anchors" / "bench.json"
    bench = Bench(LocalShelf(file, "camera-1"))
    for _ in range(3):
        bench.put("headset", PLACE)
        bench.see(PLACE)
    bench.shelf.close()
    assert file.stat().st_mode & 0o777 == 0o600
    again = Bench(LocalShelf(file, "camera-1"))
    assert again.boards == [MARKER]
    assert len(again.anchors.named("headset").worlds) == 3
    with pytest.raises(ProblemError, match="has not seen the board"):
        again.anchors.frame_from_camera("headset")
    again.see(PLACE)
    pose, revision = again.anchors.frame_from_camera("headset")
    np.testing.assert_allclose(matrix(pose), WORLD_FROM_CAMERA.matrix, atol=1e-9)
    assert revision != 0
    assert LocalShelf(file, "another-camera").records == {}
    again.now_us = 10**9
    assert again.anchors.all() == []


@pytest.mark.parametrize("content", [b"", b"{}", b'{"source": "c", "anchors": [{"anchor": "a"}]}'])
def test_a_damaged_file_of_anchors_is_told_and_replaced(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, content: bytes
) -> None:
    file = tmp_path / "bench.json"
    file.write_bytes(content)
    bench = Bench(LocalShelf(file, "c"))
    assert bench.anchors.all() == []
    assert "anchors begin anew" in caplog.text
    bench.put("headset", PLACE)
    bench.shelf.close()
    assert list(LocalShelf(file, "c").records) == ["headset"]


def test_a_folder_that_cannot_be_written_is_told_once_and_costs_nothing(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "no-folder").write_text("")
    bench = Bench(LocalShelf(tmp_path / "no-folder" / "bench.json", "c"))
    for _ in range(3):
        bench.put("headset", PLACE)
        bench.shelf.save(at_once=True)
    assert len(bench.anchors.named("headset").worlds) == 3
    told = [it for it in caplog.records if "cannot be written" in it.message]
    assert len(told) == 1


@pytest.fixture(scope="module")
def bench() -> Iterator[Server]:
    """One whose camera sees a marker."""
    with running("marker") as server:
        yield server.wait_ready()


def request(convention: Convention, world_from_marker: Pose, **more: Any) -> dict[str, Any]:
    position, orientation = rigid(world_from_marker).along(AXES[convention])
    pose = {"position": list(position), "orientation": list(orientation)}
    return {"world_from_marker": pose, "convention": convention, "board": BOARD, **more}


@pytest.mark.parametrize("convention", Convention)
def test_poses_are_served_in_the_headsets_world(bench: Server, convention: Convention) -> None:
    body = request(convention, WORLD_FROM_CAMERA @ CAMERA_FROM_MARKER, restart=True)

    def put() -> AnchorInfo:
        answer = bench.client.put(PATH, json=body)
        assert answer.status_code in (200, 201)
        return AnchorInfo.model_validate_json(answer.content)

    # A camera that is held up sees the board after the answer.
    info = wait_for(lambda: (it := put()).aligned and it)
    assert (info.frame, info.samples) == ("anchor:headset", 1)
    assert info.drift is not None
    assert info.drift.translation_m < 0.01

    def ask() -> Any:
        query = f"?frame=anchor:headset&convention={convention}"
        here, there = bench.get("/v1/poses").json(), bench.get(f"/v1/poses{query}").json()
        return (here, there) if here["seq"] == there["seq"] else None

    here, there = wait_for(ask)
    assert (there["frame"], there["convention"]) == ("anchor:headset", convention)
    for before, after in zip(here["parts"], there["parts"], strict=True):
        if before["position"] is None:
            assert after["position"] is None
            continue
        pose = WORLD_FROM_CAMERA @ Pose.from_quaternion(before["orientation"], before["position"])
        wanted = rigid(pose).along(AXES[convention])
        # The marker is seen with four corners in a small picture.
        assert math.dist(after["position"], wanted.position) < 0.03
        turn = quaternion.multiply(quaternion.inverse(wanted.orientation), after["orientation"])
        assert math.hypot(*quaternion.log(turn)) < 0.06
        assert math.hypot(*after["linear_velocity"]) == pytest.approx(0.1, rel=0.02)
    steps = bench.get("/v1/steps/current?frame=anchor:headset").json()
    assert steps["frame"] == "anchor:headset"


def test_anchors_are_listed_and_deleted(bench: Server) -> None:
    path = "/v1/stations/bench-1/anchors/visitor"
    body = request(Convention.UNITY, WORLD_FROM_CAMERA @ CAMERA_FROM_MARKER)
    assert bench.client.put(path, json=body).status_code == 201
    assert bench.client.put(path, json=body).status_code == 200
    assert bench.get(path).json()["samples"] == 2
    names = [it.anchor for it in AnchorList(**bench.get("/v1/anchors").json()).anchors]
    assert "visitor" in names
    answer = bench.client.delete(path)
    assert (answer.status_code, answer.content) == (204, b"")
    assert_problem(bench.client.delete(path), 404, path)
    problem = assert_problem(bench.get("/v1/poses?frame=anchor:visitor"), 404, "/v1/poses")
    assert problem["type"] == "urn:snapfit:problem:unknown-anchor"


def test_an_event_tells_that_worlds_drift_apart(bench: Server) -> None:
    path = "/v1/anchors/drifting"
    here = WORLD_FROM_CAMERA @ CAMERA_FROM_MARKER
    for _ in range(5):
        bench.client.put(path, json=request(Convention.OPENXR, here))
    wait_for(lambda: bench.get(path).json()["aligned"])
    client = EventClient(bench)
    shifted = Pose.from_translation(0.1, 0, 0) @ here
    info = bench.client.put(path, json=request(Convention.OPENXR, shifted)).json()
    assert info["drifting"] is True
    event = client.wait_for("anchor_drift")
    assert event.data["anchor"] == "drifting"
    assert 0.05 < event.data["translation_m"] < 0.15
    client.close()


def test_a_board_that_nobody_sees_is_not_aligned(server: Server) -> None:
    begin_s = time.monotonic()
    body = {**request(Convention.OPENCV, Pose.identity()), "ttl_s": 60}
    answer = server.client.put(PATH, json=body)
    assert (answer.status_code, answer.json()["aligned"]) == (201, False)
    assert answer.json()["world_from_camera"] is None
    assert time.monotonic() - begin_s < within(20)
    for path in ("/v1/poses", "/v1/steps"):
        problem = assert_problem(server.get(f"{path}?frame=anchor:headset"), 409, path)
        assert problem["type"] == "urn:snapfit:problem:anchor-not-aligned"
    assert server.client.delete(PATH).status_code == 204


@pytest.mark.parametrize(
    "change",
    [
        {"world_from_marker": None},
        {"world_from_marker": {"position": [0, 0, 1]}},
        {"world_from_marker": {"position": [0, 0], "orientation": [0, 0, 0, 1]}},
        {"world_from_marker": {"position": [0, 0, 1e9], "orientation": [0, 0, 0, 1]}},
        {"world_from_marker": {"position": [0, 0, 1], "orientation": [0, 0, 0, 0]}},
        {"world_from_marker": {"position": [0, 0, 1], "orientation": [0, 0, 0, 0.9]}},
        {"world_from_marker": {"position": [0, 0, "x"], "orientation": [0, 0, 0, 1]}},
        {"convention": "blender"},
        {"board": {"kind": "aruco", "id": 99, "size_m": 0.1}},
        {"board": {}},
        {"ttl_s": 0},
        {"ttl_s": 1e6},
        {"speed": 1},
    ],
)
def test_a_wrong_anchor_is_refused(server: Server, change: dict[str, Any]) -> None:
    body = {**request(Convention.OPENCV, Pose.identity()), **change}
    assert_problem(server.client.put(PATH, json=body), 422, PATH)


@pytest.mark.parametrize("name", ["-x", "a b", "x" * 65, "ä"])
def test_a_wrong_name_is_refused(server: Server, name: str) -> None:
    body = request(Convention.OPENCV, Pose.identity())
    assert server.client.put(f"/v1/anchors/{name}", json=body).status_code == 422
    assert server.get(f"/v1/poses?frame=anchor:{name}").status_code == 422
