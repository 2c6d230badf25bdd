"""HTTP connections that answer what the fast lane takes at once, without a task or an app."""

from __future__ import annotations

from functools import partial
from typing import cast

from starlette.types import Scope
from uvicorn._types import ASGI3Application
from uvicorn.protocols.http.httptools_impl import STATUS_LINE, RequestResponseCycle

from snapfit.server.fast_lane import FastLane, QuickRequest, QuickResponse
from snapfit.server.problems import ProblemError
from snapfit.server.security.protocol import BoundedProtocol
from snapfit.server.waiting import Waiting

_CLOSE = b"connection: close\r\n"


class _Lines:
    """The headers of all answers as they are sent; uvicorn makes a new list each second."""

    def __init__(self) -> None:
        self._headers: list[tuple[bytes, bytes]] = []
        self._lines = b""

    def of(self, headers: list[tuple[bytes, bytes]]) -> bytes:
        if headers is not self._headers:
            self._headers = headers
            self._lines = b"".join(b"%b: %b\r\n" % header for header in headers)
        return self._lines


class QuickProtocol(BoundedProtocol):
    """uvicorn's protocol, which asks the fast lane before it calls the app.

    It steps in where a request meets the app, and does with the request's cycle what uvicorn does
    after an answer: pipelining, time limits and the server's end go on as they are.

    Attributes:
        lane: of the server; `protocol_with` sets it.
    """

    lane: FastLane
    _default_lines = _Lines()
    _waiting: Waiting | None = None

    def connection_lost(self, exc: Exception | None) -> None:
        """The client is gone, and waits for nothing any more."""
        if self._waiting is not None:
            self._waiting.forget()
            self._waiting = None
        super().connection_lost(exc)

    def _start_asgi_task(self, cycle: RequestResponseCycle, app: ASGI3Application) -> None:
        """A request begins to be answered: here, or by the app."""
        is_usual = app is self.app and not self.flow.write_paused
        request = self.lane.wanted(cast("Scope", cycle.scope)) if is_usual else None
        if request is None:
            super()._start_asgi_task(cycle, app)
            return
        tell = partial(self._answer, cycle, request)
        self._waiting = request.query.tell_new(request.station, tell)
        if self._waiting is None:
            self._answer(cycle, request, True)
        elif not self.lane.can_answer(request):  # told now, and not after a wait
            self._waiting.forget()
            self._waiting = None
            super()._start_asgi_task(cycle, app)

    def _answer(self, cycle: RequestResponseCycle, request: QuickRequest, is_new: bool) -> None:
        """What was waited for is there, or will not come in time."""
        self._waiting = None
        if self.transport.is_closing():
            return
        try:
            response = self.lane.response(request, is_new=is_new)
        except ProblemError:  # that is the routes' to tell
            super()._start_asgi_task(cycle, self.app)
            return
        self._send(cycle, request, response)

    def _send(
        self, cycle: RequestResponseCycle, request: QuickRequest, response: QuickResponse
    ) -> None:
        """In one piece; then all that uvicorn does at the end of an answer."""
        head = STATUS_LINE[response.status] + self._default_lines.of(cycle.default_headers)
        closing = b"" if cycle.keep_alive else _CLOSE
        self.transport.write(b"%b%b%b\r\n%b" % (head, response.lines, closing, response.body))
        self.lane.answered(request, response.status)
        cycle.response_started = cycle.response_complete = True
        cycle.message_event.set()
        if not cycle.keep_alive:
            self.transport.close()
        cycle.on_response()


def protocol_with(lane: FastLane) -> type[QuickProtocol]:
    """The connections of one server."""
    return type("ServerProtocol", (QuickProtocol,), {"lane": lane})
