"""The parts of serving from several machines that need no Redis."""

from __future__ import annotations

import logging
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from pydantic import ValidationError

from snapfit.server import command_desk
from snapfit.server.boards import ArucoMarker
from snapfit.server.clock import Clock
from snapfit.server.commands import Command, CommandKind, Orders, Outcome, Replies
from snapfit.server.errors import SettingsError, StoreError
from snapfit.server.fleet import order_sender
from snapfit.server.fleet.asset_files import StoredFile, asset_name
from snapfit.server.fleet.keys import STATUS, StationKeys, ToldStatus, pack, unpack
from snapfit.server.fleet.link import Backoff, connect
from snapfit.server.fleet.order_relay import LIMIT_S, OrderRelay
from snapfit.server.fleet.subscriber import Subscriber
from snapfit.server.mailbox import Message
from snapfit.server.pose_store import PoseStore
from snapfit.server.settings import make_settings
from snapfit.server.supervisor import SupervisorStatus
from snapfit.server.worker_spec import WorkerSpec

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))


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


def test_clocks_that_differ_are_told_once(caplog: pytest.LogCaptureFixture) -> None:
    clock = Clock.started_now()
    spec = WorkerSpec(
        station="bench",
        source="demo",
        asset=None,
        method="icg",
        boot_id="",
        wall_minus_monotonic_ns=clock.wall_minus_monotonic_ns,
        poses_segment="",
        pictures_segment="",
    )
    store = PoseStore.create()
    client = connect("redis://127.0.0.1:1")
    subscriber = Subscriber("redis://127.0.0.1:1", spec, store)
    try:
        with caplog.at_level(logging.WARNING):
            for ahead_us in (0, 50_000, 3_000_000, 3_000_000, -3_000_000, 0):
                told = ToldStatus(SupervisorStatus(), clock.now_us() + ahead_us)
                subscriber._hear(client, STATUS, told.dump())
    finally:
        client.close()
        store.close()
    assert len(caplog.records) == 1
    assert "differ by -3.00 s" in caplog.text


def snapfit(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [SNAPFIT, *arguments], cwd=folder, capture_output=True, text=True, timeout=30, check=False
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
    relayed.hear("a", 1, boards=(marker,))
    assert relayed.ordered().boards == (marker,)
    now_s = time.monotonic()
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


def test_orders_that_cannot_be_understood_are_told_once(
    relayed: Relayed, caplog: pytest.LogCaptureFixture
) -> None:
    for value in (b"", b"{}", b'{"run": 1}'):
        relayed.relay.hear(value)
    assert len(caplog.records) == 1
    relayed.hear("a", 1)
    assert relayed.work() == ["a-1"]


@pytest.mark.parametrize(
    "path", ["../x", "/x", "a/../x", "a/b/c", "..", "a/..", "a\\x", "a\nx", "", "parts/"]
)
def test_no_file_of_an_asset_leaves_its_folder(path: str) -> None:
    with pytest.raises(ValidationError, match="no file of an exported asset"):
        StoredFile(path=path, size_bytes=1, sha256="")
    assert StoredFile(path="media/..%2Fx", size_bytes=1, sha256="").path == "media/..%2Fx"


@pytest.mark.parametrize(
    ("folder", "name"),
    [
        ("/cache/assets/clamp-0123456789abcdef", "clamp-0123456789abcdef"),
        ("C:\\cache\\clamp-0123456789abcdef", "clamp-0123456789abcdef"),
        ("/cache/assets/..", None),
        ("/cache/assets/clamp", None),
        ("", None),
    ],
)
def test_an_asset_has_its_folders_name(folder: str, name: str | None) -> None:
    assert asset_name(folder) == name
