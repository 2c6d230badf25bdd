"""Speed of the server: python tests/bench/serving.py

Requests a second beside a minimal FastAPI app and a bare Starlette route that answer with the
same bytes ready-made (same uvicorn settings, same run, in turns); then, on `snapfit demo`, the
API's start and size, the worker's frame time under clients, and its return after kill -9.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import psutil
from rich.console import Console
from rich.table import Table

HERE = Path(__file__).parent
SCRIPTED = HERE.parent / "server"
SNAPFIT = Path(sys.executable).with_name("snapfit")
ROUNDS = 5
ROUND_S = 2.0
CONNECTIONS = 16
CLIENTS = 50
CLIENT_RATE_HZ = 30
FRAME_ROUNDS = 3
MEDIAN_WINDOW_S = 11  # the worker gives the median of its last 300 frames
START_LIMIT_S = 300


class Figure(NamedTuple):
    """A measured figure and the bound that it has to keep."""

    name: str
    value: float
    unit: str
    bound: str
    is_kept: bool | None


def run() -> list[Figure]:
    """All figures; takes about two minutes."""
    return [*throughput(), *on_the_demo()]


def throughput() -> list[Figure]:
    """Requests a second of `GET /v1/poses` with 8 parts, and two ratios."""
    ports = {kind: free_port() for kind in ("snapfit", "fastapi", "starlette")}
    with tempfile.TemporaryDirectory() as folder:
        body = Path(folder) / "poses.json"
        with started([SCRIPTED / "serve_scripted.py", ports["snapfit"]], ports["snapfit"]):
            body.write_bytes(get(ports["snapfit"], "/v1/poses"))
            plain = HERE / "plain_apps.py"
            with (
                started([plain, "fastapi", ports["fastapi"], body], ports["fastapi"]),
                started([plain, "starlette", ports["starlette"], body], ports["starlette"]),
            ):
                rates = compare(ports)
    own = rates["snapfit"]
    figures = [
        Figure(f"GET /v1/poses, {kind}", rate, "1/s", "", None) for kind, rate in rates.items()
    ]
    for kind, least in (("fastapi", 0.9), ("starlette", 0.6)):
        ratio = own / rates[kind]
        figures.append(Figure(f"ratio to {kind}", ratio, "", f">= {least}", ratio >= least))
    return figures


def compare(ports: dict[str, int]) -> dict[str, float]:
    """Median requests a second of each server, taken in turns."""
    rates: dict[str, list[float]] = {kind: [] for kind in ports}
    for _ in range(ROUNDS):
        for kind, port in ports.items():
            result = load(port, CONNECTIONS, ROUND_S)
            if result["failures"]:
                raise RuntimeError(f"{kind}: {result['failures']} requests failed")
            rates[kind].append(result["requests"] / result["seconds"])
    return {kind: statistics.median(values) for kind, values in rates.items()}


def on_the_demo() -> list[Figure]:
    """The figures that need the real worker; the demo's caches are made first, if need be."""
    port = free_port()
    with demo(port):
        pass
    begin_s = time.perf_counter()
    with demo(port) as (process, answered_s):
        first_pose_s = time.perf_counter() - begin_s
        resident_mb = psutil.Process(process.pid).memory_info().rss / 1e6
        in_turns = [(frame_ms(port, 0), frame_ms(port, CLIENTS)) for _ in range(FRAME_ROUNDS)]
        recovery_s, found_again_s = kill_worker(port)
    idle_ms, loaded_ms = (statistics.median(each) for each in zip(*in_turns, strict=True))
    rise = loaded_ms / idle_ms - 1
    return [
        Figure("API answers after", answered_s, "s", "< 2", answered_s < 2),
        Figure(
            "all parts found, second start, after", first_pose_s, "s", "< 10", first_pose_s < 10
        ),
        Figure("API resident", resident_mb, "MB", "< 120", resident_mb < 120),
        Figure("frame, nobody asks", idle_ms, "ms", "", None),
        Figure(f"frame, {CLIENTS} clients", loaded_ms, "ms", "", None),
        Figure("rise of the frame time", 100 * rise, "%", "<= 25", rise <= 0.25),
        Figure("fresh again after kill -9", recovery_s, "s", "< 3", recovery_s < 3),
        Figure("all parts found again after kill -9", found_again_s, "s", "", None),
    ]


