"""HTTP/1.1 connections that let no client fill the server's memory."""

from __future__ import annotations

from http import HTTPStatus

from uvicorn.protocols.http.httptools_impl import (
    STATUS_LINE,
    HttpToolsProtocol,
    RequestResponseCycle,
)

from snapfit.server.problems import ProblemError, problem_response

_PIPELINED = 16
_NO_HTTP = (
    "This is no HTTP/1.1 request: look for spaces, control characters or a # in its address, and "
    "for control characters in its headers."
)


class BoundedProtocol(HttpToolsProtocol):
    """uvicorn's protocol with a limit to pipelining.

    Requests that are sent before earlier ones are answered wait in memory, some kilobytes each,
    thousands out of one packet. No client of ours sends any; a few are allowed.
    """

    _answering: RequestResponseCycle | None = None

    def on_message_begin(self) -> None:
        """A request begins."""
        if len(self.pipeline) >= _PIPELINED:
            self._forget()
            # At once: who does not read takes no farewell either.
            self.transport.abort()
            # The parser makes an error of it, and reads no further.
            raise ValueError(f"more than {_PIPELINED} requests wait for their answers")
        super().on_message_begin()

    def on_headers_complete(self) -> None:
        """A request can be answered, now or after earlier ones."""
        super().on_headers_complete()
        if not self.pipeline:
            self._answering = self.cycle

    def on_response_complete(self) -> None:
        """The next one that waits is answered."""
        if self.pipeline:
            self._answering = self.pipeline[-1][0]
        super().on_response_complete()

    def connection_lost(self, exc: Exception | None) -> None:
        """The client is gone."""
        self._forget()
        super().connection_lost(exc)

    def send_400_response(self, msg: str) -> None:
        """Answer a request that is none, unless the connection is gone already."""
        del msg  # uvicorn's few words; every error has one body here
        if self.transport.is_closing():
            return
        problem = problem_response("", ProblemError(HTTPStatus.BAD_REQUEST, "no-http", _NO_HTTP))
        headers = [*self.server_state.default_headers, *problem.raw_headers]
        lines = [STATUS_LINE[HTTPStatus.BAD_REQUEST]]
        lines += [b"%s: %s\r\n" % header for header in headers]
        self.transport.write(b"".join([*lines, b"connection: close\r\n\r\n", problem.body]))
        self.transport.close()

    def _forget(self) -> None:
        """Drop what waits; uvicorn itself tells only the latest request that its client is gone."""
        self.pipeline.clear()
        if self._answering is not None and not self._answering.response_complete:
            self._answering.disconnected = True
            self._answering.message_event.set()
