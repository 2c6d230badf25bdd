"""The server under load, beside a tracker at 30 frames a second: python tests/bench/run.py load

On one machine: `snapfit demo`; a bare Starlette app with ready-made bytes, as urgent as the API;
one load generator at a time. 50 headsets poll poses at 60 Hz each, at both servers in turns.
Then 200 long-pollers and 50 listeners to events are told of state changes, by both servers; then
both kinds at once. At last the worker is stopped for a moment: lost frames have to show. Takes
under three minutes.
"""

from __future__ import annotations

import math
import os
import signal
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import psutil
from figure import Figure, at_least, at_most
from frame_count import FrameCount, frames_lost, rate_hz
from loaded_server import Generator, LoadedServer, changing_states, cpu_s
from open_loop import percentile
from serving import HERE, demo, free_port, get, started

HEADSETS, HEADSET_HZ = 50, 60
POLLERS, LISTENERS = 200, 50
POLL_ROUNDS, POLL_S = 3, 10.0
LISTEN_S, PLAIN_LISTEN_S = 30.0, 15.0
TOGETHER_S = 20.0
IDLE_S = 5.0
CHANGE_PERIOD_S = 0.7
POLL_P99_MS, TOLD_P99_MS = 15.0, 20.0
BEYOND_A_FRAME_MS = 10.0
LEAST_CHANGES, LEAST_CHANGES_TOGETHER = 10, 5
STOP_S = 0.2


class Round(NamedTuple):
    """One stretch of load.

    Attributes:
        samples: of the load generator.
        cpu_s: what the server's process used meanwhile.
        first, last: how far the tracker was at both ends.
    """

    samples: dict[str, Any]
    cpu_s: float
    first: FrameCount
    last: FrameCount


class Bench:
    """A tracking server, and a bare Starlette app beside it."""

    def __init__(self, server: LoadedServer, plain: LoadedServer) -> None:
        self.server = server
        self._plain = plain
        self.source_hz = server.source_hz()
        self._ahead_us, self.clock_error_us = server.clock_ahead_us()

    def idle(self, seconds: float) -> Round:
        """Nobody asks."""
        first, before_s = self.server.frames(), cpu_s(self.server.api)
        time.sleep(seconds)
        used_s = cpu_s(self.server.api) - before_s
        return Round({}, used_s, first, self.server.frames())

    def polled(self, seconds: float, *, plain: bool = False) -> Round:
        """Headsets poll."""
        return self._round("headsets.py", plain, HEADSETS, HEADSET_HZ, seconds)

    def told(self, seconds: float, *, plain: bool = False) -> Round:
        """States change, and listeners are told; the bare app changes its own by itself."""
        words = (POLLERS, LISTENERS, seconds)
        if plain:
            return self._round("listeners.py", plain, *words)
        with changing_states(self.server, CHANGE_PERIOD_S):
            return self._round("listeners.py", plain, *words)

    def together(self, seconds: float) -> tuple[Round, Round]:
        """Both at once, at the tracking server."""
        port = self.server.port
        polling = Generator("headsets.py", port, HEADSETS, HEADSET_HZ, seconds, self._ahead_us)
        told = self.told(seconds)
        return Round(polling.samples(), told.cpu_s, told.first, told.last), told

    def _round(self, script: str, plain: bool, *words: object) -> Round:
        asked = self._plain if plain else self.server
        ahead_us = 0 if plain else self._ahead_us
        first, before_s = self.server.frames(), cpu_s(asked.api)
        samples = Generator(script, asked.port, *words, ahead_us).samples()
        return Round(samples, cpu_s(asked.api) - before_s, first, self.server.frames())


def run() -> list[Figure]:
    """All figures."""
    with bench() as it:
        idle = it.idle(IDLE_S)
        polled, plainly_polled = [], []
        for _ in range(POLL_ROUNDS):
            polled.append(it.polled(POLL_S))
            plainly_polled.append(it.polled(POLL_S / 2, plain=True))
        told, plainly_told = it.told(LISTEN_S), it.told(PLAIN_LISTEN_S, plain=True)
        both = it.together(TOGETHER_S)
        stopped = _stop_worker(it)
    hz = it.source_hz
    name = f"{HEADSETS} headsets at {HEADSET_HZ} Hz"
    return [
        Figure("error of the clocks' comparison, at most", it.clock_error_us / 1e3, "ms"),
        *_frames("nobody asks", [idle], hz, bound=False),
        *_polls(name, polled, hz),
        *_frames(name, polled, hz),
        *_beside("poll", ("server_ms",), polled, plainly_polled),
        *_told(f"{POLLERS} long-pollers, {LISTENERS} event listeners", told, LEAST_CHANGES),
        *_frames("the same", [told], hz),
        *_beside("change told", ("poll_ms", "event_ms"), [told], [plainly_told]),
        *_polls("all at once", [both[0]], hz),
        *_told("all at once", both[1], LEAST_CHANGES_TOGETHER),
        *_frames("all at once", [both[1]], hz),
        at_least(f"control: lost where the worker stood still for {STOP_S:g} s", stopped, "", 4),
    ]


