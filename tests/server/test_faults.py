"""What goes wrong in a shop floor's week, in a minute."""

from __future__ import annotations

import os
import resource
import signal
import socket
import threading
import time
from contextlib import ExitStack, closing
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


def test_ten_kills_within_a_minute_cost_nothing_but_freshness() -> None:
    with running() as server:
        server.wait_ready()
        watcher = Watcher(server)
        watcher.start()
        begin_s = time.monotonic()
        boot_ids = set()
        for _ in range(KILLS):
            before = wait_for(lambda: not (it := server.get("/v1/poses").json())["stale"] and it)
            boot_ids.add(before["boot_id"])
            os.kill(wait_for(lambda: server.worker()["pid"]), signal.SIGKILL)
            wait_for(lambda: server.get("/v1/poses").json()["stale"], 5)
        wait_for(lambda: not server.get("/v1/poses").json()["stale"])
        assert time.monotonic() - begin_s < within(LIMIT_S)
        watcher.end()
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
        back_s = time.monotonic() + 1
        end_s = back_s + 2
        last: dict[str, Any] = server.get("/v1/poses").json()
        now_us, is_back = 0, False
        while (now_s := time.monotonic()) < end_s:
            if now_s > back_s and not is_back:
                server.process.send_signal(signal.SIGUSR1)
                is_back = True
            poses = server.get("/v1/poses").json()
            assert poses["captured_at_us"] >= last["captured_at_us"]
            assert (poses["seq"] == last["seq"]) == (
                poses["captured_at_us"] == last["captured_at_us"]
            )
            # A machine in use may keep a frame waiting; a clock set back would tell years.
            assert 0 <= poses["age_us"] < 1e6 * within(0.5)
            assert not poses["stale"] or poses["age_us"] > 400_000
            sent_at_us = server.get("/v1/time").json()["sent_at_us"]
            assert sent_at_us > now_us
            now_us, last = sent_at_us, poses
            time.sleep(0.01)
        velocity = last["parts"][1]["linear_velocity"][0]
        assert abs(velocity - 0.1) < 0.01
        # A worker that is started only now knows the time from its server.
        with closing(EventClient(server)) as client:
            os.kill(server.worker()["pid"], signal.SIGKILL)
            client.wait_for("recovered", 30)
        after = server.get("/v1/poses").json()
        assert after["boot_id"] != last["boot_id"]
        assert after["captured_at_us"] > last["captured_at_us"]
        told = [event.data["at_us"] for event in client.events]
        times = [now_us, *told, server.get("/v1/time").json()["sent_at_us"]]
        assert times == sorted(times)
        # Proof that it was set back: the header Date is of the wall clock.
        date = httpx.Headers(server.get("/healthz").headers)["date"]
        told_s = time.mktime(time.strptime(date, "%a, %d %b %Y %H:%M:%S GMT")) - time.timezone
        assert abs(time.time() - BACK_S - told_s) < 60


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
        assert not server.get("/v1/poses").json()["stale"]
        assert server.get("/readyz").status_code == 200
        worker = server.worker()
        assert (worker["restarts"], worker["recording"]) == (0, recording)
        code, _, err = server.end()
    assert code == 0
    assert err.count("tracking goes on") == 1
    assert "Traceback" not in err
    with closing(OpenRecording(path)) as opened:
        assert len(opened.results) == recording["frames"]
        for each in opened.results:
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
        assert not server.get("/v1/poses").json()["stale"]
        assert resident_mb(server.process.pid) < before_mb + 30
        sockets.close()
        code, _, err = server.end()
    assert code == 0
    assert "Traceback" not in err
