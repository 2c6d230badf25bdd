"""The outermost layer: when a request came in, and how long its answer took."""

from __future__ import annotations

import time

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from snapfit.server.clock import Clock
from snapfit.server.metrics import Metrics

RECEIVED_AT_US = "snapfit.received_at_us"
"""In the scope: when the request came in, by the server's clock."""

_STREAMS = ("/events", ".mjpeg")
_UNKNOWN = "unknown"
_METHODS = frozenset(("GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "PATCH"))


class RequestClock:
    """ASGI middleware.

    Args:
        app: the next layer.
        clock: the server's time line.
        metrics: told of every request but streams.
    """

    def __init__(self, app: ASGIApp, clock: Clock, metrics: Metrics) -> None:
        self._app = app
        self._clock = clock
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Stamp, pass on, measure."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        begin_s = time.perf_counter()
        scope[RECEIVED_AT_US] = self._clock.now_us()
        status = 0

        async def noting_send(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
            await send(message)

        try:
            await self._app(scope, receive, noting_send)
        finally:
            if status and not scope["path"].endswith(_STREAMS):
                method = scope["method"] if scope["method"] in _METHODS else _UNKNOWN
                seconds = time.perf_counter() - begin_s
                self._metrics.observe(method, _route(scope), status, seconds)


def _route(scope: Scope) -> str:
    """The path with its parameters' names, so that there are no more series than routes."""
    path: str = scope["path"]
    if "route" not in scope:
        return _UNKNOWN
    done = ""
    for name, value in scope.get("path_params", {}).items():
        before, slash, path = path.partition(f"/{value}")
        done += f"{before}/{{{name}}}" if slash else before
    return done + path
