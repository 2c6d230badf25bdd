"""A keep-alive HTTP/1.1 connection that never waits, and knows when its bytes came in.

The kernel stamps what it receives, so that an answer counts as received when it was, and not when
this process got round to reading it.
"""

from __future__ import annotations

import select
import socket
import struct
import sys
import time
from collections.abc import Mapping

NICENESS = 10
"""Of load generators: less urgent than the API, for real clients take no time of its machine."""

_SO_TIMESTAMPNS = 35  # not among Python's constants
_STAMP = struct.Struct("qq")
_ANCILLARY_BYTES = socket.CMSG_SPACE(_STAMP.size)
_READ_BYTES = 65536
_END_OF_HEAD = b"\r\n\r\n"
_LENGTH = b"\r\ncontent-length: "


def now_us() -> int:
    """Unix time, microseconds: the clock of the kernel's stamps."""
    return time.time_ns() // 1000


def request(path: str, headers: Mapping[str, str] | None = None) -> bytes:
    """A GET, ready to be sent."""
    lines = [f"GET {path} HTTP/1.1", "Host: 127.0.0.1"]
    lines += [f"{name}: {value}" for name, value in (headers or {}).items()]
    return "\r\n".join([*lines, "", ""]).encode()


class Wire:
    """One connection.

    Attributes:
        received_us: when the last bytes came in; Unix time.
    """

    def __init__(self, port: int, epoll: select.epoll) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=5)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if sys.platform == "linux":
            self._socket.setsockopt(socket.SOL_SOCKET, _SO_TIMESTAMPNS, 1)
        self._socket.setblocking(False)
        self._unread = b""
        self.received_us = 0
        epoll.register(self._socket, select.EPOLLIN)

    def fileno(self) -> int:
        """As epoll knows it."""
        return self._socket.fileno()

    def send(self, data: bytes) -> None:
        """Send a request, which is small enough to go out at once."""
        if self._socket.send(data) != len(data):
            raise ConnectionError("a request did not fit the system's buffer")

    def read(self) -> bytes:
        """All that is unread; to be called when there is more.

        Raises:
            ConnectionError: the server has closed the connection.
        """
        data, ancillary, _, _ = self._socket.recvmsg(_READ_BYTES, _ANCILLARY_BYTES)
        if not data:
            raise ConnectionError("the server has closed a connection")
        # The first packets of all come without a stamp.
        self.received_us = _stamp_us(ancillary[0][2]) if ancillary else now_us()
        self._unread = self._unread + data if self._unread else data
        return self._unread

    def response(self) -> bytes | None:
        """The response that is complete now, head and body; None while it is not.

        Raises:
            ConnectionError: as `read`.
        """
        data = self.read()
        size = response_bytes(data)
        if size == 0 or len(data) < size:
            return None
        self._unread = data[size:]
        return data[:size] if self._unread else data

    def keep(self, unread: bytes) -> None:
        """What was read is understood but for this."""
        self._unread = unread

    def close(self) -> None:
        """Leave."""
        self._socket.close()


def response_bytes(data: bytes) -> int:
    """How long the response is that begins here; 0 while its head is not complete."""
    end = data.find(_END_OF_HEAD)
    if end < 0:
        return 0
    at = data.find(_LENGTH, 0, end)
    # 204 and 304 have neither length nor body.
    length = 0 if at < 0 else int(data[at + len(_LENGTH) :].split(b"\r", 1)[0])
    return end + len(_END_OF_HEAD) + length


def status(response: bytes) -> int:
    """Of a response."""
    return int(response[9:12])


def number_after(response: bytes, key: bytes) -> int:
    """The integer that follows `"key":` where that stands first."""
    at = response.index(key) + len(key)
    end = at
    while response[end : end + 1].isdigit():
        end += 1
    return int(response[at:end])


def _stamp_us(ancillary: bytes) -> int:
    seconds, nanoseconds = _STAMP.unpack(ancillary)
    return int(seconds) * 1_000_000 + int(nanoseconds) // 1000
