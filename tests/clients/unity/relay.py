"""A proxy between client and server that can refuse WebSockets, freeze and cut."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator

_CHUNK = 65536
_REFUSAL = b"HTTP/1.1 501 Not Implemented\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"


class Relay:
    """Passes connections on to a port of this machine.

    Args:
        to_port: the server's.
        refuses_websockets: as some proxies do.
    """

    def __init__(self, to_port: int, *, refuses_websockets: bool = False) -> None:
        self._to_port = to_port
        self._refuses = refuses_websockets
        self._frozen = threading.Event()
        self._open: list[socket.socket] = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listener.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def freeze(self) -> None:
        """Connections that are open pass nothing on any more, and say nothing; new ones work."""
        self._frozen.set()
        self._frozen = threading.Event()

    def cut(self) -> None:
        """Close all connections that are open."""
        closing, self._open = self._open, []
        for connection in closing:
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)
            connection.close()

    def close(self) -> None:
        """Listen no more."""
        self._listener.close()
        self.cut()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        try:
            head = client.recv(_CHUNK)
            if self._refuses and b"upgrade: websocket" in head.lower():
                client.sendall(_REFUSAL)
                client.close()
                return
            server = socket.create_connection(("127.0.0.1", self._to_port))
        except OSError:
            client.close()
            return
        self._open += [client, server]
        with contextlib.suppress(OSError):
            server.sendall(head)
            frozen = self._frozen
            for source, sink in ((client, server), (server, client)):
                threading.Thread(target=_pass_on, args=(source, sink, frozen), daemon=True).start()


def _pass_on(source: socket.socket, sink: socket.socket, frozen: threading.Event) -> None:
    with contextlib.suppress(OSError):
        while chunk := source.recv(_CHUNK):
            if not frozen.is_set():
                sink.sendall(chunk)
    if not frozen.is_set():
        with contextlib.suppress(OSError):
            sink.shutdown(socket.SHUT_RDWR)


@contextlib.contextmanager
def relayed(to_port: int, *, refuses_websockets: bool = False) -> Iterator[Relay]:
    """A relay for some time."""
    relay = Relay(to_port, refuses_websockets=refuses_websockets)
    try:
        yield relay
    finally:
        relay.close()
