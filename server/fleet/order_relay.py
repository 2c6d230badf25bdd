"""Makes one worker's orders of what several replicas want; runs on the worker's machine."""

from __future__ import annotations

import logging
import secrets
import time
from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

from pydantic import ValidationError

from snapfit.server.boards import Board
from snapfit.server.commands import Command, Orders, Outcome, Replies
from snapfit.server.errors import StoreError
from snapfit.server.pose_store import PoseStore

LIMIT_S = 1.8
"""So long may the worker take to begin with an order, then it is taken back."""

_BEGIN_WITHIN_S = 1.5  # the rest is for the frame that shows what was done
_HEARD_S = 2.0
_FORGOTTEN_S = 60.0  # later than any repetition of what is done already
_KEPT = 32
_LOG = logging.getLogger(__name__)


class _Waiting(NamedTuple):
    command: Command
    since_s: float

    def told_as(self, number: int) -> Command:
        """For the worker."""
        told = {"number": number, "begin_by_s": self.since_s + _BEGIN_WITHIN_S}
        return self.command.model_copy(update=told)


@dataclass
class _Replica:
    """A run of a replica: its wishes, and what became of them."""

    heard_at_s: float = 0.0
    boards: tuple[Board, ...] = ()
    pending: dict[int, _Waiting] = field(default_factory=dict)  # by the number for the worker
    latest: int = 0  # of its own numbers
    outcomes: deque[Outcome] = field(default_factory=lambda: deque(maxlen=_KEPT))
    is_due: bool = False


class OrderRelay:
    """The one writer of the worker's orders.

    A command gets a number of the worker's when it is first heard, so that it is done once however
    often a replica repeats it.

    Args:
        station: its name.
        store: of the worker's machine.
    """

    def __init__(self, station: str, store: PoseStore) -> None:
        self._station = station
        self._store = store
        self._run = secrets.token_hex(6)
        self._number = 0
        self._replicas: dict[str, _Replica] = {}
        self._written = Orders(run=self._run)
        self._seen = 0
        self._has_complained = False

    @property
    def boards(self) -> tuple[Board, ...]:
        """All that any replica looks for."""
        return self._written.boards

    def hear(self, value: bytes) -> None:
        """All that a replica wants now; what cannot be understood is left out."""
        try:
            orders = Orders.model_validate_json(value)
        except ValidationError as error:
            self._complain(f"orders of another version of snapfit: {error.error_count()} errors")
            return
        replica = self._replicas.setdefault(orders.run, _Replica())
        now_s = replica.heard_at_s = time.monotonic()
        replica.boards = orders.boards
        wanted = {command.number for command in orders.commands}
        replica.pending = {
            here: it for here, it in replica.pending.items() if it.command.number in wanted
        }
        for command in orders.commands:
            if command.number > replica.latest:
                replica.latest = command.number
                self._number += 1
                replica.pending[self._number] = _Waiting(command, now_s)
        # It asks again, so it may not have heard.
        replica.is_due |= any(outcome.number in wanted for outcome in replica.outcomes)
        self._write()

    def look(self) -> list[bytes]:
        """What is to be told to replicas; forgets those that are silent."""
        self._take_replies()
        self._forget(time.monotonic())
        told = []
        for run, replica in self._replicas.items():
            if replica.is_due:
                replica.is_due = False
                replies = Replies(run=run, outcomes=tuple(replica.outcomes))
                told.append(replies.model_dump_json().encode())
        return told

    def _forget(self, now_s: float) -> None:
        for run, replica in list(self._replicas.items()):
            silent_s = now_s - replica.heard_at_s
            if silent_s > _FORGOTTEN_S:
                del self._replicas[run]
                continue
            if silent_s > _HEARD_S:
                replica.boards = ()
            replica.pending = {
                here: it for here, it in replica.pending.items() if now_s - it.since_s < LIMIT_S
            }
        self._write()

    def _take_replies(self) -> None:
        if self._store.replies.latest == self._seen:
            return
        self._seen = self._store.replies.latest
        message = self._store.replies.read()
        replies = None if message is None else Replies.model_validate_json(message.payload)
        if replies is None or replies.run != self._run:
            return
        for outcome in replies.outcomes:
            for replica in self._replicas.values():
                waiting = replica.pending.pop(outcome.number, None)
                if waiting is not None:
                    told = outcome.model_copy(update={"number": waiting.command.number})
                    replica.outcomes.append(told)
                    replica.is_due = True
        self._write()

    def _write(self) -> None:
        """Tell the worker, if anything changed."""
        replicas = self._replicas.values()
        pending = {here: it for each in replicas for here, it in each.pending.items()}
        orders = Orders(
            run=self._run,
            commands=tuple(pending[here].told_as(here) for here in sorted(pending)),
            boards=tuple(dict.fromkeys(board for each in replicas for board in each.boards)),
        )
        if orders == self._written:
            return
        try:
            self._store.orders.write(orders.model_dump_json().encode())
        except StoreError as error:  # replicas tell that nobody answers
            self._complain(str(error))
            return
        self._written = orders

    def _complain(self, what: str) -> None:
        if not self._has_complained:
            self._has_complained = True
            _LOG.warning("station %s: orders were left out: %s (told once)", self._station, what)
