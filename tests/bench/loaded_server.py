"""A server under load: what its processes take, how far its tracker is, what time it is there."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import psutil
from clock_offset import Exchange, clock_ahead_us
from frame_count import FrameCount
from serving import get, worker
from wire import now_us

HERE = Path(__file__).parent
_EXCHANGES = 50
_PATIENCE_S = 60.0  # a busy machine is measured as it is


class LoadedServer:
    """A running server, by its port and its API's process."""

    def __init__(self, port: int, pid: int) -> None:
        self.port = port
        self.api = psutil.Process(pid)

    def frames(self) -> FrameCount:
        """How far the tracker is now."""
        return FrameCount.of(self.json("/v1/poses"))

    def worker_pid(self) -> int:
        """Of the process that tracks."""
        return int(worker(self.port)["pid"])

    def source_hz(self) -> float:
        """The rate that frames are due at."""
        station = self.json("/v1/stations")["stations"][0]
        return float(station["facts"]["frame_rate_hz"])

    def json(self, path: str) -> dict[str, Any]:
        """What a GET answers."""
        answer: dict[str, Any] = json.loads(get(self.port, path, _PATIENCE_S))
        return answer

    def clock_ahead_us(self) -> tuple[int, int]:
        """By how much the server's clock is ahead of this machine's; how far off that may be."""
        exchanges = []
        for _ in range(_EXCHANGES):
            asked_us = now_us()
            answer = self.json("/v1/time")
            stamps = answer["received_at_us"], answer["sent_at_us"]
            exchanges.append(Exchange(asked_us, *stamps, now_us()))
        return clock_ahead_us(exchanges)


def cpu_s(process: psutil.Process) -> float:
    """What a process has used so far, seconds of one core."""
    times = process.cpu_times()
    return float(times.user + times.system)


class Generator:
    """A load generator in a process of its own; its samples, once it has ended."""

    def __init__(self, script: str, *words: object) -> None:
        command = [sys.executable, str(HERE / script), *(str(word) for word in words)]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE)

    def samples(self) -> dict[str, Any]:
        """Wait for them.

        Raises:
            RuntimeError: it failed.
        """
        out, _ = self._process.communicate()
        if self._process.returncode:
            raise RuntimeError(f"{self._process.args!r} ended with {self._process.returncode}")
        result: dict[str, Any] = json.loads(out)
        return result


@contextmanager
def changing_states(server: LoadedServer, period_s: float) -> Iterator[None]:
    """Meanwhile an operator takes back the last step, gives it again, and so on.

    The parts are in their places all the time, so that nothing disturbs the tracker. While no step
    is done yet there is nothing to take back.
    """
    operator = _Operator(server)
    done = threading.Event()

    def change() -> None:
        while not done.wait(period_s):
            operator.change()

    thread = threading.Thread(target=change)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


class _Operator:
    """Takes back the last step, or gives back what was taken."""

    def __init__(self, server: LoadedServer) -> None:
        self._server = server
        steps = server.json("/v1/steps")["steps"]
        self._before = {step["to_state"]: step["from_state"] for step in steps}
        self._taken: str | None = None

    def change(self) -> None:
        """One order, if there is anything to order."""
        state = self._server.json("/v1/assembly")["state"]
        taken, self._taken = self._taken, None
        if taken is not None and self._before[taken] == state:
            _put_state(self._server.port, taken)
        elif state in self._before:
            self._taken = state
            _put_state(self._server.port, self._before[state])


def _put_state(port: int, state: str) -> None:
    """Say which state holds; a worker that does not answer in time is asked again next time."""
    url = f"http://127.0.0.1:{port}/v1/assembly/state"
    body, headers = json.dumps({"state": state}).encode(), {"Content-Type": "application/json"}
    order = urllib.request.Request(url, body, headers, method="PUT")
    try:
        urllib.request.urlopen(order, timeout=_PATIENCE_S).close()
    except urllib.error.HTTPError as error:
        if error.code != 503:
            raise
