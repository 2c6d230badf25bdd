"""Several benches in one server, each with its own worker and store."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from contextlib import suppress

import httpx
import pytest
from harness import Server, once_there, running, segments_of, wait_for

from snapfit.clients.python import Client, WhichStationError

NAMES = ["left", "right"]


@pytest.fixture(scope="module")
def two() -> Iterator[Server]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SNAPFIT_STATIONS", json.dumps([{"name": name} for name in NAMES]))
        with running() as server:
            yield server.wait_ready()


def test_all_are_listed_with_workers_and_stores_of_their_own(two: Server) -> None:
    stations = two.get("/v1/stations").json()["stations"]
    assert [station["station"] for station in stations] == NAMES
    assert len({station["worker"]["pid"] for station in stations}) == len(NAMES)
    assert len(segments_of(two.process.pid)) == 2 * len(NAMES)


def test_each_has_its_own_poses(two: Server) -> None:
    snapshots = [two.get(f"/v1/stations/{name}/poses").json() for name in NAMES]
    assert [snapshot["station"] for snapshot in snapshots] == NAMES
    assert snapshots[0]["boot_id"] != snapshots[1]["boot_id"]
    assert two.get("/v1/stations/left/poses/jaw").json()["station"] == "left"
    assert once_there(lambda: two.get("/v1/stations/right/frame.jpg")).status_code == 200


def test_the_python_client_says_which_station(two: Server) -> None:
    url = f"http://127.0.0.1:{two.port}"
    with Client(url) as client, Client(url, station="right") as right:
        for ask in (client.poses, client.info, client.frame_jpeg):
            with pytest.raises(WhichStationError, match="station=") as which:
                ask()
            assert which.value.names == tuple(NAMES)
        assert client.at("left").poses().station == "left"
        assert right.poses().station == right.info().station == "right"


@pytest.mark.parametrize("path", ["/v1/poses", "/v1/poses/jaw", "/v1/frame.jpg"])
def test_the_short_paths_say_what_to_ask_for(two: Server, path: str) -> None:
    answer = two.get(path)
    assert answer.status_code == 404
    problem = answer.json()
    assert problem["type"] == "urn:snapfit:problem:which-station"
    assert problem["stations"] == NAMES
    assert "/v1/stations/NAME/" in problem["detail"]


def test_one_that_dies_leaves_the_other_alone(two: Server) -> None:
    def info(name: str) -> dict[str, dict[str, object]]:
        found: dict[str, dict[str, object]] = two.get(f"/v1/stations/{name}").json()
        return found

    before = info("right")["worker"]
    left = int(str(info("left")["worker"]["pid"]))
    os.kill(left, signal.SIGSTOP)  # down for long enough to be looked at
    wait_for(lambda: two.get("/v1/stations/left/poses").json()["stale"])
    wait_for(lambda: not two.get("/v1/stations/right/poses").json()["stale"])
    wait_for(lambda: is_unready_for_the_left_one(two.get("/readyz")))
    with suppress(ProcessLookupError):  # the server has killed it for its silence
        os.kill(left, signal.SIGKILL)
    wait_for(lambda: two.get("/readyz").status_code == 200)
    after = info("right")["worker"]
    assert (after["pid"], after["restarts"]) == (before["pid"], 0)
    assert info("left")["worker"]["restarts"] == 1


def is_unready_for_the_left_one(ready: httpx.Response) -> bool:
    """And for no other: one that was held up for a moment is named too."""
    detail: str = ready.json().get("detail", "")
    return ready.status_code == 503 and "left:" in detail and "right:" not in detail
