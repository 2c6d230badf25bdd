"""What an API replica hears of a station whose worker runs on another machine."""

from __future__ import annotations

import dataclasses
import logging
import time
from collections import deque

import orjson
import redis

from snapfit.server.clock import Clock
from snapfit.server.errors import StoreError
from snapfit.server.fleet.asset_download import AssetDownload
from snapfit.server.fleet.keys import (
    ANCHORS,
    LEASE_S,
    REPLIES,
    REPORT,
    SNAPSHOT,
    STATUS,
    VIEW,
    WANT,
    WANTED_S,
    StationKeys,
    ToldStatus,
    heard,
    published,
    tell,
    unpack,
)
from snapfit.server.fleet.link import Link
from snapfit.server.fleet.order_sender import OrderSender
from snapfit.server.fleet.shared_shelf import SharedShelf
from snapfit.server.logs.secrets import without_secrets
from snapfit.server.mailbox import Message
from snapfit.server.picture_message import pack_picture, unpack_picture
from snapfit.server.pose_store import Picture, PoseStore
from snapfit.server.supervisor import SupervisorStatus
from snapfit.server.worker_spec import WorkerSpec

_CLOCKS_DIFFER_S = 0.2
# Clocks are compared by a few statuses, heard over more time than it takes to hear what has queued.
_COMPARED, _COMPARED_OVER_S = 3, 3.0
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

    Attributes:
        shelf: the station's anchors.
    """

    def __init__(self, url: str, spec: WorkerSpec, store: PoseStore) -> None:
        self._keys = StationKeys(spec.station)
        self._clock = Clock(spec.wall_minus_monotonic_ns)
        self._clocks_differ = False
        self._late_s: list[float] = []
        self._late_since_s = 0.0
        self._store = store
        self._told = without_secrets(url)
        self._last = SupervisorStatus()
        self._valid_until_s = 0.0
        self._answered_at_s = 0.0
        self._wished_at_s = dict.fromkeys(Picture, 0.0)
        self._heard = dict.fromkeys(published(store), 0)
        # Generations there and here: pictures name the snapshot that they belong to.
        self._generations: deque[tuple[int, int]] = deque(maxlen=_SNAPSHOTS_REMEMBERED)
        self._orders = OrderSender(store, self._keys)
        self._asset = AssetDownload()
        self._report: Message | None = None
        self._left_out: set[str] = set()
        self.shelf = SharedShelf(url, self._keys, self._why_away)
        self._link = Link(url, f"subscribe-{spec.station}", self._subscribe)

    @property
    def status(self) -> SupervisorStatus:
        """How the worker does; where its lease has run out, why nothing is known of it."""
        now_s = time.monotonic()
        if now_s < self._valid_until_s:
            return self._last
        absent = self._why_away()
        if absent is None:
            absent = "no worker has the lease of this station: start `snapfit worker`"
        return dataclasses.replace(self._last, boot_id=None, pid=None, absent=absent)

    def _why_away(self) -> str | None:
        if time.monotonic() - self._answered_at_s > LEASE_S:
            return f"the store at {self._told} does not answer"
        return None

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
                    name, value = heard(told["data"])
                    try:
                        self._hear(client, name, value)
                    except (StoreError, ValueError) as error:
                        self._leave_out(name, error)
                now_s = time.monotonic()
                if now_s >= look_at_s:
                    look_at_s = now_s + _LOOK_S
                    self._take_status(client.get(self._keys.status))
                self._pass_wishes_on(client, now_s)
                self._orders.look(client)
                if self._asset.step(client) and self._report is not None:
                    self._write(REPORT, self._report)

    def _catch_up(self, client: redis.Redis) -> None:
        """What was said before this replica listened."""
        # The worker's machine may have been started anew, and counts from 1 again.
        self._heard = dict.fromkeys(self._heard, 0)
        self._orders.connected()
        self._asset.connected()
        self.shelf.catch_up(client)
        for name in self._heard:
            if name not in self._store.pictures:
                try:
                    self._take(name, client.get(self._keys.message(name)))
                except (StoreError, ValueError) as error:
                    self._leave_out(name, error)

    def _hear(self, client: redis.Redis, name: str, value: bytes) -> None:
        if name == STATUS:
            self._take_status(value)
            self._compare_clocks(ToldStatus.load(value).sent_at_us)
        elif name == REPLIES:
            self._orders.hear(value)
        elif name == ANCHORS:
            self.shelf.hear_anchors(client, value)
        elif name == VIEW:
            self.shelf.hear_view(value)
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
        now_s = time.monotonic()
        if not self._late_s:
            self._late_since_s = now_s
        self._late_s.append((self._clock.now_us() - sent_at_us) / 1e6)
        over_s = now_s - self._late_since_s
        if len(self._late_s) < _COMPARED or over_s < _COMPARED_OVER_S:
            return
        # A message may be held up, and only seem later for it: the quickest shows the clocks.
        late_s = min(self._late_s)
        self._late_s.clear()
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
        if name not in self._heard:  # of another version
            return
        message = unpack(value)
        if message.generation == self._heard[name]:
            return
        self._heard[name] = message.generation
        self._write(name, message)

    def _leave_out(self, name: str, error: Exception) -> None:
        """Of another version of snapfit: the next one may fit."""
        if name not in self._left_out:
            self._left_out.add(name)
            station = self._keys.station
            _LOG.warning("station %s: a %s was left out (told once): %s", station, name, error)

    def _write(self, name: str, message: Message) -> None:
        mailbox = published(self._store)[name]
        if name in self._store.pictures:
            picture = unpack_picture(message.payload)
            generation = self._here(picture.generation)
            mailbox.write(pack_picture(generation, picture.captured_at_us, picture.jpeg))
            return
        payload = message.payload if name != REPORT else self._reported(message)
        generation = mailbox.write(payload)
        if name == SNAPSHOT:
            self._store.doorbell.ring()
            self._generations.append((message.generation, generation))

    def _reported(self, message: Message) -> bytes:
        """A report that names the asset's folder on this machine, where there is one."""
        self._report = message
        report = orjson.loads(message.payload)
        self._asset.serve(report.get("asset_folder"))
        folder = self._asset.folder
        return orjson.dumps({**report, "asset_folder": None if folder is None else str(folder)})

    def _here(self, there: int) -> int:
        """The generation that a snapshot of the worker's machine has in this one's store."""
        known = [here for other, here in self._generations if other <= there]
        return known[-1] if known else 0

    def _pass_wishes_on(self, client: redis.Redis, now_s: float) -> None:
        for kind in Picture:
            if self._store.wanted(kind) and now_s - self._wished_at_s[kind] > WANTED_S / 4:
                self._wished_at_s[kind] = now_s
                client.publish(self._keys.to_worker, tell(WANT, kind.encode()))
