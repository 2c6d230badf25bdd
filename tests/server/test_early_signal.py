"""A signal that comes while the server starts ends it, and leaves nothing behind."""

from __future__ import annotations

import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from harness import Server, free_port, is_alive, segments, segments_of, wait_for

Moment = Callable[[int], object]


def handles_signals(pid: int) -> bool:
    """Whether the process has set what SIGTERM does; Python sets SIGINT alone by itself."""
    status = Path(f"/proc/{pid}/status").read_text()
    caught = int(status.partition("SigCgt:")[2].split()[0], 16)
    return bool(caught >> (signal.SIGTERM - 1) & 1)


def children_of(pid: int) -> set[int]:
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    return {int(child) for task in tasks for child in task.read_text().split()}


def watched_end(process: subprocess.Popen[bytes]) -> tuple[set[str], set[int]]:
    """Shared memory and children that the process had until it ended."""
    own: set[str] = set()
    children: set[int] = set()

    def look() -> bool:
        with suppress(OSError):  # gone meanwhile
            own.update(segments_of(process.pid))
            children.update(children_of(process.pid))
        return process.poll() is not None

    wait_for(look)
    return own, children


@pytest.mark.parametrize(
    ("moment", "later_s", "number"),
    [
        (handles_signals, 0.0, signal.SIGTERM),
        (handles_signals, 0.0, signal.SIGINT),
        (handles_signals, 0.1, signal.SIGTERM),
        (handles_signals, 0.4, signal.SIGINT),
        (segments_of, 0.0, signal.SIGTERM),
        (children_of, 0.0, signal.SIGINT),
    ],
)
def test_it_ends_in_order(moment: Moment, later_s: float, number: signal.Signals) -> None:
    server = Server(more=[str(free_port())])
    process = server.process
    try:
        wait_for(lambda: moment(process.pid))
        time.sleep(later_s)
        process.send_signal(number)
        own, children = watched_end(process)
        code, _, err = server.end()
        assert (code, err) == (0, "")
        assert not own & segments()
        # Python's own helper for shared memory ends when it sees that the server has.
        wait_for(lambda: not any(map(is_alive, children)))
    finally:
        server.end()
