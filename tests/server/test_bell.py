"""Who is woken when: bells, and the watch that rings them."""

from __future__ import annotations

import asyncio

import pytest

from snapfit.server.bell import Bell
from snapfit.server.watch import Moment, Watch

SOON_S, LONG_S = 0.02, 60.0


def test_everybody_who_waits_is_woken_in_order() -> None:
    async def wait() -> list[int]:
        bell, woken = Bell(), []

        async def one(number: int) -> None:
            assert await bell.wait(LONG_S)
            woken.append(number)

        tasks = [asyncio.create_task(one(number)) for number in range(5)]
        await asyncio.sleep(0)
        bell.ring()
        await asyncio.gather(*tasks)
        return woken

    assert asyncio.run(wait()) == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("limit_s", [SOON_S, 0.0, -1.0])
def test_nobody_waits_longer_than_he_wants(limit_s: float) -> None:
    async def wait() -> tuple[bool, int]:
        bell = Bell()
        return await bell.wait(limit_s), len(bell._waiting)

    assert asyncio.run(wait()) == (False, 0)


def test_it_rings_only_for_those_who_wait_by_then() -> None:
    async def wait() -> bool:
        bell = Bell()
        bell.ring()
        return await bell.wait(SOON_S)

    assert not asyncio.run(wait())


def test_who_leaves_is_forgotten() -> None:
    async def leave() -> int:
        bell = Bell()
        task = asyncio.create_task(bell.wait(LONG_S))
        await asyncio.sleep(0)
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        bell.ring()
        return len(bell._waiting)

    assert asyncio.run(leave()) == 0


class Bench:
    """A station of which only the counts are known."""

    def __init__(self) -> None:
        self.moment: Moment | None = Moment("a", 1, False, 1)
        self.event = self.looks = 0
        self.watch = Watch(lambda: self.moment, lambda: None, self._latest)

    def _latest(self) -> int:
        """Asked once a look."""
        self.looks += 1
        return self.event

    async def _looked_again(self) -> None:
        """Until whoever was to be woken by one look has had the time until the next one."""
        until = self.looks + 2
        while self.looks < until:
            await asyncio.sleep(0.001)

    async def woken(self, moment: Moment | None, event: int = 0) -> tuple[bool, bool, bool]:
        """Whether that wakes who waits for a snapshot, for an assembly, for an event."""
        running = asyncio.create_task(self.watch.run())
        waiting = [
            asyncio.create_task(self.watch.snapshot_after("a", 1, LONG_S)),
            asyncio.create_task(self.watch.revision_after("a", 1, LONG_S)),
            asyncio.create_task(self.watch.event(LONG_S)),
        ]
        await self._looked_again()
        assert not any(task.done() for task in waiting)
        self.moment, self.event = moment, event
        await self._looked_again()
        done = [task.done() for task in waiting]
        for task in (running, *waiting):
            task.cancel()
        await asyncio.gather(running, *waiting, return_exceptions=True)
        return done[0], done[1], done[2]


@pytest.mark.parametrize(
    ("moment", "event", "woken"),
    [
        (Moment("a", 2, False, 1), 0, (True, False, False)),
        (Moment("a", 2, False, 2), 0, (True, True, False)),
        (Moment("a", 1, False, 1), 1, (False, False, True)),
        (Moment("a", 1, True, 1), 0, (True, True, False)),
        (Moment("b", 1, False, 1), 0, (True, True, False)),
    ],
)
def test_each_kind_of_news_wakes_those_who_wait_for_it(
    moment: Moment, event: int, woken: tuple[bool, bool, bool]
) -> None:
    assert asyncio.run(Bench().woken(moment, event)) == woken


def test_nobody_waits_when_the_server_ends() -> None:
    async def end() -> list[bool]:
        bench = Bench()
        waiting = [
            asyncio.create_task(bench.watch.change(LONG_S)),
            asyncio.create_task(bench.watch.event(LONG_S)),
            asyncio.create_task(bench.watch.revision_after("a", 1, LONG_S)),
        ]
        await asyncio.sleep(0)
        bench.watch.end()
        return [*await asyncio.gather(*waiting), await bench.watch.change(LONG_S)]

    assert asyncio.run(end()) == [False] * 4
