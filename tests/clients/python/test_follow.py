"""Streams: the latest wins, lost connections come back, and nothing is left behind."""

from __future__ import annotations

import asyncio
import http.server
import os
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import aclosing, closing, contextmanager
from itertools import islice, pairwise
from types import SimpleNamespace
from typing import Any

import pytest
from harness import Server, running, wait_for
from patience import within

from snapfit.clients.python import (
    AsyncClient,
    Client,
    ClientError,
    NotReachableError,
    PartLost,
    PoseSnapshot,
    StateChanged,
    StepFinished,
    UnexpectedAnswerError,
    UnknownAnchorError,
    UnknownStationError,
    backoff,
    mailbox,
)
from snapfit.clients.python.backoff import Backoff
from snapfit.clients.python.events import Event, EventReader, Missed, OtherEvent
from snapfit.clients.python.mailbox import Latest

START_S = 60


def take(client: Client, count: int, **options: Any) -> list[PoseSnapshot]:
    snapshots: list[PoseSnapshot] = []
    for snapshot in client.follow(**options):
        snapshots.append(snapshot)
        if len(snapshots) == count:
            break
    return snapshots


@pytest.mark.parametrize("way", ["websocket", "poll", "auto"])
def test_every_snapshot_comes_once_and_in_order(client: Client, way: str) -> None:
    snapshots = take(client, 20, way=way, convention="unity")
    assert {it.convention for it in snapshots} == {"unity"}
    # A worker that is held up makes its last one stale, which is another version of it.
    versions = [(it.seq, it.stale) for it in snapshots]
    assert versions == sorted(set(versions))


