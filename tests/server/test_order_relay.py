"""Orders of several replicas become one worker's, and each gets its own answers."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import cast

import pytest
import redis

from snapfit.server import command_desk
from snapfit.server.boards import ArucoMarker
from snapfit.server.commands import Command, CommandKind, Orders, Outcome, Replies
from snapfit.server.fleet import order_sender
from snapfit.server.fleet.keys import ORDERS, StationKeys, heard
from snapfit.server.fleet.order_relay import LIMIT_S, OrderRelay
from snapfit.server.fleet.order_sender import OrderSender
from snapfit.server.pose_store import PoseStore


class Relayed:
    """A worker's machine without Redis: what replicas say, and what they are told."""

    def __init__(self, store: PoseStore) -> None:
        self.store = store
        self.relay = OrderRelay("bench", store)

    def hear(self, run: str, *numbers: int, boards: tuple[ArucoMarker, ...] = ()) -> None:
        commands = tuple(
            Command(number=it, kind=CommandKind.SET_STATE, state=f"{run}-{it}") for it in numbers
        )
        self.relay.hear(
            Orders(run=run, commands=commands, boards=boards).model_dump_json().encode()
        )

    def ordered(self) -> Orders:
        self.relay.look()
        message = self.store.orders.read()
        assert message is not None
        return Orders.model_validate_json(message.payload)

    def work(self) -> list[str]:
        """Do all as a worker does; what was done."""
        orders = self.ordered()
        outcomes = tuple(Outcome(number=it.number, state=it.state) for it in orders.commands)
        replies = Replies(run=orders.run, outcomes=outcomes)
        self.store.replies.write(replies.model_dump_json().encode())
        return [it.state for it in orders.commands]

    def told(self) -> dict[str, list[tuple[int, str | None]]]:
        replies = [Replies.model_validate_json(it) for it in self.relay.look()]
        return {it.run: [(each.number, each.state) for each in it.outcomes] for it in replies}


@pytest.fixture
def relayed() -> Iterator[Relayed]:
    store = PoseStore.create()
    yield Relayed(store)
    store.close()


def test_orders_of_several_replicas_are_done_once_and_answered_under_their_numbers(
    relayed: Relayed,
) -> None:
    relayed.hear("a", 1, 2)
    relayed.hear("b", 1)
    relayed.hear("a", 1, 2)
    assert relayed.work() == ["a-1", "a-2", "b-1"]
    assert relayed.told() == {"a": [(1, "a-1"), (2, "a-2")], "b": [(1, "b-1")]}
    assert relayed.work() == []
    assert relayed.told() == {}
    relayed.hear("a", 2)  # it has not heard
    assert relayed.told() == {"a": [(1, "a-1"), (2, "a-2")]}
    relayed.hear("a", 2, 3)
    assert relayed.work() == ["a-3"]


def test_what_a_replica_takes_back_is_not_done(relayed: Relayed) -> None:
    relayed.hear("a", 1, 2)
    relayed.hear("a", 2)
    assert relayed.work() == ["a-2"]


def test_what_the_worker_does_not_begin_in_time_is_not_done(
    relayed: Relayed, monkeypatch: pytest.MonkeyPatch
) -> None:
    marker = ArucoMarker(kind="aruco", id=1, size_m=0.1)
    now_s = time.monotonic()
    monkeypatch.setattr(time, "monotonic", lambda: now_s)
    relayed.hear("a", 1, boards=(marker,))
    assert relayed.ordered().boards == (marker,)
    (command,) = relayed.ordered().commands
    assert command.begin_by_s is not None
    assert now_s + 1 < command.begin_by_s < now_s + LIMIT_S
    monkeypatch.setattr(time, "monotonic", lambda: now_s + LIMIT_S)
    assert relayed.ordered().commands == ()
    assert relayed.relay.boards == (marker,)
    relayed.hear("a", 1, boards=(marker,))
    assert relayed.work() == []
    monkeypatch.setattr(time, "monotonic", lambda: now_s + 10)
    assert relayed.ordered().boards == ()  # that replica is silent


def test_the_three_waits_of_an_order_fit_into_the_one_of_its_client() -> None:
    waits_s = order_sender._PASS_ON_WITHIN_S + order_sender._VALID_S + LIMIT_S
    assert waits_s + 0.1 < command_desk._LIMIT_S


class HeardByRedis:
    """Takes what a replica tells."""

    def __init__(self) -> None:
        self.told = b""

    def time(self) -> tuple[int, int]:
        return 0, 0

    def eval(self, _script: str, _n_keys: int, _key: str, _until_us: str, told: bytes) -> int:
        self.told = told
        return 1


def test_when_to_begin_by_one_machines_clock_is_told_to_no_other(relayed: Relayed) -> None:
    command = Command(number=1, kind=CommandKind.RESET, begin_by_s=time.monotonic() + 2.5)
    orders = Orders(run="a", commands=(command,))
    relayed.store.orders.write(orders.model_dump_json().encode())
    client = HeardByRedis()
    OrderSender(relayed.store, StationKeys("bench")).look(cast("redis.Redis", client))
    assert b"begin_by_s" not in client.told
    name, value = heard(client.told)
    assert name == ORDERS
    (told,) = Orders.model_validate_json(value).commands
    assert told == command.model_copy(update={"begin_by_s": None})


def test_orders_that_cannot_be_understood_are_told_once(
    relayed: Relayed, caplog: pytest.LogCaptureFixture
) -> None:
    for value in (b"", b"{}", b'{"run": 1}'):
        relayed.relay.hear(value)
    assert len(caplog.records) == 1
    relayed.hear("a", 1)
    assert relayed.work() == ["a-1"]
