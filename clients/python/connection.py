"""Where the server is, and how it is asked: address, key, TLS."""

from __future__ import annotations

import os
import ssl
from dataclasses import dataclass, field
from functools import cached_property

import httpx

DEFAULT_URL = "http://127.0.0.1:8000"
_KEY = "SNAPFIT_KEY"
_WEBSOCKET_SCHEMES = {"http": "ws", "https": "wss"}

Verify = bool | str | os.PathLike[str] | ssl.SSLContext


@dataclass(frozen=True)
class Connection:
    """What all requests to one server have in common.

    Attributes:
        url: its address, without path and key.
        key: API key; None without.
        verify: as `Client` takes it.
        timeout_s: how long an answer may take, beside what a long poll waits by itself.
    """

    url: str
    key: str | None = field(repr=False)
    verify: Verify
    timeout_s: float

    @staticmethod
    def to(url: str, key: str | None, verify: Verify, timeout_s: float) -> Connection:
        """To the server at an address, such as it shows it at its start, `?key=` and all.

        Raises:
            ValueError: no address of a server.
        """
        try:
            parts = httpx.URL(url)
        except httpx.InvalidURL as error:
            raise ValueError(f"{url!r} is no address: {error}") from error
        if parts.scheme not in _WEBSOCKET_SCHEMES or not parts.host:
            raise ValueError(f"{url!r} is no address of a server: write http://HOST:PORT")
        if timeout_s <= 0:
            raise ValueError(f"timeout_s is {timeout_s}: it must be more than 0")
        key = key or parts.params.get("key") or os.environ.get(_KEY) or None
        bare = str(parts.copy_with(query=None, fragment=None)).rstrip("/")
        return Connection(bare, key, verify, timeout_s)

    @property
    def headers(self) -> dict[str, str]:
        """What every request carries."""
        return {} if self.key is None else {"Authorization": f"Bearer {self.key}"}

    @cached_property
    def ssl_context(self) -> ssl.SSLContext | None:
        """How certificates are checked; None where there are none.

        Raises:
            OSError: the file of `verify` cannot be read.
        """
        if not self.url.startswith("https:"):
            return None
        if isinstance(self.verify, ssl.SSLContext):
            return self.verify
        if isinstance(self.verify, bool):
            return httpx.create_ssl_context(verify=self.verify)
        return ssl.create_default_context(cafile=os.fspath(self.verify))

    @property
    def websocket_url(self) -> str:
        """The address for WebSockets."""
        scheme, _, rest = self.url.partition(":")
        return f"{_WEBSOCKET_SCHEMES[scheme]}:{rest}"
