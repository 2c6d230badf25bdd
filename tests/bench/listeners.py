"""Long-pollers of the assembly, and listeners to events: a load generator in one process.

python listeners.py PORT POLLERS LISTENERS SECONDS CLOCK_AHEAD_US: each long-poller asks again as
soon as it was answered; the listeners read server-sent events. CLOCK_AHEAD_US: by how much the
server's clock is ahead of this machine's. Prints JSON: how long after its publication each state
change reached whom.
"""

from __future__ import annotations

import json
import os
import resource
import select
import sys
import time
from typing import Any

import orjson
from changes import Told, changes_in, delays_ms
from wire import NICENESS, Wire, now_us, request, status

_MARGIN_US = 1_000_000  # at both ends changes do not count: not all listen yet, or any more
_TURN_S = 0.1
_EVENT = b"event: state_changed\ndata: "
_HEAD_END = b"\r\n\r\n"


class Poller:
    """One long-poller."""

    def __init__(self, number: int, port: int, epoll: select.epoll, ahead_us: int) -> None:
        self.wire = Wire(port, epoll)
        self._number = number
        self._ahead_us = ahead_us
        self.told: list[Told] = []
        self.failures = 0
        self._known = ""
        self._ask()

    def take(self) -> None:
        """Something came in."""
        response = self.wire.response()
        if response is None:
            return
        code = status(response)
        if code == 200:
            self._understand(orjson.loads(response[response.index(_HEAD_END) + 4 :]))
        elif code != 204:
            self.failures += 1
        self._ask()

    def _understand(self, assembly: dict[str, Any]) -> None:
        self._known = f"?boot_id={assembly['boot_id']}&after_revision={assembly['revision']}"
        received_us = self.wire.received_us + self._ahead_us
        captured_us, published_us = assembly["captured_at_us"], assembly["published_at_us"]
        state, since_us = assembly["state"], assembly["since_us"]
        self.told.append(
            Told(self._number, state, since_us, received_us, captured_us, published_us)
        )

    def _ask(self) -> None:
        self.wire.send(request("/v1/assembly" + self._known))


class EventListener:
    """One listener to server-sent events."""

    def __init__(self, number: int, port: int, epoll: select.epoll, ahead_us: int) -> None:
        self.wire = Wire(port, epoll)
        self._number = number
        self._ahead_us = ahead_us
        self.told: list[Told] = []
        self.wire.send(request("/v1/events"))

    def take(self) -> None:
        """Something came in: the sizes of chunks lie between events, and do not matter."""
        *blocks, unread = self.wire.read().split(b"\n\n")
        self.wire.keep(unread)
        received_us = self.wire.received_us + self._ahead_us
        for block in blocks:
            _, found, data = block.partition(_EVENT)
            if found:
                event = orjson.loads(data)
                at_us = event["captured_at_us"]
                self.told.append(Told(self._number, event["to_state"], at_us, received_us, at_us))


def listen(
    port: int, pollers: int, listeners: int, seconds: float, ahead_us: int
) -> dict[str, object]:
    """Listen for so long; all that was measured, infinite where a change never came."""
    epoll = select.epoll()
    polling = [Poller(number, port, epoll, ahead_us) for number in range(pollers)]
    hearing = [EventListener(number, port, epoll, ahead_us) for number in range(listeners)]
    by_file = {each.wire.fileno(): each for each in [*polling, *hearing]}
    begin_us, end_s = now_us(), time.monotonic() + seconds
    while time.monotonic() < end_s:
        for file, _ in epoll.poll(_TURN_S):
            by_file[file].take()
    begin_us, end_us = begin_us + _MARGIN_US, now_us() - _MARGIN_US
    answers = [told for each in polling for told in each.told]
    events = [told for each in hearing for told in each.told]
    changes = changes_in(answers, begin_us + ahead_us, end_us + ahead_us)
    used = resource.getrusage(resource.RUSAGE_SELF)
    return {
        "changes": len(changes),
        "inexact": sum(not change.is_exact for change in changes),
        "poll_ms": delays_ms(changes, answers, pollers),
        "event_ms": delays_ms(changes, events, listeners),
        "failures": sum(each.failures for each in polling),
        "cpu_s": used.ru_utime + used.ru_stime,
    }


if __name__ == "__main__":
    os.nice(NICENESS)
    counts = [int(word) for word in sys.argv[1:4]]
    told_all = listen(counts[0], counts[1], counts[2], float(sys.argv[4]), int(sys.argv[5]))
    sys.stdout.write(json.dumps(told_all) + "\n")
