"""The parts of serving from several machines that need no Redis."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import redis

from snapfit.server.errors import SettingsError, StoreError
from snapfit.server.fleet import subscriber
from snapfit.server.fleet.keys import STATUS, StationKeys, ToldStatus, pack, unpack
from snapfit.server.fleet.link import Backoff, connect
from snapfit.server.fleet.subscriber import Subscriber
from snapfit.server.mailbox import Message
from snapfit.server.pose_store import PoseStore
from snapfit.server.settings import make_settings
from snapfit.server.supervisor import SupervisorStatus
from snapfit.server.worker_spec import WorkerSpec

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))


class Subscribed:
    """A subscriber without Redis, in a time of its own."""

    def __init__(self, subscriber: Subscriber, client: redis.Redis) -> None:
        self.subscriber = subscriber
        self.now_s = 1000.0
        self._client = client

    def monotonic(self) -> float:
        return self.now_s

    def now_us(self) -> int:
        return round(self.now_s * 1e6)

    def hear(self, ahead_us: int, after_s: float = 1.0) -> None:
        """A status comes from a clock that is ahead, or was sent a while ago."""
        self.now_s += after_s
        told = ToldStatus(SupervisorStatus(), self.now_us() + ahead_us)
        self.subscriber._hear(self._client, STATUS, told.dump())


def test_delays_grow_up_to_a_limit() -> None:
    backoff = Backoff(first_s=0.1, longest_s=2.0)
    for failures, longest_s in ((1, 0.1), (2, 0.2), (5, 1.6), (6, 2.0), (60, 2.0)):
        delays = [backoff.delay_s(failures) for _ in range(20)]
        assert 0.75 * longest_s <= min(delays) <= max(delays) <= longest_s
        assert len(set(delays)) > 1


def test_messages_keep_their_generation() -> None:
    message = Message(2**40, b"\x00payload")
    assert unpack(pack(message)) == message
    with pytest.raises(ValueError, match="a message of 3 bytes"):
        unpack(b"abc")


def test_a_status_travels_whole_and_another_versions_is_refused() -> None:
    told = ToldStatus(SupervisorStatus("boot", 7, 2, "was killed by SIGKILL"), 123)
    assert ToldStatus.load(told.dump()) == told
    for value in (b"{", b"[]", b'{"status": {"new": 1}, "sent_at_us": 1}', b"{}"):
        with pytest.raises(ValueError):  # noqa: PT011 - another one for each
            ToldStatus.load(value)


def test_stations_do_not_share_keys() -> None:
    one, two = StationKeys("a"), StationKeys("b")
    assert one.channel != two.channel
    assert len({one.lease, one.status, one.message("report"), two.lease}) == 4


@pytest.mark.parametrize(
    "store", ["redis", "http://x", "redis://", "redis:// x", "memory2", "redis://:hunter22@h x"]
)
def test_a_store_that_is_none_is_refused_without_its_password(store: str) -> None:
    with pytest.raises(SettingsError, match="store: ") as caught:
        make_settings("the test", {"store": store})
    assert "hunter22" not in str(caught.value)


def test_an_address_that_cannot_be_understood_is_refused_without_its_password() -> None:
    with pytest.raises(StoreError, match="store redis://") as caught:
        connect("redis://:hunter22@host:port/0")
    assert "hunter22" not in str(caught.value)
    for url in ("valkey://h:1", "valkeys://h:1", "redis://h:1", "rediss://h:1", "unix:///tmp/s"):
        connect(url).close()


@pytest.fixture
def subscribed(monkeypatch: pytest.MonkeyPatch) -> Iterator[Subscribed]:
    spec = WorkerSpec(
        station="bench",
        source="demo",
        asset=None,
        method="icg",
        boot_id="",
        wall_minus_monotonic_ns=0,
        poses_segment="",
        pictures_segment="",
    )
    store = PoseStore.create()
    client = connect("redis://127.0.0.1:1")
    it = Subscribed(Subscriber("redis://127.0.0.1:1", spec, store), client)
    monkeypatch.setattr(subscriber, "time", it)
    monkeypatch.setattr(it.subscriber, "_clock", it)
    yield it
    client.close()
    store.close()


def test_clocks_that_differ_are_told_once(
    subscribed: Subscribed, caplog: pytest.LogCaptureFixture
) -> None:
    for ahead_us in (0, 50_000, 3_000_000, -3_000_000, 0):
        for _ in range(10):
            subscribed.hear(ahead_us)
    assert len(caplog.records) == 1
    assert "differ by -3.00 s" in caplog.text


def test_a_message_that_was_held_up_is_no_wrong_clock(
    subscribed: Subscribed, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(10):
        for late_us in (750_000, 0, 400_000):
            subscribed.hear(-late_us)
    assert not caplog.records


@pytest.mark.parametrize("before", range(5))
def test_nor_are_those_that_queued_while_nobody_took_them(
    subscribed: Subscribed, caplog: pytest.LogCaptureFixture, before: int
) -> None:
    for _ in range(before):
        subscribed.hear(0)
    subscribed.now_s += 10
    for late_s in range(9, -1, -1):
        subscribed.hear(-late_s * 1_000_000, after_s=0.001)
    for _ in range(10):
        subscribed.hear(0)
    assert not caplog.records


def snapfit(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [SNAPFIT, *arguments], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["worker"], "store: is 'memory', which no other machine can read"),
        (
            ["worker", "--station", "bench-9"],
            "no station bench-9 in the settings; there is bench-1",
        ),
    ],
)
def test_what_a_worker_cannot_do_is_one_clear_line(
    tmp_path: Path, arguments: list[str], problem: str
) -> None:
    (tmp_path / "snapfit.toml").write_text("")
    done = snapfit(tmp_path, *arguments)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert problem in done.stderr


def test_the_demo_has_no_use_for_another_store(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SNAPFIT_STORE", "redis://127.0.0.1:1")
    done = snapfit(tmp_path, "demo")
    assert done.returncode == 2
    assert "unset SNAPFIT_STORE" in done.stderr
