"""Every request has an id, and those that matter have a line in the log."""

from __future__ import annotations

import logging
import time
from http import HTTPStatus

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from snapfit.server.logs.context import id_for_request, request_id
from snapfit.server.problems import ProblemError, problem_response
from snapfit.server.security.roles import SAFE_METHODS

_HEADER = b"x-request-id"
_LOG = logging.getLogger(__name__)


def logs_all_requests() -> bool:
    """Whether every request has a line in the log."""
    return _LOG.isEnabledFor(logging.DEBUG)


class RequestLog:
    """ASGI middleware: ids, one event a request, and bugs told as a problem.

    At level `info` there is a line for each request that changes something, and for each that is
    refused or fails; at `debug` for all of them.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, with the id; log."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        given = None
        for name, value in scope["headers"]:
            if name == _HEADER:
                given = value
        current = id_for_request(None if given is None else given.decode("latin-1"))
        token = request_id.set(current)
        answer = _Answer(send, current.encode())
        begin_s = time.perf_counter()
        try:
            await self._app(scope, receive, answer.send)
        except Exception:
            _LOG.exception("%s failed", _what(scope))
            if answer.status is not None:
                raise
            await _bug(scope["path"])(scope, receive, answer.send)
        finally:
            self._tell(scope, answer.status, begin_s)
            request_id.reset(token)

    def _tell(self, scope: Scope, status: int | None, begin_s: float) -> None:
        matters = (status or 0) >= HTTPStatus.BAD_REQUEST or _acts(scope)
        level = logging.INFO if matters else logging.DEBUG
        if _LOG.isEnabledFor(level):
            event = {
                "status": status,
                "ms": round((time.perf_counter() - begin_s) * 1e3, 2),
                "address": scope["client"][0] if scope.get("client") else None,
                "key": scope.get("state", {}).get("key_name"),
            }
            _LOG.log(level, "%s", _what(scope), extra=event)


class _Answer:
    """Passes an answer on, with the id in its headers; remembers its status."""

    def __init__(self, send: Send, current: bytes) -> None:
        self._send = send
        self._current = current
        self.status: int | None = None

    async def send(self, message: Message) -> None:
        if message["type"] in ("http.response.start", "websocket.http.response.start"):
            self.status = message["status"]
            message["headers"] = [*message.get("headers", ()), (_HEADER, self._current)]
        elif message["type"] == "websocket.accept":
            self.status = HTTPStatus.SWITCHING_PROTOCOLS.value
        await self._send(message)


def _bug(path: str) -> ASGIApp:
    status = HTTPStatus.INTERNAL_SERVER_ERROR
    detail = "The server made a mistake; its log tells more, under this answer's X-Request-Id."
    return problem_response(path, ProblemError(status, "bug", detail))


def _acts(scope: Scope) -> bool:
    return scope["type"] == "websocket" or scope["method"] not in SAFE_METHODS


def _what(scope: Scope) -> str:
    """Without the query, which may hold a key."""
    return f"{scope.get('method', 'WEBSOCKET')} {scope['path']}"
