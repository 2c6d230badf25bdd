"""The assembly and its steps, through a real server."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from harness import Server, running, wait_for
from scripted_assembly import BASE_FROM_JAW, CONFIDENCE, STEPS
from scripted_pipeline import FRAME_RATE_HZ, FRAMES_A_STATE
from test_api import assert_problem

from snapfit.models.pose import Pose
from snapfit.server.schemas_assembly import AssemblyStatus, StepAnswer, StepList

PATHS = ["/v1/assembly", "/v1/stations/bench-1/assembly"]


@pytest.fixture(scope="module")
def assembling() -> Iterator[Server]:
    """One whose assembly goes on by itself."""
    with running("assembles") as server:
        yield server.wait_ready()


@pytest.mark.parametrize("path", PATHS)
def test_the_assembly_keeps_the_contract(server: Server, path: str) -> None:
    answer = AssemblyStatus.model_validate_json(server.get(path).content)
    assert (answer.state, answer.confidence) == ("free", CONFIDENCE)
    assert (answer.finished_steps, answer.next_steps) == ([], ["mount-jaw"])
    assert (answer.decided_by, answer.misassemblies) == ("tracking", [])
    assert answer.since_us <= answer.captured_at_us


def test_every_snapshot_carries_the_assembly(server: Server) -> None:
    snapshot = server.get("/v1/poses").json()
    assembly = server.get("/v1/assembly").json()
    assert snapshot["assembly"].items() <= assembly.items()
    assert snapshot["parts"][1]["linked_to"] == "base"
    assert "assembly" not in server.get("/v1/poses/jaw").json()


def test_what_sits_wrong_is_told(assembling: Server) -> None:
    def wrong() -> Any:
        return assembling.get("/v1/assembly").json()["misassemblies"]

    assert wait_for(wrong) == [
        {
            "part": "pin",
            "parent": "base",
            "kind": "wrong_place",
            "translation_m": 0.012,
            "rotation_rad": None,
        }
    ]


def test_a_long_poll_brings_every_change_of_the_assembly(assembling: Server) -> None:
    def five_changes() -> list[str] | None:
        """The states before and after; None where this client was held up meanwhile."""
        answer = assembling.get("/v1/assembly").json()
        states, begin_s = [answer["state"]], time.monotonic()
        for _ in range(5):
            query = f"?after_revision={answer['revision']}&boot_id={answer['boot_id']}&timeout_s=5"
            later = assembling.get("/v1/assembly" + query).json()
            assert later["revision"] > answer["revision"] or later["stale"]
            if later["revision"] != answer["revision"] + 1:
                return None
            answer = later
            states.append(answer["state"])
        assert time.monotonic() - begin_s > 3 * FRAMES_A_STATE / FRAME_RATE_HZ
        return states

    assert all(a != b for a, b in pairwise(wait_for(five_changes)))


def test_without_a_change_there_is_no_content(server: Server) -> None:
    known = server.get("/v1/assembly").json()
    query = f"?after_revision={known['revision']}&boot_id={known['boot_id']}&timeout_s=0.3"
    answer = server.get("/v1/assembly" + query)
    assert (answer.status_code, answer.content) == (204, b"")


def test_the_entity_tag_lasts_while_the_assembly_does(server: Server) -> None:
    etag = server.get("/v1/assembly").headers["etag"]
    time.sleep(0.2)
    assert server.get("/v1/assembly", headers={"If-None-Match": etag}).status_code == 304


@pytest.mark.parametrize(
    "query",
    ["after_revision=-1&boot_id=x", "after_revision=x", "timeout_s=99", "state=free"],
)
def test_a_wrong_query_is_refused(server: Server, query: str) -> None:
    assert_problem(server.get(f"/v1/assembly?{query}"), 422, "/v1/assembly")


def test_steps_are_told_with_all_that_the_manifest_says(server: Server) -> None:
    answer = StepList.model_validate_json(server.get("/v1/steps").content)
    first, second = answer.steps
    assert [first.step, second.step] == [step.name for step in STEPS]
    assert (first.progress, second.progress) == ("next", "later")
    assert (first.title, first.text) == (STEPS[0].title, STEPS[0].text)
    assert (first.expected_duration_s, second.expected_duration_s) == (8, None)
    assert first.media == ["https://example.com/jaw.mp4"]
    assert first.ghost is not None
    np.testing.assert_allclose(first.ghost.position, BASE_FROM_JAW.translation)
    np.testing.assert_allclose(first.ghost.orientation, BASE_FROM_JAW.quaternion)
    assert first.annotations[0].model_dump() == {
        "part": "jaw",
        "anchor": [0.1, 0.2, 0.3],
        "text": "This side up",
    }


def test_the_ghost_is_where_the_base_is(server: Server) -> None:
    def ask() -> Any:
        step = server.get("/v1/steps/current").json()
        poses = server.get("/v1/poses").json()
        return (step, poses) if step["seq"] == poses["seq"] else None

    step, poses = wait_for(ask)
    StepAnswer.model_validate(step)
    base = Pose.from_quaternion(poses["parts"][0]["orientation"], poses["parts"][0]["position"])
    ghost = step["step"]["ghost_in_frame"]
    wanted = base @ BASE_FROM_JAW
    np.testing.assert_allclose(ghost["position"], wanted.translation, atol=1e-6)
    np.testing.assert_allclose(ghost["orientation"], wanted.quaternion, atol=1e-6)


def test_a_ghost_on_a_part_that_is_not_seen_has_no_place(server: Server) -> None:
    step = server.get("/v1/steps/screw-bolt").json()["step"]
    assert step["ghost"]["parent"] == "cap"
    assert step["ghost_in_frame"] is None


def test_steps_are_given_in_other_conventions(server: Server) -> None:
    answer = server.get("/v1/steps/mount-jaw?convention=unity").json()
    assert answer["convention"] == "unity"
    ghost, annotation = answer["step"]["ghost"], answer["step"]["annotations"][0]
    np.testing.assert_allclose(ghost["position"], [0.01, -0.02, 0.03])
    x, y, z, w = BASE_FROM_JAW.quaternion
    np.testing.assert_allclose(ghost["orientation"], [-x, y, -z, w], atol=1e-12)
    assert annotation["anchor"] == [0.1, -0.2, 0.3]


def test_current_goes_with_the_assembly_until_nothing_is_left(assembling: Server) -> None:
    def finished() -> Any:
        answer = assembling.get("/v1/steps/current")
        return answer if answer.status_code == 404 else None

    problem = assert_problem(wait_for(finished), 404, "/v1/steps/current")
    assert problem["type"] == "urn:snapfit:problem:assembly-finished"
    wait_for(lambda: assembling.get("/v1/steps/current").status_code == 200)


def test_an_unknown_step_lists_the_steps_that_exist(server: Server) -> None:
    problem = assert_problem(server.get("/v1/steps/glue-jaw"), 404, "/v1/steps/glue-jaw")
    assert problem["steps"] == [step.name for step in STEPS]


def test_loose_parts_have_no_assembly() -> None:
    with running("loose") as server:
        server.wait_ready()
        for path in ("/v1/assembly", "/v1/steps", "/v1/steps/current", "/v1/steps/mount-jaw"):
            problem = assert_problem(server.get(path), 404, path)
            assert problem["type"] == "urn:snapfit:problem:no-assembly"
        assert server.get("/v1/poses").json()["assembly"] is None
        assert server.get("/v1/assets").json() == {"assets": []}
