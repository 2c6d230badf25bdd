"""What an operator orders: done, refused with the reason, told by events; never done later."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest
from event_client import EventClient
from harness import Server, once_there, running, wait_for
from patience import within
from scripted_pipeline import LOST_PART, PART_NAMES
from test_api import assert_problem

from snapfit.server.schemas_commands import CommandResult

STATE = "/v1/assembly/state"


@pytest.fixture(scope="module")
def finding(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """One with a detector."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SCRIPTED_HOLD", str(tmp_path_factory.mktemp("finding") / "hold"))
        with running("finds") as server:
            yield server.wait_ready()


@contextmanager
def nothing_is_found(finding: Server) -> Iterator[None]:
    """What is looked for stays to be seen as such, however late this test looks."""
    hold = Path(finding.environment["SCRIPTED_HOLD"])
    hold.touch()
    try:
        yield
    finally:
        hold.unlink()


def put_state(server: Server, state: object, path: str = STATE) -> httpx.Response:
    return once_there(lambda: server.client.put(path, json={"state": state}))


def post(server: Server, path: str, **body: object) -> httpx.Response:
    return once_there(lambda: server.client.post(path, json=body or None))


def all_found(server: Server) -> bool:
    parts = server.get("/v1/poses").json()["parts"]
    return {part["part"] for part in parts if part["status"] == "tracked"} == (
        set(PART_NAMES) - {LOST_PART}
    )


@pytest.mark.parametrize("path", [STATE, "/v1/stations/bench-1/assembly/state"])
def test_an_operator_says_which_state_holds(finding: Server, path: str) -> None:
    put_state(finding, "free")
    result = CommandResult.model_validate_json(put_state(finding, "jaw-mounted", path).content)
    assert (result.changed, result.state) == (True, "jaw-mounted")
    assembly = finding.get("/v1/assembly").json()
    assert (assembly["state"], assembly["decided_by"]) == ("jaw-mounted", "operator")
    assert assembly["finished_steps"] == ["mount-jaw"]
    again = put_state(finding, "jaw-mounted", path).json()
    assert (again["changed"], again["done"], again["state"]) == (False, [], "jaw-mounted")


def test_events_tell_that_an_operator_decided(finding: Server) -> None:
    put_state(finding, "free")
    client = EventClient(finding)
    put_state(finding, "assembled")
    changed = client.wait_for("state_changed")
    assert (changed.data["from_state"], changed.data["to_state"]) == ("free", "assembled")
    assert changed.data["decided_by"] == "operator"
    wait_for(lambda: client.kinds().count("step_finished") == 2)
    client.close()


def test_parts_are_looked_for_again(finding: Server) -> None:
    wait_for(lambda: all_found(finding))
    put_state(finding, "jaw-mounted")
    client = EventClient(finding)
    with nothing_is_found(finding):
        answer = post(finding, "/v1/reinitialise", parts=["jaw"])
        assert answer.json()["done"] == ["jaw is looked for again"]
        jaw, base = (finding.get(f"/v1/poses/{part}").json()["pose"] for part in ("jaw", "base"))
        assert (jaw["status"], jaw["position"], base["status"]) == ("searching", None, "tracked")
        assert post(finding, "/v1/reinitialise", parts=["jaw"]).json()["done"] == []
    assert client.wait_for("part_lost").data["part"] == "jaw"
    assert client.wait_for("part_found").data["part"] == "jaw"
    client.close()
    assert finding.get("/v1/assembly").json()["state"] == "jaw-mounted"
    answer = post(finding, "/v1/reinitialise")
    assert len(answer.json()["done"]) == len(PART_NAMES)
    wait_for(lambda: all_found(finding))


def test_a_reset_begins_anew_and_a_second_one_has_nothing_to_do(finding: Server) -> None:
    wait_for(lambda: all_found(finding))
    put_state(finding, "assembled")
    with nothing_is_found(finding):
        result = CommandResult.model_validate_json(post(finding, "/v1/reset").content)
        assert (result.changed, result.state) == (True, "free")
        assert result.done[0] == "state set to free"
        assert finding.get("/v1/assembly").json()["state"] == "free"
        parts = finding.get("/v1/poses").json()["parts"]
        assert {part["status"] for part in parts} == {"searching"}
        again = post(finding, "/v1/reset").json()
        assert (again["changed"], again["done"], again["state"]) == (False, [], "free")
    wait_for(lambda: all_found(finding))


