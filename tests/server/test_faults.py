"""What goes wrong in a shop floor's week, in a minute."""

from __future__ import annotations

import os
import resource
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from event_client import EventClient
from harness import Server, running, wait_for
from patience import within
from scripted_pipeline import END_AFTER_FRAMES
from wall_clock import BACK_S

from snapfit.tracking.recording.reading import OpenRecording

KILLS = 10
LIMIT_S = 60
UNREAD_CLIENTS = 20
PATHS = ("/v1/poses", "/v1/poses/jaw", "/v1/stations", "/v1/stations/bench-1", "/healthz")


class Watcher(threading.Thread):
    """Asks for everything all the time and notes what comes."""

    def __init__(self, server: Server) -> None:
        super().__init__()
        self._base_url = server.client.base_url
        self._ended = threading.Event()
        self.statuses: dict[str, set[int]] = {path: set() for path in (*PATHS, "/readyz")}
        self.stale: set[bool] = set()
        self.rounds = 0

    def run(self) -> None:
        with httpx.Client(base_url=self._base_url, timeout=60) as client:
            while not self._ended.is_set():
                for path, seen in self.statuses.items():
                    answer = client.get(path)
                    seen.add(answer.status_code)
                    if path == "/v1/poses":
                        self.stale.add(answer.json()["stale"])
                self.rounds += 1
                time.sleep(0.02)

    def end(self) -> None:
        self._ended.set()
        self.join()


@contextmanager
def watching(server: Server) -> Iterator[Watcher]:
    watcher = Watcher(server)
    watcher.start()
    try:
        yield watcher
    finally:
        watcher.end()


def fresh(server: Server) -> dict[str, Any] | None:
    poses: dict[str, Any] = server.get("/v1/poses").json()
    return None if poses["stale"] else poses


def is_over(server: Server, boot_id: str) -> bool:
    """Whether this run of the worker is known to be down, or another one is there already."""
    poses = server.get("/v1/poses").json()
    return bool(poses["stale"] or poses["boot_id"] != boot_id)


def test_ten_kills_within_a_minute_cost_nothing_but_freshness() -> None:
    with running() as server:
        server.wait_ready()
        begin_s = time.monotonic()
        boot_ids = set()
        with watching(server) as watcher:
            for _ in range(KILLS):
                before = wait_for(lambda: fresh(server))
                boot_ids.add(before["boot_id"])
                os.kill(wait_for(lambda: server.worker()["pid"]), signal.SIGKILL)
                wait_for(lambda boot_id=before["boot_id"]: is_over(server, boot_id))
            wait_for(lambda: fresh(server))
        assert time.monotonic() - begin_s < within(LIMIT_S)
        assert len(boot_ids) == KILLS
        assert server.worker()["restarts"] == KILLS
    assert watcher.rounds > KILLS
    assert watcher.stale == {True, False}
    for path in PATHS:
        assert watcher.statuses[path] == {200}, path
    assert watcher.statuses["/readyz"] == {200, 503}


def test_a_wall_clock_that_is_set_back_changes_nothing() -> None:
    with running("clock-back") as server:
        server.wait_ready()
        last: dict[str, Any] = server.get("/v1/poses").json()
        last, now_us = go_on(server, last, 0, for_s=1)
        server.process.send_signal(signal.SIGUSR1)
        last, now_us = go_on(server, last, now_us, for_s=2)
        velocity = last["parts"][1]["linear_velocity"][0]
        assert abs(velocity - 0.1) < 0.01
        # A worker that is started only now knows the time from its server.
        with closing(EventClient(server)) as client:
            os.kill(server.worker()["pid"], signal.SIGKILL)
            after = wait_for(lambda: another(server, last["boot_id"]))
            client.wait_for("recovered")
        assert after["captured_at_us"] > last["captured_at_us"]
        told = [event.data["at_us"] for event in client.events]
        times = [now_us, *told, server.get("/v1/time").json()["sent_at_us"]]
        assert times == sorted(times)
        # Proof that it was set back: the header Date is of the wall clock.
        date = httpx.Headers(server.get("/healthz").headers)["date"]
        told_s = time.mktime(time.strptime(date, "%a, %d %b %Y %H:%M:%S GMT")) - time.timezone
        assert abs(time.time() - BACK_S - told_s) < 60


