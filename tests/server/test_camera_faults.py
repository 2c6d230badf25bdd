"""A camera that delivers what no camera in order does: told, not tracked, and got over."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import scripted_camera
from event_client import EventClient
from harness import Server, dropped_clients, running, wait_for
from patience import within

SILENT_S = 5.0


@pytest.fixture(scope="module")
def orders(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the camera does."""
    path = tmp_path_factory.mktemp("camera") / "orders"
    path.write_text("fine")
    return path


@pytest.fixture(scope="module")
def station(orders: Path) -> Iterator[Server]:
    """A station with that camera."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(scripted_camera.VARIABLE, str(orders))
        with running("camera") as server:
            yield server.wait_ready()


def tell(orders: Path, order: str) -> None:
    """At once: nobody reads half a word."""
    beside = orders.with_suffix(".new")
    beside.write_text(order)
    beside.replace(orders)


@pytest.mark.parametrize(
    ("order", "problem"),
    [
        ("frozen", "the camera delivers the same image again and again: it hangs"),
        ("black", "the colour image is black: is the lens covered, or the light out?"),
        ("half", "the lower part of the colour image is missing: the transfer broke off"),
        ("silent", "has delivered nothing for 5 s"),
    ],
)
def test_a_fault_of_the_camera_is_told_and_got_over(
    station: Server, orders: Path, order: str, problem: str
) -> None:
    before = station.worker()
    client = EventClient(station)
    tell(orders, order)
    told = wait_for(lambda: problem in (last_problem(station) or "") and last_problem(station))
    held = wait_for(lambda: (it := station.get("/v1/poses").json())["stale"] and it)
    client.wait_for("stale")
    assert station.get("/readyz").status_code == 503
    assert station.get("/healthz").status_code == 200
    # Nothing is made up meanwhile: the last poses stay, and are said to be stale.
    later = station.get("/v1/poses").json()
    assert (later["stale"], later["seq"]) == (True, held["seq"])
    assert later["captured_at_us"] == held["captured_at_us"]
    assert later["age_us"] > held["age_us"]
    assert later["parts"] == held["parts"]
    assert station.worker()["bad_frames"] > before["bad_frames"]
    if order == "silent":
        assert later["age_us"] > 1e6 * SILENT_S
        assert "is gone" in told
    tell(orders, "fine")
    wait_for(lambda: client.kinds()[-1:] == ["recovered"])
    client.close()
    # More than once where the worker was held up besides.
    assert client.kinds() == ["stale", "recovered"] * (len(client.kinds()) // 2)
    wait_for(lambda: station.get("/readyz").status_code == 200)
    after = wait_for(lambda: not (it := station.get("/v1/poses").json())["stale"] and it)
    assert after["seq"] > held["seq"]
    assert after["captured_at_us"] > held["captured_at_us"]
    assert (station.worker()["restarts"], after["boot_id"]) == (0, held["boot_id"])


def last_problem(station: Server) -> str | None:
    problem: str | None = station.worker()["last_bad_frame"]
    return problem


def test_who_does_not_read_the_film_is_dropped_and_tracking_goes_on(station: Server) -> None:
    """Here, because this camera's noise fills what the system buffers in a second."""
    ask = b"GET /v1/overlay.mjpeg HTTP/1.1\r\nHost: x\r\n\r\n"
    before = dropped_clients(station)
    with socket.create_connection(("127.0.0.1", station.port), timeout=5) as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        client.sendall(ask)
        ages_us = []
        give_up_at_s = time.monotonic() + within(60)
        while dropped_clients(station) == before:
            assert time.monotonic() < give_up_at_s
            ages_us.append(station.get("/v1/poses").json()["age_us"])
            time.sleep(0.05)
    assert dropped_clients(station) == before + 1
    assert sorted(ages_us)[len(ages_us) // 2] < 200_000 * within(1)
    wait_for(lambda: not station.get("/v1/poses").json()["stale"])
