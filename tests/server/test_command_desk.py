"""What a client is told of an order is what became of it, whoever was held up meanwhile."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from types import SimpleNamespace
from typing import cast

import pytest

from snapfit.server import command_desk
from snapfit.server.command_desk import CommandDesk
from snapfit.server.command_runner import CommandRunner
from snapfit.server.commands import Command, CommandKind, Orders, Outcome, Replies
from snapfit.server.pipeline import Pipeline
from snapfit.server.pose_store import PoseStore
from snapfit.server.problems import ProblemError
from snapfit.server.snapshot import SnapshotWriter


class Desk:
    """A desk whose time stands still, and what a worker does to its store."""

    def __init__(self, store: PoseStore) -> None:
        self.store = store
        self.desk = CommandDesk("bench", store, lambda: None)
        self.now_s = 1000.0

    def monotonic(self) -> float:
        return self.now_s

    def orders(self) -> Orders:
        message = self.store.orders.read()
        assert message is not None
        return Orders.model_validate_json(message.payload)

    def reply(self, orders: Orders) -> None:
        outcomes = tuple(Outcome(number=it.number, state=it.state) for it in orders.commands)
        replies = Replies(run=orders.run, outcomes=outcomes)
        self.store.replies.write(replies.model_dump_json().encode())

    async def begin(self) -> asyncio.Task[Outcome]:
        """Order something; it is waited for now."""
        order = asyncio.create_task(self.desk.order(CommandKind.SET_STATE, state="free"))
        await asyncio.sleep(0)
        return order


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    store = PoseStore.create()
    it = Desk(store)
    monkeypatch.setattr(command_desk, "time", it)
    yield it
    store.close()


def test_what_was_done_while_the_desk_was_held_up_is_told(desk: Desk) -> None:
    async def held_up() -> Outcome:
        order = await desk.begin()
        desk.reply(desk.orders())
        desk.now_s += 10
        return await order

    assert asyncio.run(held_up()).state == "free"


def test_what_was_done_while_it_was_taken_back_is_told(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = desk.store.orders.write

    def reply_first(payload: bytes) -> int:
        if not Orders.model_validate_json(payload).commands:
            desk.reply(desk.orders())
        return write(payload)

    async def too_late() -> Outcome:
        order = await desk.begin()
        monkeypatch.setattr(desk.store.orders, "write", reply_first)
        desk.now_s += 10
        return await order

    assert asyncio.run(too_late()).state == "free"


def test_what_was_not_done_is_told_and_taken_back(desk: Desk) -> None:
    async def too_late() -> None:
        order = await desk.begin()
        (command,) = desk.orders().commands
        assert command.begin_by_s is not None
        assert desk.now_s + 1 < command.begin_by_s < desk.now_s + command_desk._LIMIT_S
        desk.now_s += 10
        with pytest.raises(ProblemError, match="did not answer within 3 s"):
            await order

    asyncio.run(too_late())
    assert desk.orders().commands == ()


def test_a_worker_does_not_begin_what_was_given_up(desk: Desk) -> None:
    source = SimpleNamespace(asset=None, parts=())
    pipeline = SimpleNamespace(source=source, controls=None, method="icg")
    snapshots = cast("SnapshotWriter", None)
    runner = CommandRunner(desk.store, cast("Pipeline", pipeline), snapshots)
    by_s = {1: time.monotonic() + 60, 2: time.monotonic() - 0.001, 3: None}
    commands = tuple(
        Command(number=number, kind=CommandKind.RESET, begin_by_s=it) for number, it in by_s.items()
    )
    desk.store.orders.write(Orders(run="a", commands=commands).model_dump_json().encode())
    runner.run()
    runner.reply()
    message = desk.store.replies.read()
    assert message is not None
    replies = Replies.model_validate_json(message.payload)
    assert [outcome.number for outcome in replies.outcomes] == [1, 3]
