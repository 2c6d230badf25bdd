"""A connection to Redis or Valkey that is made anew when it breaks."""

from __future__ import annotations

import logging
import random
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import redis

from snapfit.server.errors import StoreError
from snapfit.server.logs.secrets import without_secrets

_TIMEOUT_S = 1.0
_SCHEMES = {"valkey": "redis", "valkeys": "rediss"}
_LASTED_S = 5.0  # a connection that held so long ended by accident: the next try is at once
_LOG = logging.getLogger(__name__)

Work = Callable[["redis.Redis"], None]
"""Uses a connection until it is told to end; what Redis raises ends it too."""


@dataclass(frozen=True)
class Backoff:
    """How long to wait before the next try, seconds: doubling, up to a limit, a little random."""

    first_s: float = 0.1
    longest_s: float = 2.0

    def delay_s(self, failures: int) -> float:
        """The delay after so many failures in a row; replicas do not come back all at once."""
        delay_s = min(self.first_s * 2.0 ** max(failures - 1, 0), self.longest_s)
        return delay_s * random.uniform(0.75, 1.0)  # noqa: S311 - no secret


class Link(threading.Thread):
    """Keeps some work connected, in a thread of its own.

    Args:
        url: `redis://`, `rediss://` (TLS), `unix://`; `valkey://` is another word for `redis://`.
        name: of the thread.
        work: what is done with the connection.
        backoff: before a connection is made anew.
    """

    def __init__(self, url: str, name: str, work: Work, backoff: Backoff | None = None) -> None:
        super().__init__(name=name, daemon=True)
        self._client = connect(url)
        self._told = without_secrets(url)
        self._work = work
        self._backoff = backoff or Backoff()
        self.stop = threading.Event()

    def run(self) -> None:
        """Until `close`."""
        failures = 0
        while not self.stop.is_set():
            begin_s = time.monotonic()
            try:
                self._work(self._client)
            except (redis.RedisError, OSError, StoreError, ValueError) as error:
                lasted = time.monotonic() - begin_s > _LASTED_S
                failures = 1 if lasted else failures + 1
                if failures == 1:
                    _LOG.warning("%s: %s; trying again", self._told, error)
                self._client.connection_pool.disconnect()
                self.stop.wait(self._backoff.delay_s(failures))
        self._client.close()

    def close(self) -> None:
        """End the work; returns when it has ended, after a time-out at the latest."""
        self.stop.set()
        if self.is_alive():
            self.join()


def connect(url: str) -> redis.Redis:
    """A client that waits for no answer longer than a second; nothing is sent yet.

    Raises:
        StoreError: the address cannot be understood.
    """
    from redis.backoff import NoBackoff
    from redis.retry import Retry

    scheme, separator, rest = url.partition("://")
    try:
        return redis.Redis.from_url(
            _SCHEMES.get(scheme, scheme) + separator + rest,
            socket_timeout=_TIMEOUT_S,
            socket_connect_timeout=_TIMEOUT_S,
            socket_keepalive=True,
            retry=Retry(NoBackoff(), 0),  # `Link` tries again, and knows what to send anew
        )
    except ValueError as error:
        raise StoreError(f"store {without_secrets(url)}: {error}") from error
