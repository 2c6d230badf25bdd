"""Hands orders to the worker and waits for what becomes of them; runs in the API."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import Callable, Sequence
from http import HTTPStatus

from snapfit.server.boards import Board
from snapfit.server.commands import Command, CommandKind, Orders, Outcome, Replies
from snapfit.server.pose_store import PoseStore
from snapfit.server.problems import ProblemError

_LIMIT_S = 3.0
_BEGIN_WITHIN_S = 2.5  # the rest is for the frame that shows what was done
_PERIOD_S = 0.004


class CommandDesk:
    """The one writer of a station's orders.

    Args:
        station: its name.
        store: of the station.
        why_down: why its worker cannot be reached; None where it runs.
    """

    def __init__(self, station: str, store: PoseStore, why_down: Callable[[], str | None]) -> None:
        self._station = station
        self._store = store
        self._why_down = why_down
        self._run = secrets.token_hex(6)
        self._number = 0
        self._pending: list[Command] = []
        self._boards: tuple[Board, ...] = ()

    def look_for(self, boards: Sequence[Board]) -> None:
        """Say which markers the camera shall look for."""
        if tuple(boards) != self._boards:
            self._boards = tuple(boards)
            self._write()

    async def order(
        self, kind: CommandKind, *, parts: Sequence[str] = (), state: str = ""
    ) -> Outcome:
        """Have something done.

        Raises:
            ProblemError: 409, it cannot be done, with the reason; 503, the worker is down or does
                not answer.
        """
        why_down = self._why_down()
        if why_down is not None:
            raise self._unavailable(why_down)
        self._number += 1
        by_s = time.monotonic() + _BEGIN_WITHIN_S
        command = Command(
            number=self._number, kind=kind, parts=tuple(parts), state=state, begin_by_s=by_s
        )
        self._pending.append(command)
        self._write()
        try:
            outcome = await self._outcome(command.number)
        finally:
            # Done or not, a worker that comes later shall not do it.
            self._pending.remove(command)
            self._write()
        # It may have been done while this process was held up, or while it was taken back.
        outcome = outcome or self._told(command.number)
        if outcome is None:
            raise self._unavailable(f"it did not answer within {_LIMIT_S:g} s")
        if outcome.problem is not None:
            detail = f"Station {self._station}: {outcome.detail}"
            names = list(outcome.names)
            raise ProblemError(HTTPStatus.CONFLICT, outcome.problem, detail, names=names)
        return outcome

    async def _outcome(self, number: int) -> Outcome | None:
        give_up_at_s = time.monotonic() + _LIMIT_S
        seen = -1
        while time.monotonic() < give_up_at_s:
            if self._store.replies.latest != seen:
                seen = self._store.replies.latest
                outcome = self._told(number)
                if outcome is not None:
                    return outcome
            await asyncio.sleep(_PERIOD_S)
        return None

    def _told(self, number: int) -> Outcome | None:
        """What the worker has told of this command; None where it has told nothing."""
        message = self._store.replies.read()
        replies = None if message is None else Replies.model_validate_json(message.payload)
        if replies is None or replies.run != self._run:
            return None
        return next((it for it in replies.outcomes if it.number == number), None)

    def _write(self) -> None:
        orders = Orders(run=self._run, commands=tuple(self._pending), boards=self._boards)
        self._store.orders.write(orders.model_dump_json().encode())

    def _unavailable(self, what: str) -> ProblemError:
        return ProblemError(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "worker-unavailable",
            f"The worker of station {self._station} does nothing now: {what}. Ask again; doing it "
            "twice does no more than doing it once.",
            retry_after_s=1,
        )
