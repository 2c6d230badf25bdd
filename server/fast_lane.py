"""GETs of all poses and of the assembly, answered ahead of everything but the check of who asks.

Polling clients ask for nothing else, so this is where the server's speed is. The same resources
stand among the routes, which document them and take every request with an error or of another
method, and of everybody who is not known yet.
"""

from __future__ import annotations

import time
from typing import NamedTuple

from starlette.types import Scope

from snapfit.server.logs.context import id_for_request
from snapfit.server.logs.requests import logs_all_requests
from snapfit.server.metrics import Metrics
from snapfit.server.problems import ProblemError
from snapfit.server.quick_query import QuickQuery, quick_query
from snapfit.server.security.access import Access
from snapfit.server.security.asking import Asking
from snapfit.server.station import Station
from snapfit.server.stations import Stations

_FOR_THE_APP = frozenset(
    (b"content-length", b"transfer-encoding", b"expect", b"x-forwarded-for", b"x-forwarded-proto")
)
"""A GET with a body, and one that a proxy passed on for somebody else, go the usual way."""


class QuickRequest(NamedTuple):
    """A request that is answered here.

    Attributes:
        station, query: what is asked for.
        asking: who asks.
        begin_s: when it came, by `time.perf_counter`.
    """

    station: Station
    query: QuickQuery
    asking: Asking
    begin_s: float


class QuickResponse(NamedTuple):
    """An answer, ready to be sent.

    Attributes:
        status: of HTTP.
        lines: of its head, behind those that all answers have.
        body: empty without one.
    """

    status: int
    lines: bytes
    body: bytes


class FastLane:
    """Decides who goes here, and what is answered; `QuickProtocol` reads and writes.

    Args:
        stations: that are asked for.
        access: who may ask.
        metrics: told of every answer.
        gbot_port: on which nothing of this is served; None: there is no such port.
    """

    def __init__(
        self, stations: Stations, access: Access, metrics: Metrics, gbot_port: int | None
    ) -> None:
        self._stations = stations
        self._access = access
        self._metrics = metrics
        self._gbot_port = gbot_port

    def wanted(self, scope: Scope) -> QuickRequest | None:
        """What is asked for, if it can be answered here and may be; it counts for the client."""
        if scope["method"] != "GET" or logs_all_requests() or self._is_elsewhere(scope):
            return None
        place = self._stations.at(scope["path"])
        if place is None:
            return None
        station, what = place
        query = quick_query(what, scope["query_string"])
        if query is None or not _FOR_THE_APP.isdisjoint(name for name, _ in scope["headers"]):
            return None
        asking = Asking.of(scope)
        if not self._access.knows(asking):
            return None
        return QuickRequest(station, query, asking, time.perf_counter())

    def response(self, request: QuickRequest, *, is_new: bool) -> QuickResponse:
        """The answer at this moment, as `reply` makes it for routes.

        Raises:
            ProblemError: the routes tell it.
        """
        answer = request.query.answer(request.station)
        current = id_for_request(request.asking.request_id).encode()
        lines = b"cache-control: no-store\r\netag: %b\r\nx-request-id: %b\r\n" % (
            answer.etag,
            current,
        )
        known = request.asking.if_none_match
        if known and answer.matches(known):
            return QuickResponse(304, lines, b"")
        if not is_new and not answer.is_stale:
            return QuickResponse(204, lines, b"")
        body = answer.body(self._stations.clock.now_us())
        lines += b"content-type: application/json\r\ncontent-length: %d\r\n" % len(body)
        return QuickResponse(200, lines, body)

    def can_answer(self, request: QuickRequest) -> bool:
        """Whether there is an answer at this moment, and no problem."""
        try:
            request.query.answer(request.station)
        except ProblemError:
            return False
        return True

    def answered(self, request: QuickRequest, status: int) -> None:
        """Note that this was answered just now."""
        seconds = time.perf_counter() - request.begin_s
        self._metrics.observe("GET", request.query.route, status, seconds)

    def _is_elsewhere(self, scope: Scope) -> bool:
        server = scope.get("server")
        return self._gbot_port is not None and server is not None and server[1] == self._gbot_port
