"""Trying again: how long to wait, and what is worth it."""

from __future__ import annotations

import asyncio
import logging
import random
import time
from collections.abc import AsyncGenerator, Callable
from contextlib import aclosing
from dataclasses import dataclass, field
from typing import TypeVar

from snapfit.clients.python.errors import (
    CertificateError,
    ClientError,
    NotReachableError,
    NotReadyError,
    ProblemError,
    ServerFaultError,
    TooManyRequestsError,
    UnexpectedAnswerError,
)

T = TypeVar("T")
OnWait = Callable[[ClientError, float], None]

_FIRST_S = 0.25
_LONGEST_S = 5.0
_LOG = logging.getLogger("snapfit.clients.python")
_CHANCE = random.SystemRandom()


def is_temporary(error: ClientError) -> bool:
    """Whether the same request may be answered a little later."""
    if isinstance(error, CertificateError):
        return False
    if isinstance(error, UnexpectedAnswerError):
        return error.is_gateway
    return isinstance(
        error, NotReachableError | NotReadyError | TooManyRequestsError | ServerFaultError
    )


@dataclass
class Backoff:
    """Doubles the wait from one failure to the next, up to 5 s, with jitter.

    Without jitter all clients of a server that was away would come back in one moment.

    Attributes:
        give_up_after_s: of failures in a row; None: never.
        on_wait: told the error and how long until the next try; else it is logged.
        chance: 0 to 1, of the jitter.
    """

    give_up_after_s: float | None = None
    on_wait: OnWait | None = None
    chance: Callable[[], float] = _CHANCE.random
    _failures: int = 0
    _since_s: float = field(default=0.0)

    def succeeded(self) -> None:
        """Something came: begin anew."""
        self._failures = 0

    def wait_s(self, error: ClientError) -> float:
        """How long to wait after this failure.

        Raises:
            ClientError: the failure itself, where it is no use to wait, or not any more.
        """
        if not is_temporary(error):
            raise error
        now_s = time.monotonic()
        if self._failures == 0:
            self._since_s = now_s
        if self.give_up_after_s is not None and now_s - self._since_s >= self.give_up_after_s:
            raise error
        wait_s = min(_LONGEST_S, _FIRST_S * 2.0 ** min(self._failures, 10))
        self._failures += 1
        wait_s *= 0.5 + 0.5 * self.chance()
        if isinstance(error, ProblemError) and error.retry_after_s is not None:
            wait_s = max(wait_s, error.retry_after_s)
        if self.on_wait is not None:
            self.on_wait(error, wait_s)
        else:
            _LOG.warning("%s Trying again in %.1f s.", error, wait_s)
        return wait_s


async def reconnecting(
    open_stream: Callable[[], AsyncGenerator[T, None]], backoff: Backoff
) -> AsyncGenerator[T, None]:
    """What a stream says, opened again whenever it ends or fails.

    Raises:
        ClientError: it is no use to try again, or not any more.
    """
    while True:
        failure: ClientError = NotReachableError("The server has ended the stream.")
        try:
            async with aclosing(open_stream()) as stream:
                async for item in stream:
                    backoff.succeeded()
                    yield item
        except ClientError as error:
            failure = error
        await asyncio.sleep(backoff.wait_s(failure))
