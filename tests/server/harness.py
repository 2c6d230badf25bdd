"""A real server process on a free loopback port, with the scripted pipeline in its worker."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import cycle
from pathlib import Path
from typing import Any

import httpx
from patience import within

HERE = Path(__file__).parent
SHARED_MEMORY = Path("/dev/shm")
# Seconds, but for machines that have other things to do.
START_LIMIT_S, END_LIMIT_S = 60.0, 60.0


def _ports() -> Iterator[int]:
    """Ports of this process of pytest's alone, below those that the system gives to others."""
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw9").removeprefix("gw"))
    begin = 20_000 + 1000 * (worker % 10)
    yield from cycle(range(begin + os.getpid() % 500, begin + 1000))


_PORTS = _ports()


def free_port() -> int:
    """One that nobody listens on, and that nobody else takes before who asked listens."""
    for port in _PORTS:
        with socket.socket() as probe, suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port
    raise AssertionError("never reached: the ports begin again")


def wait_for(condition: Callable[[], Any], limit_s: float = 30.0) -> Any:
    """The first true value of the condition; gives up `within` the limit, or half a minute."""
    limit_s = within(max(limit_s, 30.0))
    give_up_at_s = time.monotonic() + limit_s
    is_last = False
    # Once more after the limit: this process may have been held up itself.
    while not is_last:
        is_last = time.monotonic() >= give_up_at_s
        value = condition()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError(f"{condition} did not come true within {limit_s:.1f} s")


def with_tests() -> str:
    """PYTHONPATH with the scripted pipeline in it, over what it is already."""
    return os.pathsep.join(filter(None, [str(HERE), os.environ.get("PYTHONPATH")]))


def segments() -> set[str]:
    return {path.name for path in SHARED_MEMORY.glob("snapfit-*")}


def segments_of(pid: int) -> set[str]:
    """The shared memory that a process uses, whatever others on this machine do."""
    return set(re.findall(r"/dev/shm/(snapfit-\w+)", Path(f"/proc/{pid}/maps").read_text()))


def left_behind() -> set[str]:
    """Shared memory that no process uses: whoever made it is gone and did not remove it."""
    names = segments()
    for maps in Path("/proc").glob("[0-9]*/maps"):
        with suppress(OSError):
            names -= set(re.findall(r"/dev/shm/(snapfit-\w+)", maps.read_text()))
    # Whoever used it may have removed it since it was listed.
    return names & segments()


def is_alive(pid: int) -> bool:
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] != "Z"


def once_there(ask: Callable[[], httpx.Response], limit_s: float = 60.0) -> httpx.Response:
    """The first answer that is not 503, which a worker that is held up makes of any question."""
    answer: httpx.Response = wait_for(lambda: (it := ask()).status_code != 503 and it, limit_s)
    return answer


class Said:
    """What a process writes: into files, which never fill up as a pipe that nobody reads does."""

    def __init__(self) -> None:
        self.out, self.err = _nameless_file(), _nameless_file()

    def read(self) -> tuple[str, str]:
        """Standard output and standard error so far."""
        out, err = (os.pread(file, os.fstat(file).st_size, 0) for file in (self.out, self.err))
        return out.decode(), err.decode()

    def close(self) -> None:
        os.close(self.out)
        os.close(self.err)


def _nameless_file() -> int:
    file, name = tempfile.mkstemp()
    Path(name).unlink()
    return file


def wait_or_kill(process: subprocess.Popen[bytes]) -> None:
    """Until it has ended; one that does not end in time is killed, and that is an error."""
    try:
        process.wait(within(END_LIMIT_S))
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        raise


def dropped_clients(server: Server) -> float:
    """How many were dropped because they did not read."""
    text = server.get("/metrics").text
    return float(text.partition("\nsnapfit_dropped_clients_total ")[2].split()[0])


class Server:
    """A running server."""

    def __init__(
        self,
        fault: str = "",
        command: list[str] | None = None,
        more: list[str] | None = None,
        port: int | None = None,
    ) -> None:
        self.port = port or free_port()
        self.started_at_s = time.monotonic()
        self.environment = {**os.environ, "PYTHONPATH": with_tests(), "SCRIPTED_FAULT": fault}
        self.said = Said()
        self.process = subprocess.Popen(
            [*(command or [sys.executable, str(HERE / "serve_scripted.py")]), str(self.port)]
            + (more or []),
            env=self.environment,
            stdout=self.said.out,
            stderr=self.said.err,
        )
        self.client = httpx.Client(base_url=f"http://127.0.0.1:{self.port}", timeout=within(30))
        self._last: tuple[str, str] | None = None

    def get(self, path: str, **arguments: Any) -> httpx.Response:
        return self.client.get(path, **arguments)

    def answers(self) -> bool:
        try:
            return self.get("/healthz").status_code == 200
        except httpx.TransportError:
            return False

    def wait_ready(self) -> Server:
        wait_for(self.answers, START_LIMIT_S)
        wait_for(lambda: self.get("/readyz").status_code == 200, START_LIMIT_S)
        return self

    def worker(self) -> dict[str, Any]:
        worker: dict[str, Any] = self.get("/v1/stations/bench-1").json()["worker"]
        return worker

    def end(self, number: int = signal.SIGTERM) -> tuple[int, str, str]:
        """Exit code, standard output, standard error."""
        self.client.close()
        if self.process.poll() is None:
            self.process.send_signal(number)
        wait_or_kill(self.process)
        if self._last is None:
            self._last = self.said.read()
            self.said.close()
        return self.process.returncode, *self._last


@contextmanager
def running(fault: str = "") -> Iterator[Server]:
    server = Server(fault)
    try:
        yield server
    finally:
        server.end()
