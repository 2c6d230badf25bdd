"""What an API replica hears of a station whose worker runs on another machine."""

from __future__ import annotations

import dataclasses
import logging
import time
from collections import deque

import redis

from snapfit.server.clock import Clock
from snapfit.server.errors import StoreError
from snapfit.server.fleet.keys import (
    LEASE_S,
    SNAPSHOT,
    STATUS,
    WANT,
    WANTED_S,
    StationKeys,
    ToldStatus,
    published,
    unpack,
)
from snapfit.server.fleet.link import Link
from snapfit.server.logs.secrets import without_secrets
from snapfit.server.mailbox import Message
from snapfit.server.picture_message import pack_picture, unpack_picture
from snapfit.server.pose_store import Picture, PoseStore
from snapfit.server.supervisor import SupervisorStatus
from snapfit.server.worker_spec import WorkerSpec

_CLOCKS_DIFFER_S = 0.2
_LISTEN_S = 0.05
_LOOK_S = 0.5
_SNAPSHOTS_REMEMBERED = 256  # pictures are never as far behind
_LOG = logging.getLogger(__name__)


class Subscriber:
    """Stands in for a supervisor: its worker is elsewhere, and only heard of.

    Args:
        url: of Redis or Valkey.
        spec: of the station.
        store: of this machine; what is heard is written to it.
    """

    def __init__(self, url: str, spec: WorkerSpec, store: PoseStore) -> None:
        self._keys = StationKeys(spec.station)
        self._clock = Clock(spec.wall_minus_monotonic_ns)
        self._clocks_differ = False
        self._store = store
        self._told = without_secrets(url)
        self._last = SupervisorStatus()
        self._valid_until_s = 0.0
        self._answered_at_s = 0.0
        self._wished_at_s = dict.fromkeys(Picture, 0.0)
        self._heard = dict.fromkeys(published(store), 0)
        # Generations there and here: pictures name the snapshot that they belong to.
        self._generations: deque[tuple[int, int]] = deque(maxlen=_SNAPSHOTS_REMEMBERED)
        self._link = Link(url, f"subscribe-{spec.station}", self._subscribe)

    @property
    def status(self) -> SupervisorStatus:
        """How the worker does; where its lease has run out, why nothing is known of it."""
        now_s = time.monotonic()
        if now_s < self._valid_until_s:
            return self._last
        if now_s - self._answered_at_s > LEASE_S:
            absent = f"the store at {self._told} does not answer"
        else:
            absent = "no worker has the lease of this station: start `snapfit worker`"
        return dataclasses.replace(self._last, boot_id=None, pid=None, absent=absent)

    def start(self) -> None:
        """Begin to listen; returns at once."""
        self._link.start()

    def close(self) -> None:
        """Listen no more."""
        self._link.close()

    def _subscribe(self, client: redis.Redis) -> None:
        with client.pubsub(ignore_subscribe_messages=True) as channel:  # type: ignore[no-untyped-call]
            channel.subscribe(self._keys.channel)
            self._catch_up(client)
            look_at_s = 0.0
            while not self._link.stop.is_set():
                told = channel.get_message(timeout=_LISTEN_S)
                if told is not None:
                    name, _, value = told["data"].partition(b"\n")
                    self._hear(client, name.decode(), value)
                now_s = time.monotonic()
                if now_s >= look_at_s:
                    look_at_s = now_s + _LOOK_S
                    self._take_status(client.get(self._keys.status))
                self._pass_wishes_on(client, now_s)

    def _catch_up(self, client: redis.Redis) -> None:
        """What was said before this replica listened."""
        # The worker's machine may have been started anew, and counts from 1 again.
        self._heard = dict.fromkeys(self._heard, 0)
        for name in self._heard:
            if name not in self._store.pictures:
                self._take(name, client.get(self._keys.message(name)))

    def _hear(self, client: redis.Redis, name: str, value: bytes) -> None:
        if name == STATUS:
            self._take_status(value)
            self._compare_clocks(ToldStatus.load(value).sent_at_us)
        elif name not in self._store.pictures:
            self._take(name, value)
        elif self._store.wanted(Picture(name)):
            self._take(name, client.get(self._keys.message(name)))

    def _take_status(self, value: object) -> None:
        self._answered_at_s = time.monotonic()
        if isinstance(value, bytes):
            self._last = ToldStatus.load(value).status
            self._valid_until_s = self._answered_at_s + LEASE_S
        else:
            self._valid_until_s = 0.0

    def _compare_clocks(self, sent_at_us: int) -> None:
        """Ages are told by this machine's clock, of frames stamped by another one's."""
        late_s = (self._clock.now_us() - sent_at_us) / 1e6
        differ = abs(late_s) > _CLOCKS_DIFFER_S
        if differ and not self._clocks_differ:
            _LOG.warning(
                "station %s: its machine's clock and this one's differ by %.2f s, so poses seem "
                "too old or too new: let NTP keep both",
                self._keys.station,
                late_s,
            )
        self._clocks_differ = differ

    def _take(self, name: str, value: object) -> None:
        """Write a message into the store, once."""
        if not isinstance(value, bytes):
            return
        message = unpack(value)
        if message.generation == self._heard.get(name, message.generation):
            return
        self._heard[name] = message.generation
        try:
            self._write(name, message)
        except StoreError as error:  # of another version: the next one may fit
            _LOG.warning("station %s: a %s was left out: %s", self._keys.station, name, error)

    def _write(self, name: str, message: Message) -> None:
        mailbox = published(self._store)[name]
        if name in self._store.pictures:
            picture = unpack_picture(message.payload)
            generation = self._here(picture.generation)
            mailbox.write(pack_picture(generation, picture.captured_at_us, picture.jpeg))
            return
        generation = mailbox.write(message.payload)
        if name == SNAPSHOT:
            self._generations.append((message.generation, generation))

    def _here(self, there: int) -> int:
        """The generation that a snapshot of the worker's machine has in this one's store."""
        known = [here for other, here in self._generations if other <= there]
        return known[-1] if known else 0

    def _pass_wishes_on(self, client: redis.Redis, now_s: float) -> None:
        for kind in Picture:
            if self._store.wanted(kind) and now_s - self._wished_at_s[kind] > WANTED_S / 4:
                self._wished_at_s[kind] = now_s
                client.publish(self._keys.to_worker, f"{WANT}\n{kind}")
