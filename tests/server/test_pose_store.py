"""The store between processes: readers, a writer, deaths, and who removes it."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import segments, wait_for
from store_processes import is_whole

from snapfit.server.errors import StoreError
from snapfit.server.pose_store import Picture, PoseStore, StoreNames
from snapfit.server.shared_segment import create_segment

PROCESSES = str(Path(__file__).parent / "store_processes.py")
KILLS = 25


@pytest.fixture
def store() -> Iterator[PoseStore]:
    it = PoseStore.create()
    yield it
    it.close()


def start(role: str, store: PoseStore, *more: str) -> subprocess.Popen[str]:
    command = [sys.executable, PROCESSES, role, store.names.poses, store.names.pictures, *more]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def finish(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err


def kill(process: subprocess.Popen[str]) -> None:
    process.send_signal(signal.SIGKILL)
    finish(process)


def test_no_read_is_torn_under_a_writer_at_full_speed(store: PoseStore) -> None:
    writer = start("write", store)
    wait_for(lambda: store.snapshots.latest > 0)
    readers = [start("read", store, "1.5") for _ in range(2)]
    results = [finish(reader) for reader in readers]
    kill(writer)
    for code, out, err in results:
        assert code == 0, err
        assert int(out) > 20


def test_writers_that_are_killed_while_they_write_harm_nobody(store: PoseStore) -> None:
    last = 0
    for _ in range(KILLS):
        writer = start("write", store)
        wait_for(lambda: store.snapshots.latest > last + 50)  # noqa: B023
        kill(writer)
        message = store.snapshots.read()
        assert message is not None
        assert is_whole(message.payload)
        assert message.generation > last
        last = message.generation


def test_who_attaches_does_not_remove_the_store(store: PoseStore) -> None:
    names = {store.names.poses, store.names.pictures}
    code, _, err = finish(start("touch", store))
    assert (code, err) == (0, "")  # no complaint of the resource tracker either
    writer = start("write", store)
    wait_for(lambda: store.snapshots.latest > 0)
    kill(writer)
    time.sleep(0.2)
    assert names <= segments()
    assert store.snapshots.read() is not None


def test_the_owner_removes_it_once(store: PoseStore) -> None:
    names = {store.names.poses, store.names.pictures}
    store.close()
    assert not names & segments()
    store.close()


def test_a_store_that_is_gone_is_a_clear_error() -> None:
    with pytest.raises(StoreError, match="no shared memory snapfit-none"):
        PoseStore.attach(StoreNames("snapfit-none", "snapfit-none"))


def test_a_store_of_another_version_is_a_clear_error() -> None:
    segment = create_segment(64)
    try:
        with pytest.raises(StoreError, match="another version"):
            PoseStore.attach(StoreNames(segment.name, segment.name))
    finally:
        segment.close()
        segment.unlink()


def test_pictures_are_wanted_for_a_while(store: PoseStore) -> None:
    other = PoseStore.attach(store.names)
    store.want(Picture.OVERLAY, for_s=60)
    assert other.wanted(Picture.OVERLAY)
    assert not other.wanted(Picture.FRAME)
    store.want(Picture.OVERLAY, for_s=0)
    assert not other.wanted(Picture.OVERLAY)
    other.close()


def test_the_heart_beats(store: PoseStore) -> None:
    before_s = time.monotonic()
    store.beat()
    time.sleep(0.05)
    assert 0.05 <= store.silent_for_s() <= time.monotonic() - before_s
    before_s = time.monotonic()
    finish(start("touch", store))
    silent_for_s = store.silent_for_s()
    assert silent_for_s < time.monotonic() - before_s
