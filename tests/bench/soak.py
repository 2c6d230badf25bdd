"""Whether the server grows: python tests/bench/run.py soak [--minutes 10]

The demo's recording at 60 frames a second, 20 headsets that poll at 60 Hz each and come anew every
minute. Resident memory of the API and of the worker is read every other second. The first minute
warms up (more of them, where the tracker has not been to and fro through the recording by then);
the median of the last minute is compared with that of the first one after it. Takes two minutes
more than it is told.
"""

from __future__ import annotations

import json
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from figure import Figure, at_least, at_most
from frame_count import FrameCount, behind_ms, frames_lost, rate_hz
from growth import Memory, by_minute, growth_percent, memory_of, slope_mb_per_hour
from loaded_server import Generator, LoadedServer
from open_loop import percentile
from rich.console import Console
from rich.table import Table
from serving import (
    SNAPFIT,
    free_port,
    started,
    wait_until_answers,
    wait_until_tracked,
)

from snapfit.models.asset import find_asset
from snapfit.models.workbench.demo import demo_sequence

ASSET = "hobby-corner-clamp"
SOURCE_HZ = 60
CLIENTS, CLIENT_HZ = 20, 60
LEAST_RATE_HZ = 59.0
GROWTH_PERCENT = 2.0
MINUTE_S = 60.0
_SAMPLE_PERIOD_S = 2.0
_LEAST_MINUTES = 2
_WARM_FRAMES = 1000  # the recording has 355


class Soak:
    """Watches the processes of a server while it is asked.

    Attributes:
        memory: of each process, so far.
        rows: of the table, a minute each.
    """

    def __init__(self, server: LoadedServer) -> None:
        self._server = server
        self._pids = {"API": server.api.pid, "worker": server.worker_pid()}
        self.memory: dict[str, list[Memory]] = {name: [] for name in self._pids}
        self.rows: list[tuple[float, int, float]] = []
        self._done = threading.Event()

    def run(self, minutes: int) -> tuple[FrameCount, FrameCount, float]:
        """Warm up, then so many minutes: how far the tracker was at both ends; when they began."""
        watching = threading.Thread(target=self._watch)
        watching.start()
        try:
            self._minute()
            while self._server.frames().seq < _WARM_FRAMES:
                self._minute()
            self.rows.clear()
            first, begin_s = self._server.frames(), time.monotonic()
            for _ in range(minutes):
                self._minute()
            return first, self._server.frames(), begin_s
        finally:
            self._done.set()
            watching.join()

    def _minute(self) -> None:
        """Headsets poll for a minute."""
        end_s = time.monotonic() + MINUTE_S
        first, words = self._server.frames(), (CLIENTS, CLIENT_HZ, MINUTE_S - 3)
        polls = Generator("headsets.py", self._server.port, *words, 0).samples()
        time.sleep(max(end_s - time.monotonic(), 0))
        last = self._server.frames()
        lost = frames_lost(first, last, SOURCE_HZ)
        self.rows.append((rate_hz(first, last), lost, percentile(polls["server_ms"], 99)))

    def _watch(self) -> None:
        while not self._done.wait(_SAMPLE_PERIOD_S):
            for name, pid in self._pids.items():
                self.memory[name].append(memory_of(pid, time.monotonic()))


def run(minutes: int = 10) -> list[Figure]:
    """All figures; prints a table by minutes.

    Raises:
        ValueError: fewer than two minutes, or the worker was started anew meanwhile.
    """
    if minutes < _LEAST_MINUTES:
        raise ValueError(f"a soak takes at least {_LEAST_MINUTES} minutes, not {minutes}")
    with tempfile.TemporaryDirectory() as folder, serving_at_60_hz(Path(folder)) as server:
        soak = Soak(server)
        first, last, begin_s = soak.run(minutes)
    by_minutes = {
        name: by_minute(samples, begin_s)[:minutes] for name, samples in soak.memory.items()
    }
    Console().print(_table(by_minutes, soak.rows))
    what = f"{minutes} minutes at {SOURCE_HZ} frames a second, {CLIENTS} clients"
    figures = [
        at_least(f"{what}: frames a second", rate_hz(first, last), "1/s", LEAST_RATE_HZ),
        Figure(f"{what}: the tracker fell behind by", behind_ms(first, last, SOURCE_HZ), "ms"),
    ]
    for name, held in by_minutes.items():
        grown = growth_percent(held)
        figures.append(Figure(f"{what}: {name}, resident at the end", held[-1].resident_mb, "MB"))
        figures.append(at_most(f"{what}: {name} grew by", grown, "%", GROWTH_PERCENT))
        slope = slope_mb_per_hour(held)
        figures.append(Figure(f"{what}: {name}, median slope", slope, "MB/h"))
    return figures


@contextmanager
def serving_at_60_hz(folder: Path) -> Iterator[LoadedServer]:
    """A station that plays the demo's recording twice as fast, with all parts found."""
    recording = _faster(demo_sequence(find_asset(ASSET)), folder)
    config = folder / "snapfit.toml"
    config.write_text(f'[station]\nsource = "{recording}"\nasset = "{ASSET}"\n')
    port = free_port()
    command = [SNAPFIT, "serve", "--config", config, "--port", port]
    with started(command, port, "/healthz") as (process, _):
        wait_until_answers(port, "/readyz")
        wait_until_tracked(port)
        yield LoadedServer(port, process.pid)


def _faster(demo: Path, folder: Path) -> Path:
    """The same images at another frame rate."""
    recording = folder / "demo"
    recording.mkdir()
    told = json.loads((demo / "sequence.json").read_text())
    (recording / "sequence.json").write_text(json.dumps({**told, "fps": SOURCE_HZ}))
    for name in ("color", "depth"):
        (recording / name).symlink_to(demo / name)
    return recording


def _table(memory: dict[str, list[Memory]], rows: list[tuple[float, int, float]]) -> Table:
    table = Table(title="soak, medians by minute")
    for column in ("minute", "frames/s", "lost", "poll p99, ms"):
        table.add_column(column, justify="right")
    for name in memory:
        table.add_column(f"{name}, MB", justify="right")
        table.add_column("of no file", justify="right")
    for place, (rate, lost, p99_ms) in enumerate(rows):
        cells = [f"{place + 1}", f"{rate:.1f}", f"{lost}", f"{p99_ms:.1f}"]
        for held in memory.values():
            cells += [f"{held[place].resident_mb:.1f}", f"{held[place].own_mb:.1f}"]
        table.add_row(*cells)
    return table
