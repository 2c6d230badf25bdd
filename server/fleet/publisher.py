"""Publishes a station from the machine that its worker runs on."""

from __future__ import annotations

import logging
import os
import secrets
import socket
import time

import redis

from snapfit.server.clock import Clock
from snapfit.server.fleet.asset_upload import AssetUpload
from snapfit.server.fleet.keeper import Keeper
from snapfit.server.fleet.keys import (
    KEPT_S,
    LEASE_S,
    ORDERS,
    REPLIES,
    REPORT,
    STATUS,
    WANT,
    WANTED_S,
    StationKeys,
    ToldStatus,
    heard,
    pack,
    published,
    tell,
)
from snapfit.server.fleet.link import Link
from snapfit.server.fleet.order_relay import OrderRelay
from snapfit.server.fleet.view_publisher import ViewPublisher
from snapfit.server.mailbox import Mailbox
from snapfit.server.pose_store import Picture, PoseStore
from snapfit.server.schemas import WorkerReport
from snapfit.server.supervisor import SupervisorStatus
from snapfit.server.worker_spec import WorkerSpec

_POLL_S = 0.004  # far below a frame's time
_RENEW_S = 1.0
_LEASE_MS = round(LEASE_S * 1000)
# Take the lease if it is nobody's, renew it if it is ours.
_HOLD = """
local holder = redis.call('GET', KEYS[1])
if holder and holder ~= ARGV[1] then return holder end
redis.call('SET', KEYS[1], ARGV[1], 'PX', ARGV[2])
return ARGV[1]
"""
_GIVE_UP = """
if redis.call('GET', KEYS[1]) == ARGV[1] then redis.call('DEL', KEYS[1], KEYS[2]) end
return 0
"""
_LOG = logging.getLogger(__name__)


class Publisher:
    """A keeper that also tells Redis how its worker does and what it says.

    Only who holds the station's lease publishes. A second machine with the same station waits
    for the lease to run out, and then takes over.

    Args:
        url: of Redis or Valkey.
        spec: of the worker.
        store: of this machine, that the worker writes to.
        keeper: of the worker.
    """

    def __init__(self, url: str, spec: WorkerSpec, store: PoseStore, keeper: Keeper) -> None:
        self._keys = StationKeys(spec.station)
        self._clock = Clock(spec.wall_minus_monotonic_ns)
        self._store = store
        self._keeper = keeper
        self._me = f"{socket.gethostname()}:{os.getpid()}:{secrets.token_hex(4)}"
        self._held_until_s = 0.0
        self._relay = OrderRelay(spec.station, store)
        self._views = ViewPublisher(store, self._keys)
        self._assets = AssetUpload()
        self._status = keeper.status
        self._told_of = ""
        self._link = Link(url, f"publish-{spec.station}", self._publish)

    @property
    def status(self) -> SupervisorStatus:
        """How the worker does."""
        return self._keeper.status

    def start(self) -> None:
        """Start the worker, and to publish."""
        self._keeper.start()
        self._link.start()

    def close(self) -> None:
        """End both; the station is given up at once."""
        self._keeper.close()
        self._link.close()

    @property
    def _holds(self) -> bool:
        """Whether the lease is ours, as far as is known."""
        return time.monotonic() < self._held_until_s

    def _publish(self, client: redis.Redis) -> None:
        sent = dict.fromkeys(published(self._store), 0)
        renew_at_s = 0.0
        is_known = False
        with client.pubsub(ignore_subscribe_messages=True) as channel:  # type: ignore[no-untyped-call]
            channel.subscribe(self._keys.to_worker)
            while not self._link.stop.is_set():
                told = channel.get_message(timeout=_POLL_S)
                if told is not None:
                    self._hear(told["data"])
                now_s = time.monotonic()
                if now_s >= renew_at_s:
                    renew_at_s = now_s + _RENEW_S
                    self._held_until_s = now_s + LEASE_S if self._renew(client) else 0.0
                if not self._holds:
                    continue
                if not is_known:
                    is_known = True
                    self._views.connect(client)
                    self._assets.connected()
                self._tell_news(client, sent)
        if self._holds:
            client.eval(_GIVE_UP, 2, self._keys.lease, self._keys.status, self._me)

    def _tell_news(self, client: redis.Redis, sent: dict[str, int]) -> None:
        """All that was not told yet."""
        if self._keeper.status != self._status:
            self._send_status(client)
        for name, mailbox in published(self._store).items():
            if mailbox.latest != sent[name]:
                sent[name] = self._send(client, name, mailbox)
        for replies in self._relay.look():
            client.publish(self._keys.channel, tell(REPLIES, replies))
        self._views.look(client, self._relay.boards)
        self._assets.step(client)

    def _renew(self, client: redis.Redis) -> bool:
        holder = client.eval(_HOLD, 1, self._keys.lease, self._me, str(_LEASE_MS))
        name = holder.decode() if isinstance(holder, bytes) else str(holder)
        if name != self._me:
            if name != self._told_of:
                _LOG.error(
                    "station %s is published by %s already: waiting until it ends",
                    self._keys.station,
                    name.rpartition(":")[0],
                )
            self._told_of = name
            return False
        self._told_of = ""
        self._send_status(client)
        return True

    def _hear(self, told: bytes) -> None:
        """What a replica wants; of another version it may want what is not known here."""
        name, value = heard(told)
        if name == WANT and value.decode() in self._store.pictures:
            self._store.want(Picture(value.decode()), WANTED_S)
        elif name == ORDERS and self._holds:
            self._relay.hear(value)

    def _send(self, client: redis.Redis, name: str, mailbox: Mailbox) -> int:
        """Publish the latest message; its generation."""
        message = mailbox.read()
        if message is None:
            return 0
        if name == REPORT:
            self._assets.serve(WorkerReport.model_validate_json(message.payload).asset_folder)
        value = pack(message)
        # Pictures are large and few want them: who does fetches them.
        told = value if name not in self._store.pictures else b""
        pipeline = client.pipeline(transaction=False)
        pipeline.set(self._keys.message(name), value, ex=KEPT_S)
        pipeline.publish(self._keys.channel, tell(name, told))
        pipeline.execute()
        return message.generation

    def _send_status(self, client: redis.Redis) -> None:
        """How the worker does, which replicas have to know as soon as its poses."""
        self._status = self._keeper.status
        value = ToldStatus(self._status, self._clock.now_us()).dump()
        pipeline = client.pipeline(transaction=False)
        pipeline.set(self._keys.status, value, px=_LEASE_MS)
        pipeline.publish(self._keys.channel, tell(STATUS, value))
        pipeline.execute()