def test_a_reset_without_a_detector_sets_the_state_alone() -> None:
    with running() as server:
        server.wait_ready()
        put_state(server, "assembled")
        assert post(server, "/v1/reset").json()["done"] == ["state set to free"]
        assert server.get("/v1/poses/base").json()["pose"]["status"] == "tracked"


def test_what_cannot_be_done_is_refused_with_the_reason(server: Server) -> None:
    problem = assert_problem(post(server, "/v1/reinitialise"), 409, "/v1/reinitialise")
    assert problem["type"] == "urn:snapfit:problem:no-detector"
    problem = assert_problem(put_state(server, "glued"), 409, STATE)
    assert problem["type"] == "urn:snapfit:problem:unknown-state"
    assert problem["names"] == ["free", "jaw-mounted", "assembled"]
    answer = post(server, "/v1/reinitialise", parts=["jew"])
    problem = assert_problem(answer, 409, "/v1/reinitialise")
    assert problem["names"] == list(PART_NAMES)


@pytest.mark.parametrize(
    ("method", "path", "body"),
    [
        ("PUT", STATE, b""),
        ("PUT", STATE, b"{"),
        ("PUT", STATE, b"[]"),
        ("PUT", STATE, b"{}"),
        ("PUT", STATE, b'{"state": ""}'),
        ("PUT", STATE, b'{"state": 3}'),
        ("PUT", STATE, b'{"state": "free", "force": true}'),
        ("PUT", STATE, b'{"state": "' + b"x" * 65 + b'"}'),
        ("POST", "/v1/reinitialise", b'{"parts": "jaw"}'),
        ("POST", "/v1/reinitialise", b'{"parts": [""]}'),
        ("POST", "/v1/reinitialise", b'{"part": ["jaw"]}'),
        ("POST", "/v1/reinitialise", b'{"parts": [' + b'"a",' * 64 + b'"a"]}'),
    ],
)
def test_a_wrong_body_is_refused(server: Server, method: str, path: str, body: bytes) -> None:
    headers = {"Content-Type": "application/json"}
    answer = server.client.request(method, path, content=body, headers=headers)
    assert_problem(answer, 422, path)


def test_where_every_frame_is_seen_by_itself_there_is_nothing_to_order() -> None:
    with running("frame-by-frame") as server:
        server.wait_ready()
        problem = assert_problem(post(server, "/v1/reset"), 409, "/v1/reset")
        assert problem["type"] == "urn:snapfit:problem:nothing-to-command"


def test_loose_parts_have_no_state_to_set() -> None:
    with running("loose") as server:
        server.wait_ready()
        problem = assert_problem(put_state(server, "free"), 409, STATE)
        assert problem["type"] == "urn:snapfit:problem:no-assembly"
        assert_problem(post(server, "/v1/reset"), 409, "/v1/reset")


def test_after_the_end_of_the_source_nothing_can_be_done() -> None:
    with running("end") as server:
        wait_for(server.answers)
        wait_for(lambda: server.worker()["phase"] == "ended")
        problem = assert_problem(post(server, "/v1/reset"), 409, "/v1/reset")
        assert problem["type"] == "urn:snapfit:problem:source-ended"


def test_a_worker_that_does_not_answer_is_told_and_never_does_it_later() -> None:
    with running() as server:
        pid = server.wait_ready().worker()["pid"]
        os.kill(pid, signal.SIGSTOP)
        begin_s = time.monotonic()
        answer = server.client.put(STATE, json={"state": "assembled"})
        took_s = time.monotonic() - begin_s
        assert_problem(answer, 503, STATE)
        assert answer.headers["retry-after"] == "1"
        assert took_s < within(10)
        os.kill(pid, signal.SIGCONT)
        seq = server.get("/v1/poses").json()["seq"]
        wait_for(lambda: server.get("/v1/poses").json()["seq"] > seq + 10)
        assert server.get("/v1/assembly").json()["state"] == "free"


def test_many_orders_at_once_are_all_answered(finding: Server) -> None:
    url = f"http://127.0.0.1:{finding.port}{STATE}"
    states = ["free", "jaw-mounted", "assembled"] * 5

    def put(state: str) -> str:
        answer = once_there(lambda: httpx.put(url, json={"state": state}, timeout=within(10)))
        assert answer.status_code == 200
        return str(answer.json()["state"])

    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(put, states)) == states


def test_an_order_is_done_within_a_few_frames(finding: Server) -> None:
    durations_s = []
    for state in ("free", "jaw-mounted") * 5:
        begin_s = time.monotonic()
        put_state(finding, state)
        durations_s.append(time.monotonic() - begin_s)
    # The quickest: any of them may be held up.
    assert min(durations_s) < within(0.15)
