"""Passes on what a replica's API wants to the machine that its worker runs on."""

from __future__ import annotations

import time
from typing import Any, cast

import redis

from snapfit.server.commands import Command, Orders, Replies
from snapfit.server.fleet.keys import ORDERS, StationKeys, tell
from snapfit.server.pose_store import PoseStore

_AGAIN_S = 0.5
# A client is told after 3 s that nothing was done (`CommandDesk`), and it has to be true: so long
# may an order wait here, then so long in Redis, and then for `OrderRelay.LIMIT_S` at the worker.
_PASS_ON_WITHIN_S = 0.5
_VALID_S = 0.5
_OF_THIS_MACHINE: dict[str, Any] = {"commands": {"__all__": {"begin_by_s"}}}  # its clock's
# By the clock of Redis, the only one that all agree on: one that hung for some seconds does not
# pass on what a client was told not to be done.
_TELL_IN_TIME = """
local now = redis.call('TIME')
if now[1] * 1000000 + now[2] > tonumber(ARGV[1]) then return -1 end
return redis.call('PUBLISH', KEYS[1], ARGV[2])
"""


class OrderSender:
    """Tells all that is wanted whenever that changes, and again while anything is.

    An order that came to nothing with a connection that broke is not passed on any more.

    Args:
        store: of the replica, which its API writes orders to.
        keys: of the station.
    """

    def __init__(self, store: PoseStore, keys: StationKeys) -> None:
        self._store = store
        self._keys = keys
        self._orders = Orders(run="")
        self._asked_at_s: dict[int, float] = {}
        self._told: set[int] = set()
        self._seen = 0
        self._is_due = False
        self._sent_at_s = 0.0
        self._ahead_s: float | None = None

    def connected(self) -> None:
        """Another connection: what was sent by the last one may not have come through."""
        self._told.clear()
        self._is_due = self._seen > 0
        self._ahead_s = None

    def look(self, client: redis.Redis) -> None:
        """Pass on what has to be."""
        now_s = time.monotonic()
        self._read(now_s)
        wants = self._orders.commands or self._orders.boards
        if not self._is_due and not (wants and now_s - self._sent_at_s >= _AGAIN_S):
            return
        if self._ahead_s is None:
            seconds, microseconds = cast("tuple[int, int]", client.time())
            self._ahead_s = seconds + microseconds / 1e6 - time.monotonic()
        until_us = round(1e6 * (now_s + self._ahead_s + _VALID_S))
        orders = self._orders.model_copy(update={"commands": self._commands(now_s)})
        payload = orders.model_dump_json(exclude=_OF_THIS_MACHINE)
        told = tell(ORDERS, payload.encode())
        heard: object = client.eval(_TELL_IN_TIME, 1, self._keys.to_worker, str(until_us), told)
        if heard == -1:
            self._ahead_s = None  # its clock was set, or it took too long: once more
            return
        self._is_due, self._sent_at_s = False, now_s
        self._told = {command.number for command in orders.commands}

    def _read(self, now_s: float) -> None:
        if self._store.orders.latest == self._seen:
            return
        message = self._store.orders.read()
        if message is None:
            return
        self._seen, self._is_due = message.generation, True
        self._orders = Orders.model_validate_json(message.payload)
        asked = self._asked_at_s
        self._asked_at_s = {it.number: asked.get(it.number, now_s) for it in self._orders.commands}

    def _commands(self, now_s: float) -> tuple[Command, ...]:
        """Those that the worker's machine knows, and new ones that are not too old for it."""
        return tuple(
            it
            for it in self._orders.commands
            if it.number in self._told or now_s - self._asked_at_s[it.number] < _PASS_ON_WITHIN_S
        )

    def hear(self, value: bytes) -> None:
        """What became of orders, of this replica's or another's."""
        replies = Replies.model_validate_json(value)
        if replies.run == self._orders.run:
            self._store.replies.write(value)
