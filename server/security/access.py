"""Decides who may do what: keys and sessions, roles, rates, origins."""

from __future__ import annotations

from collections.abc import Collection

from starlette.types import Scope

from snapfit.server.security.asking import Asking, host_name, is_local_name
from snapfit.server.security.key_file import KeyRecord
from snapfit.server.security.key_ring import KeyRing
from snapfit.server.security.rate_limit import TokenBuckets
from snapfit.server.security.refusals import (
    foreign_host,
    foreign_origin,
    key_needed,
    role_needed,
    too_many,
    wrong_key,
)
from snapfit.server.security.roles import SAFE_METHODS, role_for
from snapfit.server.security.session import session_token
from snapfit.server.security.settings import SecuritySettings

_FAILURES_PER_S, _FAILURES_BURST = 0.2, 10
_WEBSOCKET_METHOD = "GET"  # of its handshake


class Access:
    """The rules of one server.

    Args:
        settings: the table `[security]`.
        ring: the keys; None where none are needed.
        open_paths: that need no key: the page's files, health, the way to a session.
    """

    def __init__(
        self, settings: SecuritySettings, ring: KeyRing | None, open_paths: Collection[str]
    ) -> None:
        self.ring = ring
        self._open_paths = frozenset(open_paths)
        self._origins = frozenset(settings.cors_origins)
        self._hosts = frozenset(name.lower() for name in settings.hosts)
        self._requests = TokenBuckets(settings.requests_per_s, settings.burst)
        self._failures = TokenBuckets(_FAILURES_PER_S, _FAILURES_BURST)

    async def check(self, scope: Scope) -> KeyRecord | None:
        """Let a request pass; the key it comes with, if any.

        Raises:
            ProblemError: 401, 403 or 429.
        """
        asking = Asking.of(scope)
        self._check_place(scope, asking)
        if self.ring is None:
            self._count(f"at {asking.address}")
            return None
        record, given = await self._identity(self.ring, asking)
        self._count(f"at {asking.address}" if record is None else f"key {record.id}")
        if scope["path"] in self._open_paths:
            return record
        if record is None:
            raise wrong_key() if given else key_needed()
        needed = role_for(scope.get("method", _WEBSOCKET_METHOD))
        if not record.role.may(needed):
            raise role_needed(needed)
        return record

    def knows(self, asking: Asking) -> bool:
        """Whether a GET passes without further ado; counted if so.

        It does for whoever polls: no page of another origin asks, the host is a local name where
        no key is needed, and else the key has been right before.
        """
        if asking.origin:
            return False
        if self.ring is None:
            return is_local_name(asking.host) and not self._requests.take(f"at {asking.address}")
        key = asking.bearer
        record = None if key is None else self.ring.remembered(key)
        return record is not None and not self._requests.take(f"key {record.id}")

    async def owner(self, ring: KeyRing, key: str, address: str) -> KeyRecord | None:
        """Whose key this is; a client that guesses is made to wait.

        Raises:
            ProblemError: 429.
        """
        record = ring.remembered(key)
        if record is not None:
            return record
        wait_s = self._failures.wait_s(address)
        if wait_s:
            raise too_many(wait_s, "wrong keys")
        record = await ring.of_key(key)
        if record is None:
            self._failures.take(address)
        return record

    def _check_place(self, scope: Scope, asking: Asking) -> None:
        """Keeps web pages from elsewhere from acting through somebody's browser."""
        if self.ring is None and not (
            is_local_name(asking.host) or host_name(asking.host) in self._hosts
        ):
            raise foreign_host(asking.host)
        acts = scope["type"] == "websocket" or scope["method"] not in SAFE_METHODS
        if acts and not asking.is_same_origin() and not self._origins & {asking.origin, "*"}:
            raise foreign_origin(asking.origin)

    def _count(self, client: str) -> None:
        wait_s = self._requests.take(client)
        if wait_s:
            raise too_many(wait_s, "requests")

    async def _identity(self, ring: KeyRing, asking: Asking) -> tuple[KeyRecord | None, bool]:
        """Whose request this is, and whether it claimed to be anybody's."""
        key = asking.bearer
        if key is not None:
            return await self.owner(ring, key, asking.address), True
        token = session_token(asking.cookie)
        if token is not None:
            return ring.of_session(token), True
        return None, False
