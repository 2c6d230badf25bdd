"""Plain GETs of all poses, answered ahead of everything but the check of who asks.

Polling clients ask for nothing else, so this is where the server's speed is. The same resource
stands among the routes, which document it and take every request with a query, an error, or
another method, and of everybody who is not known yet.
"""

from __future__ import annotations

from starlette.types import ASGIApp, Receive, Scope, Send

from snapfit.server.logs.context import id_for_request
from snapfit.server.logs.requests import logs_all_requests
from snapfit.server.problems import ProblemError
from snapfit.server.request_clock import FAST_LANE
from snapfit.server.security.access import Access
from snapfit.server.security.asking import Asking
from snapfit.server.stations import Stations

_JSON = (b"content-type", b"application/json")
_NO_STORE = (b"cache-control", b"no-store")


class PosesFastLane:
    """ASGI middleware."""

    def __init__(self, app: ASGIApp, stations: Stations, access: Access) -> None:
        self._app = app
        self._stations = stations
        self._access = access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer here, or let the app answer."""
        if scope["type"] != "http" or scope["method"] != "GET" or scope["query_string"]:
            await self._app(scope, receive, send)
            return
        station = self._stations.at_poses_path(scope["path"])
        asking = Asking.of(scope)
        if station is None or logs_all_requests() or not self._access.knows(asking):
            await self._app(scope, receive, send)
            return
        try:
            answer = station.poses()
        except ProblemError:
            await self._app(scope, receive, send)
            return
        scope[FAST_LANE] = True
        current = id_for_request(asking.request_id).encode()
        headers = [_JSON, _NO_STORE, (b"etag", answer.etag), (b"x-request-id", current)]
        if asking.if_none_match and answer.matches(asking.if_none_match):
            await send({"type": "http.response.start", "status": 304, "headers": headers[1:]})
            await send({"type": "http.response.body"})
            return
        body = answer.body(self._stations.clock.now_us())
        headers.append((b"content-length", b"%d" % len(body)))
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": body})
