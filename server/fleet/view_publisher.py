"""Publishes how the camera sees the boards of anchors, averaged nowhere else."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable

import redis
from pydantic import ValidationError

from snapfit.server.anchor_record import ViewRecord
from snapfit.server.board_views import BoardViews
from snapfit.server.boards import Board
from snapfit.server.fleet.keys import KEPT_S, VIEW, StationKeys, tell
from snapfit.server.marker_message import MarkerMessage
from snapfit.server.pose_store import PoseStore

_KEPT_UNWANTED_S = 600.0
"""All replicas may be away for a while: an anchor's board may not lie on the bench any more."""


class ViewPublisher:
    """Takes in what the worker sees of boards.

    Args:
        store: of the worker's machine.
        keys: of the station.
    """

    def __init__(self, store: PoseStore, keys: StationKeys) -> None:
        self._store = store
        self._keys = keys
        self._views = BoardViews()
        self._wanted_at_s: dict[Board, float] = {}
        self._seen = 0

    def connect(self, client: redis.Redis) -> None:
        """Go on from what another machine has seen; tell what Redis may have forgotten."""
        mine = list(self._views.records.values())
        held = [*views_of(client.hgetall(self._keys.views)).values()]
        self._want(record.board for record in held)
        self._views.put(record for record in held if record.board not in self._views.records)
        self._tell(client, mine)

    def look(self, client: redis.Redis, wanted: Iterable[Board]) -> None:
        """Tell what is new of these boards."""
        self._want(wanted)
        limit_s = time.monotonic() - _KEPT_UNWANTED_S
        self._wanted_at_s = {it: at for it, at in self._wanted_at_s.items() if at > limit_s}
        gone = self._views.keep(self._wanted_at_s)
        if gone:
            client.hdel(self._keys.views, *(board.model_dump_json() for board in gone))
        if self._store.markers.latest == self._seen:
            return
        self._seen = self._store.markers.latest
        message = self._store.markers.read()
        if message is not None:
            seen = MarkerMessage.model_validate_json(message.payload)
            self._tell(client, self._views.see(seen))

    def _want(self, boards: Iterable[Board]) -> None:
        self._wanted_at_s.update(dict.fromkeys(boards, time.monotonic()))

    def _tell(self, client: redis.Redis, records: list[ViewRecord]) -> None:
        if not records:
            return
        values = {it.board.model_dump_json(): it.model_dump_json().encode() for it in records}
        pipeline = client.pipeline(transaction=False)
        pipeline.hset(self._keys.views, mapping=values)
        pipeline.expire(self._keys.views, KEPT_S)
        for value in values.values():
            pipeline.publish(self._keys.channel, tell(VIEW, value))
        pipeline.execute()


def views_of(held: object) -> dict[Board, ViewRecord]:
    """What the hash in Redis holds, by board; what another version of snapfit wrote is left out."""
    records: dict[Board, ViewRecord] = {}
    for value in held.values() if isinstance(held, dict) else ():
        with contextlib.suppress(ValidationError):
            record = ViewRecord.model_validate_json(value)
            records[record.board] = record
    return records
