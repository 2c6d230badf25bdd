"""GETs of all poses and of the assembly, answered ahead of everything but the check of who asks.

Polling clients ask for nothing else, so this is where the server's speed is. The same resources
stand among the routes, which document them and take every request with an error or of another
method, and of everybody who is not known yet.
"""

from __future__ import annotations

from starlette.types import ASGIApp, Receive, Scope, Send

from snapfit.server.answers import Answer
from snapfit.server.logs.context import id_for_request
from snapfit.server.logs.requests import logs_all_requests
from snapfit.server.problems import ProblemError
from snapfit.server.quick_query import QuickQuery, quick_query
from snapfit.server.request_clock import FAST_LANE
from snapfit.server.security.access import Access
from snapfit.server.security.asking import Asking
from snapfit.server.station import Station
from snapfit.server.stations import Stations

_JSON = (b"content-type", b"application/json")
_NO_STORE = (b"cache-control", b"no-store")


class FastLane:
    """ASGI middleware."""

    def __init__(self, app: ASGIApp, stations: Stations, access: Access) -> None:
        self._app = app
        self._stations = stations
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer here, or let the app answer."""
        wanted = self._wanted(scope)
        if wanted is None:
            await self._app(scope, receive, send)
            return
        station, query = wanted
        asking = Asking.of(scope)
        if not self._access.knows(asking):
            await self._app(scope, receive, send)
            return
        try:
            query.answer(station)  # what cannot be answered is told now, and not after a wait
            is_new = await query.is_new(station)
            answer = query.answer(station)
        except ProblemError:
            await self._app(scope, receive, send)
            return
        scope[FAST_LANE] = query.route
        await self._reply(asking, answer, send, is_new=is_new or answer.is_stale)

    def _wanted(self, scope: Scope) -> tuple[Station, QuickQuery] | None:
        if scope["type"] != "http" or scope["method"] != "GET" or logs_all_requests():
            return None
        place = self._stations.at(scope["path"])
        if place is None:
            return None
        station, what = place
        query = quick_query(what, scope["query_string"])
        return None if query is None else (station, query)

    async def _reply(self, asking: Asking, answer: Answer, send: Send, *, is_new: bool) -> None:
        """As `reply` does for routes."""
        current = id_for_request(asking.request_id).encode()
        headers = [_NO_STORE, (b"etag", answer.etag), (b"x-request-id", current)]
        status, body = 200, b""
        if asking.if_none_match and answer.matches(asking.if_none_match):
            status = 304
        elif not is_new:
            status = 204
        else:
            body = answer.body(self._stations.clock.now_us())
            headers += (_JSON, (b"content-length", b"%d" % len(body)))
        await send({"type": "http.response.start", "status": status, "headers": headers})
        await send({"type": "http.response.body", "body": body})
