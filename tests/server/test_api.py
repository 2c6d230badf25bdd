"""The API through a real server process."""

from __future__ import annotations

import os
import time
from typing import Any

import httpx
import numpy as np
import orjson
import pytest
from folder_server import STALE_AFTER_S
from harness import Server, once_there, running, wait_for
from patience import within
from scripted_pipeline import FRAME_RATE_HZ, LOST_PART, PART_NAMES, X_VELOCITY_M_PER_S

from snapfit.server.schemas import (
    PartSnapshot,
    PoseSnapshot,
    ServerTime,
    StationInfo,
    StationList,
)
from snapfit.server.schemas_base import Problem

POSES = ["/v1/poses", "/v1/stations/bench-1/poses"]
PICTURES = ["/v1/frame.jpg", "/v1/overlay.jpg", "/v1/stations/bench-1/frame.jpg"]


def assert_problem(answer: httpx.Response, status: int, path: str) -> dict[str, object]:
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    body: dict[str, object] = answer.json()
    problem = Problem.model_validate(body)
    assert (problem.status, problem.instance) == (status, path)
    assert problem.title
    assert problem.detail
    return body


@pytest.mark.parametrize("path", POSES)
@pytest.mark.parametrize("query", ["", "?convention=opencv&frame=camera"])
def test_poses_keep_the_contract(server: Server, path: str, query: str) -> None:
    answer = server.get(path + query)
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "application/json"
    snapshot = PoseSnapshot.model_validate_json(answer.content)
    assert (snapshot.station, snapshot.asset) == ("bench-1", "scripted-asset")
    assert [part.part for part in snapshot.parts] == list(PART_NAMES)
    assert not snapshot.stale
    assert snapshot.captured_at_us <= snapshot.published_at_us
    assert 0 <= snapshot.age_us < 1e6 * STALE_AFTER_S


def test_a_lost_part_has_no_pose(server: Server) -> None:
    parts = {part["part"]: part for part in server.get("/v1/poses").json()["parts"]}
    lost = parts[LOST_PART]
    assert (lost["status"], lost["confidence"]) == ("lost", 0)
    assert {key for key, value in lost.items() if value is None} == {
        "position",
        "orientation",
        "covariance",
        "linear_velocity",
        "angular_velocity",
        "linked_to",
        "last_seen_at_us",
    }


def test_velocity_is_what_the_poses_say(server: Server) -> None:
    snapshot = wait_for(lambda: (it := server.get("/v1/poses").json())["seq"] > 1 and it)
    jaw = snapshot["parts"][1]
    np.testing.assert_allclose(jaw["linear_velocity"][0], X_VELOCITY_M_PER_S, rtol=1e-3)
    np.testing.assert_allclose(jaw["angular_velocity"], 0, atol=1e-6)
    assert jaw["last_seen_at_us"] == snapshot["captured_at_us"]


def test_snapshots_come_at_the_frame_rate_and_the_latest_wins(server: Server) -> None:
    def later_than(seq: int) -> dict[str, Any] | None:
        snapshot: dict[str, Any] = server.get("/v1/poses").json()
        return snapshot if snapshot["seq"] > seq else None

    def rate_hz() -> float:
        first = server.get("/v1/poses").json()
        time.sleep(1)
        second = wait_for(lambda: later_than(first["seq"]))
        assert second["boot_id"] == first["boot_id"]
        seconds = (second["captured_at_us"] - first["captured_at_us"]) / 1e6
        return float((second["seq"] - first["seq"]) / seconds)

    def is_kept() -> bool:
        rate = rate_hz()
        assert rate < 1.01 * FRAME_RATE_HZ  # never more; less where the worker is held up
        return rate > 0.8 * FRAME_RATE_HZ

    wait_for(is_kept)


@pytest.mark.parametrize("path", ["/v1/poses/jaw", "/v1/stations/bench-1/poses/jaw"])
def test_one_part(server: Server, path: str) -> None:
    snapshot = PartSnapshot.model_validate_json(server.get(path).content)
    assert snapshot.pose.part == "jaw"
    assert snapshot.pose.position is not None


