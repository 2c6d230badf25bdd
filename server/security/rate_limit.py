"""Token buckets: a client may ask at a steady rate, and for a moment faster."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable

_CLIENTS_REMEMBERED = 10_000


class _Bucket:
    """Tokens left, and when they were counted (monotonic, seconds)."""

    __slots__ = ("at_s", "tokens")

    def __init__(self, tokens: float, at_s: float) -> None:
        self.tokens = tokens
        self.at_s = at_s


class TokenBuckets:
    """A bucket for each client, by name; who was silent longest is forgotten first.

    Args:
        rate_per_s: tokens that come back each second.
        burst: tokens that a bucket holds.
        clock_s: a monotonic clock, seconds.
    """

    def __init__(
        self, rate_per_s: float, burst: float, clock_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._rate_per_s = rate_per_s
        self._burst = burst
        self._clock_s = clock_s
        self._buckets: OrderedDict[str, _Bucket] = OrderedDict()

    def take(self, client: str, tokens: float = 1.0) -> float:
        """Take tokens out of the client's bucket.

        Returns:
            0 if they were there; else nothing is taken, and it is worth trying again after so
            many seconds.
        """
        bucket = self._filled(client)
        if bucket.tokens >= tokens:
            bucket.tokens -= tokens
            return 0.0
        return (tokens - bucket.tokens) / self._rate_per_s

    def wait_s(self, client: str) -> float:
        """How long until a token is there, without taking it, seconds."""
        return max(1.0 - self._filled(client).tokens, 0.0) / self._rate_per_s

    def _filled(self, client: str) -> _Bucket:
        now_s = self._clock_s()
        bucket = self._buckets.get(client)
        if bucket is None:
            bucket = self._buckets[client] = _Bucket(self._burst, now_s)
            if len(self._buckets) > _CLIENTS_REMEMBERED:
                self._buckets.popitem(last=False)
            return bucket
        self._buckets.move_to_end(client)
        bucket.tokens = min(bucket.tokens + (now_s - bucket.at_s) * self._rate_per_s, self._burst)
        bucket.at_s = now_s
        return bucket
