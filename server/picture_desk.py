"""Has pictures made by the worker, and waits for them; runs in the API."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from http import HTTPStatus

from snapfit.server.picture_message import PictureMessage, unpack_picture
from snapfit.server.pose_store import Picture, PoseStore
from snapfit.server.problems import ProblemError

_WAIT_S = 1.0
_POLL_S = 0.01
_WANTED_S = 2.0
_RETRY_AFTER_S = 1


class PictureDesk:
    """Pictures of a station.

    Args:
        station: its name.
        store: of the station.
        is_up: whether its worker runs.
    """

    def __init__(self, station: str, store: PoseStore, is_up: Callable[[], bool]) -> None:
        self._station = station
        self._store = store
        self._is_up = is_up

    async def picture(self, kind: Picture, generation: int) -> PictureMessage:
        """A picture of this snapshot or a later one; waits for it, at most a second.

        Raises:
            ProblemError: 503 when there is none in time.
        """
        mailbox = self._store.pictures[kind]
        give_up_at_s = time.monotonic() + _WAIT_S
        seen = -1
        while self._is_up():
            # Before the look: whoever was held up until after the limit looks once more.
            is_last = time.monotonic() >= give_up_at_s
            self._store.want(kind, _WANTED_S)
            if mailbox.latest != seen:
                seen = mailbox.latest
                message = mailbox.read()
                picture = None if message is None else unpack_picture(message.payload)
                if picture is not None and picture.generation >= generation:
                    return picture
            if is_last:
                break
            await asyncio.sleep(_POLL_S)
        raise ProblemError(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "no-picture",
            f"The worker of station {self._station} delivered no picture within {_WAIT_S:g} s.",
            retry_after_s=_RETRY_AFTER_S,
        )
