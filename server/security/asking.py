"""What of a request tells who asks, from where: picked out of its headers in one pass."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from functools import lru_cache

from starlette.types import Scope

_LOCAL_ENDINGS = (".local", ".localhost")


@dataclass(slots=True)
class Asking:
    """Headers of one request; empty where absent.

    Attributes:
        address: of the client.
        host: that it asked for, with the port.
        origin: of the web page that asks.
        authorization, cookie, if_none_match, request_id: whole headers.
    """

    address: str = ""
    host: str = ""
    origin: str = ""
    authorization: str = ""
    cookie: str = ""
    if_none_match: bytes = b""
    request_id: str = ""

    @staticmethod
    def of(scope: Scope) -> Asking:
        """What this HTTP request or WebSocket handshake says."""
        client = scope.get("client")
        asking = Asking(address=client[0] if client else "")
        for name, value in scope["headers"]:
            if name == b"host":
                asking.host = value.decode("latin-1")
            elif name == b"origin":
                asking.origin = value.decode("latin-1")
            elif name == b"authorization":
                asking.authorization = value.decode("latin-1")
            elif name == b"if-none-match":
                asking.if_none_match = value
            elif name == b"x-request-id":
                asking.request_id = value.decode("latin-1")
            elif name == b"cookie":
                asking.cookie = f"{asking.cookie};{value.decode('latin-1')}"
        return asking

    @property
    def bearer(self) -> str | None:
        """The key in the header Authorization; None without one."""
        scheme, _, key = self.authorization.partition(" ")
        return key.strip() if scheme.lower() == "bearer" else None

    def is_same_origin(self) -> bool:
        """Whether the page that asks came from here; true where no page asks."""
        # Not taken apart as an address: anybody may send one that is none.
        place = self.origin.partition("://")[2].lower()
        return not self.origin or (place != "" and place == self.host.lower())


@lru_cache(maxsize=256)
def is_local_name(host: str) -> bool:
    """Whether no stranger can make this Host header lead here.

    Without keys a foreign page could otherwise read from this machine under a name of its own
    that it lets point here (DNS rebinding).
    """
    name = host_name(host)
    if not name or "." not in name or name.endswith(_LOCAL_ENDINGS):
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def host_name(host: str) -> str:
    """A Host header without its port and brackets, in lower case."""
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.partition(":")[0].rstrip(".").lower()