@pytest.mark.parametrize("path", [*POSES, "/v1/poses/jaw", "/v1/poses?frame=camera"])
def test_what_the_client_has_is_not_sent_again(server: Server, path: str) -> None:
    def is_not_modified() -> bool:
        etag = server.get(path).headers["etag"]
        answer = server.get(path, headers={"If-None-Match": f'"another", {etag}'})
        assert answer.status_code in (200, 304)
        if answer.status_code == 304:
            assert answer.headers["etag"] == etag
            assert answer.content == b""
        return answer.status_code == 304

    wait_for(is_not_modified)
    assert server.get(path, headers={"If-None-Match": '"another"'}).status_code == 200


def test_an_unknown_part_lists_the_parts_that_exist(server: Server) -> None:
    for path in ("/v1/poses/jew", "/v1/stations/bench-1/poses/jew"):
        problem = assert_problem(server.get(path), 404, path)
        assert problem["type"] == "urn:snapfit:problem:unknown-part"
        assert problem["parts"] == list(PART_NAMES)
        assert "jaw" in str(problem["detail"])


@pytest.mark.parametrize("what", ["", "/poses", "/poses/jaw", "/frame.jpg"])
def test_an_unknown_station_lists_the_stations_that_exist(server: Server, what: str) -> None:
    path = f"/v1/stations/bench-9{what}"
    problem = assert_problem(server.get(path), 404, path)
    assert problem["stations"] == ["bench-1"]


def test_an_unknown_path_is_a_problem(server: Server) -> None:
    assert_problem(server.get("/v1/posess"), 404, "/v1/posess")


@pytest.mark.parametrize("path", ["/v1/poses", "/v1/frame.jpg", "/healthz"])
def test_another_method_is_a_problem(server: Server, path: str) -> None:
    answer = server.client.post(path)
    assert_problem(answer, 405, path)
    assert answer.headers["allow"] == "GET"


@pytest.mark.parametrize("path", ["/v1/poses", "/v1/poses/jaw"])
@pytest.mark.parametrize(
    "query",
    [
        "convention=unreal",
        "convention=",
        "frame=world",
        "convension=opencv",
        "at_us=now",
        "at_us=-1",
        "at_us=1.5",
        "at_us=9007199254740993",
        "after_seq=-1&boot_id=x",
        "after_seq=x&boot_id=x",
        "boot_id=" + 65 * "x",
        "timeout_s=-1",
        "timeout_s=61",
        "timeout_s=nan",
        "timeout_s=inf",
    ],
)
def test_what_cannot_be_given_is_refused(server: Server, path: str, query: str) -> None:
    problem = assert_problem(server.get(f"{path}?{query}"), 422, path)
    assert query.partition("=")[0] in str(problem["detail"])


@pytest.mark.parametrize("path", PICTURES)
def test_pictures_are_jpegs_of_the_latest_frame(server: Server, path: str) -> None:
    import cv2

    before_us = server.get("/v1/poses").json()["captured_at_us"]
    answer = once_there(lambda: server.get(path))
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "image/jpeg"
    assert int(answer.headers["captured-at-us"]) >= before_us
    image = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    assert image.shape == (180, 320, 3)
    top, below = float(image[:8].mean()), float(image[16:].mean())
    assert top > 245 if "overlay" in path else abs(top - below) < 3


def test_a_picture_comes_within_a_tenth_of_a_second(server: Server) -> None:
    def seconds() -> float:
        begin = time.perf_counter()
        assert server.get("/v1/overlay.jpg").status_code in (200, 503)
        return time.perf_counter() - begin

    # The quickest one: this machine may have other things to do.
    assert min(seconds() for _ in range(7)) < within(0.1)


