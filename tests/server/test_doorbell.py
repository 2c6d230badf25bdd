"""Who publishes rings, and who waits hears it: in one process and from another one."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from snapfit.server.doorbell import Doorbell
from snapfit.server.pose_store import PoseStore
from snapfit.server.watch import Moment, Watch

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no event loop hears pipes there")
LONG_S = 60.0


@pytest.fixture
def bell() -> Iterator[Doorbell]:
    it = Doorbell.create()
    yield it
    it.close()


async def is_heard(bell: Doorbell, limit_s: float) -> bool:
    rung = asyncio.Event()
    assert bell.listen(rung)
    try:
        await asyncio.wait_for(rung.wait(), limit_s)
    except TimeoutError:
        return False
    finally:
        bell.deafen()
    return True


def test_a_ring_is_heard_once_however_often_it_was_rung(bell: Doorbell) -> None:
    async def listen() -> list[bool]:
        for _ in range(3):
            bell.ring()
        return [await is_heard(bell, LONG_S), await is_heard(bell, 0.02)]

    assert asyncio.run(listen()) == [True, False]


def test_it_never_waits_for_who_does_not_listen(bell: Doorbell) -> None:
    for _ in range(100_000):  # more than a pipe holds
        bell.ring()
    assert asyncio.run(is_heard(bell, LONG_S))


def test_a_child_process_rings(bell: Doorbell) -> None:
    code = "import sys; from snapfit.server.doorbell import Doorbell; "
    code += "Doorbell(None, int(sys.argv[1])).ring()"
    assert bell.rung is not None
    command = [sys.executable, "-c", code, str(bell.rung)]
    subprocess.run(command, pass_fds=(bell.rung,), check=True)
    assert asyncio.run(is_heard(bell, LONG_S))


def test_nobody_is_troubled_when_the_other_end_is_gone(bell: Doorbell) -> None:
    heard, rung = bell._heard, bell.rung
    assert heard is not None
    Doorbell(heard, None).close()
    bell._heard = None
    bell.ring()
    assert bell.rung == rung
    bell.close()
    bell.close()
    bell.ring()


def test_without_ends_it_makes_no_sound() -> None:
    async def listen() -> bool:
        bell = Doorbell(None, None)
        bell.ring()
        return bell.listen(asyncio.Event())

    assert not asyncio.run(listen())


def test_a_store_has_one_for_its_maker_and_one_for_whom_it_is_told() -> None:
    store = PoseStore.create()
    try:
        assert store.doorbell.rung is not None
        other = PoseStore.attach(store.names)
        assert other.doorbell.rung is None
        other.close()
    finally:
        store.close()
    assert store.doorbell.rung is None


def test_a_watch_looks_when_it_rings(bell: Doorbell) -> None:
    """So many looks, and no more, are made for so many rings within one period."""
    looks = 0

    def look() -> Moment:
        nonlocal looks
        looks += 1
        return Moment("a", looks, False, 1)

    async def watch() -> tuple[bool, int, float]:
        it = Watch(look, lambda: None, lambda: 0, bell)
        running = asyncio.create_task(it.run())
        await asyncio.sleep(0)
        before, begin_s = looks, time.monotonic()
        for _ in range(50):
            bell.ring()
            assert await it.change(LONG_S)
        done = looks - before, time.monotonic() - begin_s
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        return running.cancelled(), *done

    was_cancelled, found, took_s = asyncio.run(watch())
    assert was_cancelled
    assert 50 <= found <= 50 + took_s / 0.02 + 1
