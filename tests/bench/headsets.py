"""Headsets that poll poses, each at its own pace: a load generator in a process of its own.

python headsets.py PORT CLIENTS RATE_HZ SECONDS CLOCK_AHEAD_US: polls at fixed times (see
`open_loop`) over one keep-alive connection each, without pipelining. Of five headsets two ask
plainly, two for Unity's axes, one for OpenXR's and for nothing if nothing is new. CLOCK_AHEAD_US:
by how much the server's clock is ahead of this machine's. Prints JSON.
"""

from __future__ import annotations

import itertools
import json
import os
import resource
import select
import sys
import time
from collections import deque

from open_loop import Poll, Rounds
from wire import NICENESS, Wire, now_us, number_after, request, status

_LAST_ANSWERS_S = 2.0
_LEAD_US = 200_000
_PATH = "/v1/poses"
_MIX = ("", "", "?convention=unity", "?convention=unity", "?convention=openxr")
_ONLY_NEW = "?convention=openxr"
_ETAG = b"\r\netag: "
_CAPTURED = b'"captured_at_us":'


class Headset:
    """One client; `polls` are those that are over."""

    def __init__(self, port: int, epoll: select.epoll, query: str, ahead_us: int) -> None:
        self.wire = Wire(port, epoll)
        self._ahead_us = ahead_us
        self._path = _PATH + query
        self._request = request(self._path)
        self._asks_only_new = query == _ONLY_NEW
        self._waiting: deque[int] = deque()
        self._asked: tuple[int, int, int] | None = None
        self._free_us = 0
        self._captured_us: int | None = None
        self.polls: list[Poll] = []
        self.not_modified = 0
        self.failures = 0

    def due(self, due_us: int) -> None:
        """It is time for a poll: now, or when the last one is answered."""
        self._waiting.append(due_us)
        if self._asked is None:
            self._send()

    def take(self) -> None:
        """Something came in."""
        response = self.wire.response()
        if response is None or self._asked is None:
            return
        received_us = self._free_us = self.wire.received_us
        self._understand(response)
        self.polls.append(Poll(*self._asked, received_us, self._captured_us))
        self._asked = None
        if self._waiting:
            self._send()

    @property
    def waits(self) -> bool:
        """Whether an answer is still to come."""
        return self._asked is not None

    def end(self) -> None:
        """What is unanswered by now stays so."""
        if self._asked is not None:
            self.polls.append(Poll(*self._asked, None))
        self.polls += [Poll(due_us, due_us, due_us, None) for due_us in self._waiting]
        self.wire.close()

    def _send(self) -> None:
        self.wire.send(self._request)
        self._asked = (self._waiting.popleft(), self._free_us, now_us())

    def _understand(self, response: bytes) -> None:
        code = status(response)
        if code == 200:
            self._captured_us = number_after(response, _CAPTURED) - self._ahead_us
            if self._asks_only_new and (at := response.find(_ETAG)) >= 0:
                etag = response[at + len(_ETAG) :].split(b"\r", 1)[0].decode()
                self._request = request(self._path, {"If-None-Match": etag})
        elif code == 304:
            self.not_modified += 1
        else:
            self.failures += 1


def poll(port: int, clients: int, rate_hz: float, seconds: float, ahead_us: int) -> list[Headset]:
    """Let them poll; what each has seen."""
    epoll = select.epoll()
    mix = itertools.islice(itertools.cycle(_MIX), clients)
    headsets = [Headset(port, epoll, query, ahead_us) for query in mix]
    by_file = {headset.wire.fileno(): headset for headset in headsets}
    rounds = Rounds(now_us() + _LEAD_US, clients, rate_hz, seconds)
    while (next_us := rounds.next_us) is not None:
        for file, _ in epoll.poll(max(next_us - now_us(), 0) / 1e6):
            by_file[file].take()
        for place, due_us in rounds.due(now_us()):
            headsets[place].due(due_us)
    give_up_at_s = time.monotonic() + _LAST_ANSWERS_S
    while any(headset.waits for headset in headsets) and time.monotonic() < give_up_at_s:
        for file, _ in epoll.poll(_LAST_ANSWERS_S):
            by_file[file].take()
    for headset in headsets:
        headset.end()
    return headsets


def samples(headsets: list[Headset]) -> dict[str, object]:
    """All that was measured; infinite where no answer came."""
    polls = [each for headset in headsets for each in headset.polls]
    used = resource.getrusage(resource.RUSAGE_SELF)
    return {
        "server_ms": [each.server_ms for each in polls],
        "whole_ms": [each.whole_ms for each in polls],
        "late_ms": [each.late_ms for each in polls],
        "age_ms": [each.age_ms for each in polls],
        "not_modified": sum(headset.not_modified for headset in headsets),
        "failures": sum(headset.failures for headset in headsets),
        "cpu_s": used.ru_utime + used.ru_stime,
    }


if __name__ == "__main__":
    os.nice(NICENESS)
    a_port, n_clients, ahead = int(sys.argv[1]), int(sys.argv[2]), int(sys.argv[5])
    seen = poll(a_port, n_clients, float(sys.argv[3]), float(sys.argv[4]), ahead)
    sys.stdout.write(json.dumps(samples(seen)) + "\n")