@contextmanager
def bench() -> Iterator[Bench]:
    """The demo, with all parts found, and the bare app with one of its answers."""
    port, plain_port = free_port(), free_port()
    with demo(port) as (process, _), tempfile.TemporaryDirectory() as folder:
        body = Path(folder) / "poses.json"
        body.write_bytes(get(port, "/v1/poses"))
        command = [HERE / "plain_apps.py", "starlette", plain_port, body]
        with started(command, plain_port) as (plain, _):
            server = LoadedServer(port, process.pid)
            yield Bench(server, LoadedServer(plain_port, plain.pid))


def _stop_worker(it: Bench) -> int:
    """Frames lost where the worker stands still for a moment: a check of the check."""
    process = psutil.Process(it.server.worker_pid())
    first = it.server.frames()
    os.kill(process.pid, signal.SIGSTOP)
    time.sleep(STOP_S)
    os.kill(process.pid, signal.SIGCONT)
    time.sleep(1.0)
    return frames_lost(first, it.server.frames(), it.source_hz)


def _all(rounds: list[Round], key: str) -> list[float]:
    return [value for each in rounds for value in each.samples[key]]


def _frames(what: str, rounds: list[Round], hz: float, *, bound: bool = True) -> list[Figure]:
    rate = statistics.median(rate_hz(each.first, each.last) for each in rounds)
    lost = sum(frames_lost(each.first, each.last, hz) for each in rounds)
    name = f"{what}: frames lost by the tracker"
    figure = at_most(name, lost, "", 0) if bound else Figure(name, lost, "")
    return [Figure(f"{what}: frames a second", rate, "1/s"), figure]


def _polls(what: str, rounds: list[Round], hz: float) -> list[Figure]:
    server_ms = _all(rounds, "server_ms")
    failures = sum(each.samples["failures"] for each in rounds)
    unanswered = sum(math.isinf(value) for value in server_ms)
    age_ms = _all(rounds, "age_ms")
    late_ms = percentile(_all(rounds, "late_ms"), 99)
    whole_ms = percentile(_all(rounds, "whole_ms"), 99)
    age_bound_ms = round(1e3 / hz + BEYOND_A_FRAME_MS, 1)
    return [
        Figure(f"{what}: polls", len(server_ms), ""),
        at_most(f"{what}: polls refused or unanswered", failures + unanswered, "", 0),
        Figure(f"{what}: a poll, median", percentile(server_ms, 50), "ms"),
        at_most(f"{what}: a poll, p99", percentile(server_ms, 99), "ms", POLL_P99_MS),
        Figure(f"{what}: with the generator's own lateness, p99", whole_ms, "ms"),
        Figure(f"{what}: the generator's own lateness, p99", late_ms, "ms"),
        at_most(f"{what}: age of the pose, median", percentile(age_ms, 50), "ms", age_bound_ms),
        Figure(f"{what}: age of the pose, p99", percentile(age_ms, 99), "ms"),
    ]


def _told(what: str, told: Round, least_changes: int) -> list[Figure]:
    samples = told.samples
    delays = {"long poll": samples["poll_ms"], "event": samples["event_ms"]}
    missed = sum(math.isinf(value) for values in delays.values() for value in values)
    figures = [
        at_least(f"{what}: state changes", samples["changes"], "", least_changes),
        Figure(f"{what}: of these with an uncertain publication", samples["inexact"], ""),
    ]
    if not samples["changes"]:
        return figures
    figures.append(at_most(f"{what}: changes missed", missed + samples["failures"], "", 0))
    for kind, values in delays.items():
        name = f"{what}: {kind} told after"
        figures.append(Figure(f"{name}, median", percentile(values, 50), "ms"))
        figures.append(at_most(f"{name}, p99", percentile(values, 99), "ms", TOLD_P99_MS))
    return figures


def _beside(
    what: str, keys: tuple[str, ...], ours: list[Round], plain: list[Round]
) -> list[Figure]:
    """Beside the bare Starlette routes: the delay, and the processor's time an answer."""
    (own, own_us), (bare, bare_us) = (_cost(rounds, keys) for rounds in (ours, plain))
    if not own or not bare:
        return []
    own_ms, bare_ms = percentile(own, 99), percentile(bare, 99)
    return [
        Figure(f"bare Starlette: {what}, p99", bare_ms, "ms"),
        Figure(f"{what}, p99, ratio to it", own_ms / bare_ms, ""),
        Figure(f"{what}: processor time of the API, each", own_us, "us"),
        Figure(f"{what}: processor time, ratio", own_us / bare_us, ""),
    ]


def _cost(rounds: list[Round], keys: tuple[str, ...]) -> tuple[list[float], float]:
    """All delays, ms, and the processor's time for each answer that came, us."""
    values = [value for key in keys for value in _all(rounds, key)]
    answers = sum(math.isfinite(value) for value in values)
    return values, 1e6 * sum(each.cpu_s for each in rounds) / max(answers, 1)