def go_on(
    server: Server, last: dict[str, Any], now_us: int, for_s: float
) -> tuple[dict[str, Any], int]:
    """Time goes forwards for so long; the last poses and the last time."""
    end_s = time.monotonic() + for_s
    while time.monotonic() < end_s:
        poses = server.get("/v1/poses").json()
        assert poses["captured_at_us"] >= last["captured_at_us"]
        is_same = poses["captured_at_us"] == last["captured_at_us"]
        assert (poses["seq"] == last["seq"]) == is_same
        # A machine in use may keep a frame waiting; a clock set back would tell an hour.
        assert 0 <= poses["age_us"] < 1e6 * BACK_S / 60
        assert not poses["stale"] or poses["age_us"] > 400_000
        sent_at_us = server.get("/v1/time").json()["sent_at_us"]
        assert sent_at_us > now_us
        now_us, last = sent_at_us, poses
        time.sleep(0.01)
    return last, now_us


def another(server: Server, boot_id: str) -> dict[str, Any] | None:
    """Fresh poses of another run of the worker."""
    poses = fresh(server)
    return poses if poses and poses["boot_id"] != boot_id else None


def test_a_full_disk_ends_the_recording_and_not_the_tracking(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SNAPFIT_STATION__RECORD", str(tmp_path))
    with running("loose") as server:
        server.wait_ready()
        wait_for(lambda: (it := server.worker()["recording"]) and it["frames"] > 30, 30)
        (path,) = tmp_path.glob("*.mcap")
        # As if the disk were full: the file of this process can grow no more.
        size = path.stat().st_size
        resource.prlimit(server.worker()["pid"], resource.RLIMIT_FSIZE, (size, size))
        recording = wait_for(lambda: (it := server.worker()["recording"])["problem"] and it)
        assert recording["problem"] == f"stopped after {recording['frames']} frames: File too large"
        before = server.get("/v1/poses").json()
        wait_for(lambda: server.get("/v1/poses").json()["seq"] > before["seq"] + 30)
        wait_for(lambda: not server.get("/v1/poses").json()["stale"])
        wait_for(lambda: server.get("/readyz").status_code == 200)
        worker = server.worker()
        assert (worker["restarts"], worker["recording"]) == (0, recording)
        code, _, err = server.end()
    assert code == 0
    assert err.count("tracking goes on") == 1
    assert "Traceback" not in err
    with closing(OpenRecording(path)) as opened:
        written = [each for each in opened.results if each.images is not None]
        assert len(written) == recording["frames"]
        for each in written:
            assert opened.frame(each).color.shape == (180, 320, 3)


def test_a_worker_that_is_slow_to_end_completes_its_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SNAPFIT_STATION__RECORD", str(tmp_path))
    with running("slow-frames") as server:
        wait_for(lambda: server.answers() and server.worker()["frames"] >= END_AFTER_FRAMES, 60)
        # The frame that is waited for holds it up.
        code, _, err = server.end()
    assert (code, err) == (0, "")
    (path,) = tmp_path.glob("*.mcap")
    with closing(OpenRecording(path)) as opened:
        assert opened.problem is None
        assert len(opened.results) >= END_AFTER_FRAMES


def resident_mb(pid: int) -> float:
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.partition("VmRSS:")[2].split()[0]) / 1000


def send_without_reading(client: socket.socket, asks: bytes) -> None:
    """As much as the server takes."""
    client.setblocking(False)
    while asks:
        try:
            asks = asks[client.send(asks) :]
        except (BlockingIOError, ConnectionError):
            return


@pytest.mark.parametrize("unread", [10, 2000])
def test_clients_that_never_read_hold_nobody_up(unread: int) -> None:
    ask = b"GET /v1/frame.jpg HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    with running() as server, ExitStack() as sockets:
        server.wait_ready()
        before_mb = resident_mb(server.process.pid)
        for _ in range(UNREAD_CLIENTS):
            client = socket.create_connection(("127.0.0.1", server.port))
            send_without_reading(sockets.enter_context(client), ask * unread)
        latencies_s = []
        for _ in range(100):
            begin_s = time.perf_counter()
            assert server.get("/v1/poses").status_code == 200
            latencies_s.append(time.perf_counter() - begin_s)
            time.sleep(0.02)
        assert sorted(latencies_s)[50] < within(0.5)
        wait_for(lambda: not server.get("/v1/poses").json()["stale"])
        assert resident_mb(server.process.pid) < before_mb + 30
        sockets.close()
        code, _, err = server.end()
    assert code == 0
    assert "Traceback" not in err