@pytest.mark.parametrize("way", ["websocket", "poll"])
def test_who_is_slow_gets_fewer_not_older_ones(
    client: Client, way: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    came, put = [0], Latest.put

    def noted(self: Latest, item: PoseSnapshot) -> None:
        put(self, item)
        came.append(item.seq)

    monkeypatch.setattr(Latest, "put", noted)
    seqs: list[int] = []
    for snapshot in client.follow(way=way):
        seqs.append(snapshot.seq)
        if len(seqs) == 6:
            break
        wait_for(lambda: came[-1] >= seqs[-1] + 9)
    # A queue would give them one after the other.
    assert min(b - a for a, b in pairwise(seqs)) >= 9


def test_without_the_library_it_is_polled(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "websockets", None)
    assert len(take(client, 3)) == 3


def test_leaving_the_loop_ends_the_thread(client: Client) -> None:
    before = set(threading.enumerate())
    with closing(client.follow()) as snapshots:
        next(snapshots)
        (thread,) = set(threading.enumerate()) - before
    assert not thread.is_alive()
    take(client, 2)
    assert set(threading.enumerate()) <= before


def test_closing_the_client_ends_a_loop_in_another_thread(url: str) -> None:
    client, seen = Client(url), threading.Event()

    def run() -> None:
        for _ in client.follow():
            seen.set()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    try:
        assert seen.wait(within(START_S))
    finally:
        client.close()
    thread.join(within(START_S))
    assert not thread.is_alive()


def test_a_client_that_is_closed_opens_no_stream(url: str) -> None:
    client = Client(url)
    client.close()
    for ask in (client.poses, lambda: next(client.follow()), lambda: next(client.events())):
        with pytest.raises(RuntimeError, match="closed"):
            ask()


@pytest.mark.parametrize("way", ["websocket", "poll"])
def test_what_cannot_be_mended_by_waiting_is_raised(client: Client, way: Any) -> None:
    with pytest.raises(UnknownStationError):
        next(client.at("bench-9").follow(way=way))
    with pytest.raises(UnknownAnchorError):
        next(client.follow(frame="anchor:nobody", way=way))
    with pytest.raises(UnknownStationError):
        next(client.at("bench-9").events())


def test_who_gives_up_is_told_why(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float] = []
    # Time passes by waiting alone, however long this machine takes for a refused connection.
    monkeypatch.setattr(backoff, "time", SimpleNamespace(monotonic=lambda: sum(waits)))
    with Client("http://127.0.0.1:9") as client, pytest.raises(NotReachableError):
        next(client.follow(give_up_after_s=1, on_wait=lambda _, wait_s: waits.append(wait_s)))
    assert sum(waits[:-1]) < 1 <= sum(waits)
    assert 2 <= len(waits) < 10


def test_a_worker_and_a_server_that_die_come_back() -> None:
    """Three things in one server: a worker's death, the server's death, another server."""
    failures: list[ClientError] = []
    with running() as server:
        wait_for(server.answers, START_S)
        wait_for(lambda: server.get("/readyz").status_code == 200, START_S)
        client = Client(f"http://127.0.0.1:{server.port}")
        snapshots = client.follow(stale_after_s=0.5, on_wait=lambda e, _: failures.append(e))
        is_open = threading.Event()
        events = client.events(on_wait=lambda e, _: failures.append(e), on_open=is_open.set)
        event_kinds: list[str] = []
        reader = threading.Thread(target=lambda: event_kinds.extend(e.event for e in events))
        reader.start()
        assert is_open.wait(within(START_S))
        first = next(snapshots)
        wait_for(lambda: not next(snapshots).stale)
        os.kill(server.worker()["pid"], signal.SIGKILL)
        wait_for(lambda: next(snapshots).stale)
        wait_for(lambda: (it := next(snapshots)).boot_id != first.boot_id and not it.stale)
        assert failures == []
        server.end()
        stale = wait_for(lambda: (it := next(snapshots)).stale and it)
        assert stale.age_us > 400_000
        with on_port(server.port) as again:
            wait_for(again.answers, START_S)
            back = wait_for(lambda: not (it := next(snapshots)).stale and it)
            assert back.boot_id != stale.boot_id
            client.close()
            reader.join(within(START_S))
        assert not reader.is_alive()
    assert {type(error) for error in failures} == {NotReachableError}
    assert {"stale", "recovered"} <= set(event_kinds)


@contextmanager
def on_port(port: int) -> Iterator[Server]:
    """Another server where one was."""
    import harness

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(harness, "free_port", lambda: port)
        server = Server()
    try:
        yield server
    finally:
        server.end()


def test_events_are_typed_and_resumed(client: Client) -> None:
    client.set_state("free")
    with closing(client.events(on_open=lambda: client.set_state("assembled"))) as events:
        changed, *steps = first_steps(events, 3)
    assert isinstance(changed, StateChanged)
    assert (changed.from_state, changed.to_state) == ("free", "assembled")
    assert [each.step for each in steps if isinstance(each, StepFinished)] == [
        "mount-jaw",
        "screw-bolt",
    ]
    with closing(client.events(last_event_id=changed.id)) as events:
        assert first_steps(events, 2) == steps
    with closing(client.events(last_event_id="00000000-1")) as events:
        missed = next(events)
    assert isinstance(missed, Missed)
    assert number(missed) >= number(steps[-1])


def first_steps(events: Iterator[Event], count: int) -> list[StateChanged | StepFinished]:
    """Without those of a worker that is held up: stale, and recovered."""
    steps = (it for it in events if isinstance(it, StateChanged | StepFinished))
    return list(islice(steps, count))


def number(event: Event) -> int:
    return int(event.id.rpartition("-")[2])


def test_events_are_put_together_from_any_pieces() -> None:
    header = '"station":"b","at_us":1,"boot_id":"x","seq":1,"captured_at_us":1'
    text = (
        "retry: 1000\n\n: here\n\n"
        f'id: a-1\nevent: part_lost\ndata: {{{header},"part":"a\u2028b","status":"lost"}}\n\n'
        'id: a-2\r\nevent: coffee\r\ndata: {"cups":\r\ndata: 2}\r\n\r\n'
    ).encode()
    for size in (1, 7, len(text)):
        reader = EventReader()
        chunks = [text[at : at + size] for at in range(0, len(text), size)]
        lost, coffee = [event for chunk in chunks for event in reader.feed(chunk)]
        assert isinstance(lost, PartLost)
        assert (lost.id, lost.part) == ("a-1", "a\u2028b")
        assert coffee == OtherEvent(id="a-2", name="coffee", data={"cups": 2})


def test_an_id_alone_is_gone_on_after() -> None:
    reader = EventReader()
    assert list(reader.feed(b"retry: 1000\nid: a-7\n\nid: a-8\nevent: stale\n")) == []
    assert reader.last_id == "a-7"
    reader.begin()
    header = b'"station":"b","at_us":1,"boot_id":"x","seq":1,"captured_at_us":1'
    [lost] = reader.feed(b"event: stale\ndata: {%b}\n\n" % header)
    assert (lost.id, reader.last_id) == ("", "a-7")


def test_a_stream_cut_before_its_first_event_goes_on_where_it_began() -> None:
    """Each connection brings nothing but the id at which it begins."""
    asked: list[str | None] = []

    class OnlyAnId(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked.append(self.headers["Last-Event-ID"])
            self.send_response(200 if len(asked) < 3 else 404)
            self.end_headers()
            self.wfile.write(b"retry: 1000\nid: a-7\n\n")

        def log_message(self, *_: Any) -> None:
            """Quiet."""

    with serving(OnlyAnId) as url, Client(url) as client, pytest.raises(UnexpectedAnswerError):
        next(client.events())
    assert asked == [None, "a-7", "a-7"]


def test_an_event_that_is_none_is_told() -> None:
    with pytest.raises(UnexpectedAnswerError, match="part_lost"):
        list(EventReader().feed(b"event: part_lost\ndata: {}\n\n"))


def test_waits_grow_with_jitter_up_to_a_bound() -> None:
    error = NotReachableError("away")
    longest = Backoff(chance=lambda: 1.0, on_wait=lambda *_: None)
    assert [longest.wait_s(error) for _ in range(7)] == [0.25, 0.5, 1, 2, 4, 5, 5]
    longest.succeeded()
    assert longest.wait_s(error) == 0.25
    for _ in range(50):
        assert 0.125 <= Backoff(on_wait=lambda *_: None).wait_s(error) <= 0.25


def test_silence_makes_the_last_one_stale_once(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = [100.0]
    monkeypatch.setattr(mailbox, "time", SimpleNamespace(monotonic=lambda: now_s[0]))
    latest, snapshot = Latest(0.05), client.poses().model_copy(update={"stale": False})
    assert latest.take() is None
    latest.put(snapshot)
    assert latest.take() is snapshot
    latest.put(snapshot)
    assert latest.take() is None
    now_s[0] += 0.06
    stale = latest.take()
    assert stale is not None
    assert (stale.stale, stale.identity) == (True, snapshot.identity)
    assert stale.age_us == snapshot.age_us + 60_000
    assert latest.take() is None
    latest.put(snapshot)
    assert latest.take() is snapshot


def test_a_server_that_is_another_one() -> None:
    class Page(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"<html>")

        def log_message(self, *_: Any) -> None:
            """Quiet."""

    with serving(Page) as url, Client(url) as client:
        for ask in (client.poses, client.stations, client.frame_jpeg):
            with pytest.raises(UnexpectedAnswerError):
                ask()
        with pytest.raises(UnexpectedAnswerError):
            next(client.follow())


@contextmanager
def serving(handler: type[http.server.BaseHTTPRequestHandler]) -> Iterator[str]:
    """The address of a server that is none of snapfit's."""
    with http.server.HTTPServer(("127.0.0.1", 0), handler) as other:
        thread = threading.Thread(target=other.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{other.server_port}"
        finally:
            other.shutdown()
            thread.join()


def test_a_server_that_accepts_and_says_nothing() -> None:
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        url = f"http://127.0.0.1:{silent.getsockname()[1]}"
        with Client(url, timeout_s=0.3) as client:
            with pytest.raises(NotReachableError, match="took too long"):
                client.poses()
            with pytest.raises(NotReachableError):
                next(client.follow(give_up_after_s=0, on_wait=lambda *_: None))


def test_asyncio_has_it_all(url: str) -> None:
    async def run() -> tuple[list[PoseSnapshot], list[StateChanged]]:
        async with AsyncClient(url) as client:
            await client.set_state("free")
            assert (await client.info()).station == "bench-1"
            assert (await client.part_model("jaw")).startswith(b"glTF")
            assert (await client.time_offset(2)).round_trip_us > 0
            changes: list[StateChanged] = []
            is_open = asyncio.Event()

            async def listen() -> None:
                async with aclosing(client.events(on_open=is_open.set)) as events:
                    async for event in events:
                        if isinstance(event, StateChanged):
                            changes.append(event)
                            return

            listener = asyncio.create_task(listen())
            await is_open.wait()
            await client.set_state("jaw-mounted")
            await asyncio.wait_for(listener, within(START_S))
            snapshots = []
            async with aclosing(client.follow()) as stream:
                async for snapshot in stream:
                    snapshots.append(snapshot)
                    await asyncio.sleep(0.1)
                    if len(snapshots) == 5:
                        break
            await client.set_state("free")
            tasks = {task for task in asyncio.all_tasks() if task is not asyncio.current_task()}
        assert tasks == set()
        return snapshots, changes

    snapshots, changes = asyncio.run(run())
    assert [change.to_state for change in changes] == ["jaw-mounted"]
    versions = [(it.seq, it.stale) for it in snapshots]
    assert versions == sorted(set(versions))
