"""Plain GETs of all poses, answered ahead of routing, validation and dependencies.

Polling clients ask for nothing else, so this is where the server's speed is. The same resource
stands among the routes, which document it and take every request with a query, an error, or
another method.
"""

from __future__ import annotations

from starlette.types import ASGIApp, Receive, Scope, Send

from snapfit.server.problems import ProblemError
from snapfit.server.request_clock import FAST_LANE
from snapfit.server.stations import Stations

_JSON = (b"content-type", b"application/json")
_NO_STORE = (b"cache-control", b"no-store")
_IF_NONE_MATCH = b"if-none-match"


class PosesFastLane:
    """ASGI middleware."""

    def __init__(self, app: ASGIApp, stations: Stations) -> None:
        self._app = app
        self._stations = stations

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer here, or let the app answer."""
        if scope["type"] != "http" or scope["method"] != "GET" or scope["query_string"]:
            await self._app(scope, receive, send)
            return
        station = self._stations.at_poses_path(scope["path"])
        if station is None:
            await self._app(scope, receive, send)
            return
        try:
            answer = station.poses()
        except ProblemError:
            await self._app(scope, receive, send)
            return
        scope[FAST_LANE] = True
        headers = [_JSON, _NO_STORE, (b"etag", answer.etag)]
        for name, value in scope["headers"]:
            if name == _IF_NONE_MATCH and answer.matches(value):
                await send({"type": "http.response.start", "status": 304, "headers": headers[1:]})
                await send({"type": "http.response.body"})
                return
        body = answer.body(self._stations.clock.now_us())
        headers.append((b"content-length", b"%d" % len(body)))
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": body})
