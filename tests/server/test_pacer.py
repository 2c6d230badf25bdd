"""When a recording's frames are exposed."""

from __future__ import annotations

import threading

import pytest

from snapfit.server import pacer
from snapfit.server.pacer import Pacer

PERIOD_NS = 100_000_000


class Time:
    """A clock that runs only while somebody waits, or works."""

    def __init__(self) -> None:
        self.now_ns = 7_000_000_000

    def monotonic_ns(self) -> int:
        return self.now_ns


class Waits(threading.Event):
    def __init__(self, time: Time) -> None:
        super().__init__()
        self._time = time

    def wait(self, timeout: float | None = None) -> bool:
        assert timeout is not None
        assert timeout > 0
        self._time.now_ns += round(timeout * 1e9)
        return False


@pytest.mark.parametrize(
    ("work_ms", "exposed_ms"),
    [
        ([10, 10, 10], [100, 200, 300, 400]),
        ([150, 10, 10], [100, 200, 300, 400]),  # late once, in time again
        ([60, 140, 90], [100, 200, 300, 400]),
        ([199, 150, 10], [100, 200, 400, 500]),  # the second time it is too late
        ([250, 10, 10], [100, 300, 400, 500]),  # one frame lost at a camera
        ([430, 10, 10], [100, 500, 600, 700]),
        ([150, 150, 150], [100, 200, 400, 500]),  # delays add up to a frame in the end
    ],
)
def test_frames_keep_their_rhythm(
    monkeypatch: pytest.MonkeyPatch, work_ms: list[int], exposed_ms: list[int]
) -> None:
    time = Time()
    monkeypatch.setattr(pacer, "time", time)
    started_ns = time.now_ns
    paced, stop = Pacer(10.0), Waits(time)
    exposed = [paced.wait(stop)]
    for each in work_ms:
        time.now_ns += each * 1_000_000
        exposed.append(paced.wait(stop))
        assert exposed[-1] <= time.now_ns  # never before its exposure
    assert [(each - started_ns) // 1_000_000 for each in exposed] == exposed_ms
