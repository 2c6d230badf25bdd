"""A second port for clients made for the GBOT authors' server: `/resource` and nothing else."""

from __future__ import annotations

from http import HTTPStatus

from starlette.types import ASGIApp, Receive, Scope, Send

from snapfit.server.problems import ProblemError, problem_response

_PATH = "/resource"


class GbotPort:
    """ASGI middleware.

    Args:
        app: the next layer.
        port: on which only the old resource is served; None: there is no such port.
    """

    def __init__(self, app: ASGIApp, port: int | None) -> None:
        self._app = app
        self._port = port

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on what belongs here."""
        is_here = self._port is not None and (scope.get("server") or ("", None))[1] == self._port
        if not is_here or scope["type"] == "lifespan" or scope["path"] == _PATH:
            await self._app(scope, receive, send)
            return
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
            return
        detail = f"This port serves {_PATH} alone, for old clients."
        problem = ProblemError(HTTPStatus.NOT_FOUND, "old-port", detail)
        await problem_response(scope["path"], problem)(scope, receive, send)