def frame_ms(port: int, clients: int) -> float:
    """Median tracking time of a frame, while so many clients poll."""
    if clients:
        load(port, clients, MEDIAN_WINDOW_S, CLIENT_RATE_HZ)
    else:
        time.sleep(MEDIAN_WINDOW_S)
    return float(worker(port)["frame_ms"])


def kill_worker(port: int) -> tuple[float, float]:
    """Seconds from kill -9 to the first fresh snapshot, and until all parts are tracked in one."""
    os.kill(worker(port)["pid"], signal.SIGKILL)
    begin_s = time.perf_counter()
    while not json.loads(get(port, "/v1/poses"))["stale"]:
        time.sleep(0.005)
    while json.loads(get(port, "/v1/poses"))["stale"]:
        time.sleep(0.005)
    fresh_s = time.perf_counter() - begin_s
    wait_until_tracked(port)
    return fresh_s, time.perf_counter() - begin_s


def wait_until_tracked(port: int) -> None:
    """Until the parts were found: at the start they are searched for."""
    give_up_at_s = time.perf_counter() + START_LIMIT_S
    while time.perf_counter() < give_up_at_s:
        parts = json.loads(get(port, "/v1/poses"))["parts"]
        if all(part["status"] == "tracked" for part in parts):
            return
        time.sleep(0.01)
    raise RuntimeError(f"no part was found at port {port} within {START_LIMIT_S} s")


def worker(port: int) -> dict[str, Any]:
    report: dict[str, Any] = json.loads(get(port, "/v1/stations"))["stations"][0]["worker"]
    return report


def load(port: int, connections: int, seconds: float, rate_hz: float = 0) -> dict[str, float]:
    command = [sys.executable, HERE / "load.py", port, connections, seconds, rate_hz]
    done = subprocess.run([str(word) for word in command], capture_output=True, check=True)
    result: dict[str, float] = json.loads(done.stdout)
    return result


@contextmanager
def demo(port: int) -> Iterator[tuple[subprocess.Popen[bytes], float]]:
    """`snapfit demo` with all parts found, and how long the API took to answer."""
    with started([SNAPFIT, "demo", "--port", port], port, "/healthz") as it:
        wait_until_answers(port, "/readyz")
        wait_until_tracked(port)
        yield it


@contextmanager
def started(
    command: list[object], port: int, path: str = "/v1/poses"
) -> Iterator[tuple[subprocess.Popen[bytes], float]]:
    """A server that answers, and how long it took to."""
    # As fast as it goes: without the limit of a client.
    limit = {"SNAPFIT_SECURITY__REQUESTS_PER_S": "1000000"}
    paths = filter(None, [str(SCRIPTED), os.environ.get("PYTHONPATH")])
    environment = {**os.environ, **limit, "PYTHONPATH": os.pathsep.join(paths)}
    begin_s = time.perf_counter()
    words = [sys.executable, *(str(word) for word in command)]
    with subprocess.Popen(words, env=environment, stdout=subprocess.DEVNULL) as process:
        try:
            wait_until_answers(port, path, process)
            yield process, time.perf_counter() - begin_s
        finally:
            process.terminate()


def wait_until_answers(
    port: int, path: str, process: subprocess.Popen[bytes] | None = None
) -> None:
    """Until a server is there; not for one whose process has ended."""
    give_up_at_s = time.perf_counter() + START_LIMIT_S
    while time.perf_counter() < give_up_at_s:
        if process is not None and process.poll() is not None:
            raise RuntimeError(f"the server ended with {process.returncode}; it says above why")
        try:
            get(port, path)
        except (urllib.error.URLError, ConnectionError, TimeoutError):
            time.sleep(0.01)
        else:
            return
    raise RuntimeError(f"no answer at port {port} within {START_LIMIT_S} s")


def get(port: int, path: str, timeout_s: float = 5.0) -> bytes:
    with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=timeout_s) as answer:
        body: bytes = answer.read()
        return body


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def table(figures: list[Figure]) -> Table:
    """The figures as a table for people."""
    result = Table("serving", "measured", "wanted", "")
    for figure in figures:
        verdict = {None: "", True: "[green]yes[/green]", False: "[red]NO[/red]"}[figure.is_kept]
        measured = f"{figure.value:,.2f}" if figure.value < 1000 else f"{figure.value:,.0f}"
        result.add_row(figure.name, f"{measured} {figure.unit}", figure.bound, verdict)
    return result


if __name__ == "__main__":
    Console().print(table(run()))