def test_the_station_tells_what_it_is_like(server: Server) -> None:
    info = StationInfo.model_validate_json(server.get("/v1/stations/bench-1").content)
    assert info.facts is not None
    assert info.facts.parts == list(PART_NAMES)
    assert info.facts.frame_rate_hz == FRAME_RATE_HZ
    color, depth = info.facts.cameras
    assert (color.name, color.width, color.height, color.fx) == ("color", 320, 180, 607.2 / 4)
    assert (depth.name, depth.width, depth.distortion) == ("depth", 64, [])
    assert np.array(depth.color_from_camera).shape == (4, 4)
    assert (info.worker.phase, info.worker.restarts) == ("running", 0)
    listed = StationList.model_validate_json(server.get("/v1/stations").content)
    assert [station.station for station in listed.stations] == ["bench-1"]


def test_time_is_the_time_line_of_the_snapshots(server: Server) -> None:
    before = server.get("/v1/poses").json()
    asked_at_us = time.time_ns() / 1000
    now = ServerTime.model_validate_json(server.get("/v1/time").content)
    answered_at_us = time.time_ns() / 1000
    assert before["published_at_us"] < now.received_at_us <= now.sent_at_us
    assert asked_at_us - 1e6 < now.sent_at_us < answered_at_us + 1e6


def test_health(server: Server) -> None:
    assert server.get("/healthz").json()["status"] == "ok"
    wait_for(lambda: server.get("/readyz").json()["status"] == "ready")


def test_the_page_and_all_it_needs_are_served(server: Server) -> None:
    page = server.get("/")
    assert page.status_code == 200
    assert page.headers["content-type"].startswith("text/html")
    for name, kind in (("page.js", "text/javascript"), ("page.css", "text/css")):
        assert f'"./{name}"' in page.text
        answer = server.get(f"/{name}")
        assert answer.status_code == 200
        assert answer.headers["content-type"].startswith(kind)


def test_a_browser_gets_of_the_page_what_it_has_not_got_yet(server: Server) -> None:
    packed = server.get("/three.js")
    plain = server.get("/three.js", headers={"Accept-Encoding": "identity"})
    assert packed.headers["content-encoding"] == "gzip"
    assert "content-encoding" not in plain.headers
    assert packed.content == plain.content
    assert int(packed.headers["content-length"]) < len(plain.content) / 3
    known = server.get("/three.js", headers={"If-None-Match": packed.headers["etag"]})
    assert (known.status_code, known.content) == (304, b"")
    assert server.get("/three.js", headers={"If-None-Match": 'W/"other"'}).status_code == 200


def test_the_document_is_served_and_equals_the_committed_one(server: Server) -> None:
    from pathlib import Path

    committed = Path(__file__).parents[2] / "openapi" / "openapi.json"
    assert server.get("/openapi.json").json() == orjson.loads(committed.read_bytes()), (
        "run `make openapi`"
    )


def test_the_api_process_is_small_and_imports_nothing_heavy(server: Server) -> None:
    from pathlib import Path

    process = Path(f"/proc/{server.process.pid}")
    mapped = (process / "maps").read_text()
    assert "uvloop" in mapped
    for library in ("numba", "llvmlite", "cv2", "open3d", "onnxruntime", "scipy"):
        assert f"/{library}" not in mapped
    status = (process / "status").read_text()
    resident_mb = int(status.partition("VmRSS:")[2].split()[0]) / 1000
    assert resident_mb < 120


def test_api_and_worker_are_as_urgent_as_who_started_them(server: Server) -> None:
    assert os.getpriority(os.PRIO_PROCESS, server.process.pid) == os.nice(0)
    assert os.getpriority(os.PRIO_PROCESS, server.worker()["pid"]) == os.nice(0)


def test_a_worker_is_less_urgent_where_that_is_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SNAPFIT_STATION__NICENESS", "3")
    with running() as server:
        server.wait_ready()
        assert os.getpriority(os.PRIO_PROCESS, server.process.pid) == os.nice(0)
        # Nobody is less urgent than 19.
        urgency = os.getpriority(os.PRIO_PROCESS, server.worker()["pid"])
        assert urgency == min(os.nice(0) + 3, 19)
