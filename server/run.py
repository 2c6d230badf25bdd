"""Runs the API in this process until it is told to end."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import gc
import signal
import socket
import sys
from collections.abc import Awaitable, Callable
from contextlib import ExitStack
from types import FrameType

import uvicorn

from snapfit.server.app import create_app
from snapfit.server.errors import AddressError, PortInUseError
from snapfit.server.front import connections_of, with_front
from snapfit.server.logs.setup import LogChoice, configure_logging
from snapfit.server.openapi import prepare_openapi
from snapfit.server.security.headers import SECURITY_HEADERS
from snapfit.server.security.tls import check_tls
from snapfit.server.settings import Settings
from snapfit.server.stations import Stations
from snapfit.server.worker_spec import DEFAULT_PIPELINE

_BACKLOG = 2048
_SHUTDOWN_LIMIT_S = 2
# An unused connection is closed after this time, and a request that meets its closing is lost. So
# it is longer than clients keep one: httpx 5 s, .NET 60 s (PooledConnectionIdleTimeout).
_UNUSED_LIMIT_S = 75
_SEND_BUFFER_BYTES = 64 * 1024
_UNREAD_LIMIT_MS = 10_000

Companion = Callable[[Stations], Awaitable[None]]
"""Runs beside the server; what it raises ends the server."""


def run_server(settings: Settings, companion: Companion, pipeline: str = DEFAULT_PIPELINE) -> None:
    """Serve until SIGINT or SIGTERM, or until the companion raises.

    Args:
        settings: what is served, and where.
        companion: runs beside the server, on its event loop.
        pipeline: "module:function" that opens source and tracker in the workers.

    Raises:
        PortInUseError: another program listens there.
        AddressError: this machine cannot listen there.
        TlsError: a certificate or its key cannot be used.
        KeyFileError: the key file cannot be read.
        SnapfitError: raised by the companion.
    """
    configure_logging(LogChoice(settings.log_format, settings.log_level))
    check_tls(settings.security)
    ports = [settings.port]
    if settings.gbot_port is not None and settings.gbot_port != settings.port:
        ports.append(settings.gbot_port)
    app = create_app(settings, pipeline)
    config = uvicorn.Config(
        with_front(app, settings.gbot_port),
        loop="auto",
        http=connections_of(app, settings.gbot_port),
        headers=SECURITY_HEADERS,
        ws="websockets-sansio",
        ws_per_message_deflate=False,  # a snapshot is small, and packing it costs every client
        access_log=False,
        ssl_certfile=settings.security.tls_cert,
        ssl_keyfile=settings.security.tls_key,
        server_header=False,
        log_config=None,  # ours, which is set up already
        log_level="warning",
        timeout_keep_alive=_UNUSED_LIMIT_S,
        timeout_graceful_shutdown=_SHUTDOWN_LIMIT_S,
    )
    server = _Server(config, app.state.stations)
    # Until uvicorn listens to signals, and after: one that comes during the start is not lost.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, server.handle_exit)
    prepare_openapi(app)
    # What is there now stays: looking through it for garbage would hold up every answer for tens of
    # milliseconds.
    gc.collect()
    gc.freeze()
    with ExitStack() as open_now:
        listeners = [open_now.enter_context(_listen(settings.host, port)) for port in ports]
        runner = open_now.enter_context(asyncio.Runner(loop_factory=config.get_loop_factory()))
        runner.run(_serve(server, listeners, companion(app.state.stations)))


class _Server(uvicorn.Server):
    """Ends in order even if it is told twice; that takes a few seconds at most."""

    def __init__(self, config: uvicorn.Config, stations: Stations) -> None:
        super().__init__(config)
        self._stations = stations

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End what waits or streams, so that nothing has to be cut off."""
        self._stations.end_streams()
        await super().shutdown(sockets)

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """End."""
        del sig, frame
        self.should_exit = True


async def _serve(
    server: uvicorn.Server, listeners: list[socket.socket], companion: Awaitable[None]
) -> None:
    def end_if_failed(done: asyncio.Future[None]) -> None:
        if not done.cancelled() and done.exception() is not None:
            server.should_exit = True

    beside = asyncio.ensure_future(companion)
    beside.add_done_callback(end_if_failed)
    if not server.should_exit:  # told to end before there was anything to begin
        await server.serve(listeners)
    beside.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await beside


def _listen(host: str, port: int) -> socket.socket:
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
    except socket.gaierror as error:
        raise AddressError(f"host {host} is unknown ({error.strerror}): check --host") from error
    listener = socket.socket(family, kind, protocol)
    if sys.platform != "win32":
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    # Connections inherit both. What waits in the system for a slow client is a queue too: little
    # room keeps what it gets fresh.
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER_BYTES)
    if sys.platform == "linux":
        # Whoever takes nothing for so long is cut off.
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _UNREAD_LIMIT_MS)
    try:
        listener.bind(address)
        listener.listen(_BACKLOG)
    except OSError as error:
        listener.close()
        if error.errno == errno.EADDRINUSE:
            raise PortInUseError(host, port) from error
        raise AddressError(
            f"cannot listen at {host} port {port} ({error.strerror}): check --host and --port"
        ) from error
    return listener
