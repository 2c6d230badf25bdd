"""How many threads the kernels use, by what frames take."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numba
import pytest

from snapfit.tracking.kernel_threads import KernelThreads

PERIOD_MS = 33.0


@pytest.fixture
def cores(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], list[int]]:
    """Pretend to have so many; the numbers of threads that are asked for."""

    def pretend(count: int) -> list[int]:
        asked: list[int] = []
        monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
        monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", count)
        monkeypatch.setattr(numba, "set_num_threads", asked.append)
        return asked

    return pretend


def track(threads: KernelThreads, frames: int, duration_ms: float) -> int:
    for _ in range(frames):
        threads.tracked(duration_ms)
    return threads.count


@pytest.mark.parametrize(("count", "asked"), [(1, []), (2, [1]), (4, [3]), (5, []), (16, [])])
def test_on_few_cores_one_is_left(
    cores: Callable[[int], list[int]], count: int, asked: list[int]
) -> None:
    found = cores(count)
    threads = KernelThreads(PERIOD_MS)
    assert found == asked
    assert threads.count == (asked[0] if asked else count)


def test_what_the_user_says_holds(
    cores: Callable[[int], list[int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = cores(2)
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    threads = KernelThreads(PERIOD_MS)
    assert track(threads, 100, 1.0) == 2
    assert asked == []


def test_frames_that_take_too_long_get_all_cores_and_give_one_back(
    cores: Callable[[int], list[int]],
) -> None:
    asked = cores(2)
    threads = KernelThreads(PERIOD_MS)
    assert track(threads, 100, 15.0) == 1
    assert track(threads, 29, 25.0) == 2  # more than half of the last thirty are long by then
    assert track(threads, 100, 13.0) == 2  # with one thread less it would be 26 at worst
    assert track(threads, 40, 6.0) == 1
    assert asked == [1, 2, 1]


def test_one_long_frame_changes_nothing(cores: Callable[[int], list[int]]) -> None:
    asked = cores(2)
    threads = KernelThreads(PERIOD_MS)
    track(threads, 30, 10.0)
    track(threads, 1, 400.0)
    assert track(threads, 30, 10.0) == 1
    assert asked == [1]


def test_it_is_for_the_thread_that_makes_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    before = numba.get_num_threads()
    found: list[int] = []

    def beside() -> None:
        found.append(KernelThreads(PERIOD_MS).count)
        found.append(numba.get_num_threads())

    thread = threading.Thread(target=beside)
    thread.start()
    thread.join()
    assert found[0] == found[1]
    assert numba.get_num_threads() == before
