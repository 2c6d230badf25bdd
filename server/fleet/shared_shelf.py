"""Anchors in Redis, the same for all replicas of a station."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable, Iterable, Mapping
from http import HTTPStatus

import redis
from pydantic import BaseModel, ConfigDict, ValidationError

from snapfit.server.anchor_record import AnchorRecord, ViewRecord
from snapfit.server.anchor_shelf import Change, Records
from snapfit.server.boards import Board
from snapfit.server.fleet.keys import ANCHORS, KEPT_S, StationKeys, tell
from snapfit.server.fleet.link import connect
from snapfit.server.fleet.view_publisher import views_of
from snapfit.server.marker_message import MarkerMessage
from snapfit.server.problems import ProblemError

_COUNT = b"#"
"""The field that counts changes; no anchor has that name."""
_TRIES = 20
_HEAR_S = 1.0
_POLL_S = 0.004


class AnchorsChange(BaseModel):
    """What is told to all replicas.

    Attributes:
        count: of the changes so far, this one among them.
        put: new or changed anchors.
        gone: names of those that were deleted, or have expired.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    count: int
    put: tuple[AnchorRecord, ...] = ()
    gone: tuple[str, ...] = ()


class SharedShelf:
    """What one replica knows of the anchors.

    A change is made in Redis, and known here when Redis has told all replicas of it, in the same
    order. What is known stays known while Redis is away.

    Args:
        url: of Redis or Valkey.
        keys: of the station.
        why_away: why Redis cannot be asked now; None where it answers.
    """

    def __init__(self, url: str, keys: StationKeys, why_away: Callable[[], str | None]) -> None:
        self.records: Records = {}
        self.views: Mapping[Board, ViewRecord] = {}
        self._client = connect(url)
        self._keys = keys
        self._why_away = why_away
        self._count = 0

    async def change(self, change: Change) -> None:
        """Change the anchors of all replicas; waits for Redis, a few seconds at most.

        Raises:
            ProblemError: raised by the change; 503, Redis does not answer.
        """
        why_away = self._why_away()
        if why_away is not None:
            raise self._unavailable(why_away)
        try:
            count = await asyncio.to_thread(self._change, self._client, change)
        except (redis.RedisError, OSError) as error:
            raise self._unavailable("the store does not answer") from error
        give_up_at_s = time.monotonic() + _HEAR_S
        while self._count < count:
            if time.monotonic() > give_up_at_s:
                raise self._unavailable("the store does not answer")
            await asyncio.sleep(_POLL_S)

    def see(self, message: MarkerMessage) -> None:
        """Nothing: the worker's machine tells."""

    def keep(self, boards: Iterable[Board]) -> None:
        """Nothing: the worker's machine forgets what no replica wants."""

    def save(self, *, at_once: bool = False) -> None:
        """Nothing: Redis has it."""

    def close(self) -> None:
        """Let go of the connection."""
        self._client.close()

    def catch_up(self, client: redis.Redis) -> None:
        """Take all from Redis; one that has lost everything gets back what is known here."""
        count, records = _held(client.hgetall(self._keys.anchors))
        if count == 0 and self.records:
            self._change(client, lambda others: others or self.records)
            count, records = _held(client.hgetall(self._keys.anchors))
        # Views first: this is not the thread that answers, and whoever sees an anchor is told how
        # the camera sees its board. Of boards that Redis has lost the worker's machine will tell.
        self.views = {**self.views, **views_of(client.hgetall(self._keys.views))}
        self._count, self.records = count, records

    def hear_anchors(self, client: redis.Redis, value: bytes) -> None:
        """What another replica has changed, or this one."""
        told = AnchorsChange.model_validate_json(value)
        if told.count != self._count + 1:  # told and caught up at once, or Redis has lost it all
            self.catch_up(client)
            return
        left = {name: it for name, it in self.records.items() if name not in told.gone}
        self.records = {**left, **{record.anchor: record for record in told.put}}
        self._count = told.count

    def hear_view(self, value: bytes) -> None:
        """What the camera has seen."""
        record = ViewRecord.model_validate_json(value)
        self.views = {**self.views, record.board: record}

    def _change(self, client: redis.Redis, change: Change) -> int:
        """Change what Redis holds; the count of changes with this one."""
        for _ in range(_TRIES):
            with client.pipeline() as pipeline:
                try:
                    pipeline.watch(self._keys.anchors)  # type: ignore[no-untyped-call]
                    count, before = _held(pipeline.hgetall(self._keys.anchors))
                    told = _difference(count + 1, before, change(before))
                    pipeline.multi()
                    values = {it.anchor: it.model_dump_json().encode() for it in told.put}
                    pipeline.hset(self._keys.anchors, mapping={**values, "#": told.count})
                    if told.gone:
                        pipeline.hdel(self._keys.anchors, *told.gone)
                    pipeline.expire(self._keys.anchors, KEPT_S)
                    message = tell(ANCHORS, told.model_dump_json().encode())
                    pipeline.publish(self._keys.channel, message)
                    pipeline.execute()
                except redis.WatchError:  # another replica was faster
                    continue
                return told.count
        raise redis.RedisError(f"no change of {self._keys.anchors} after {_TRIES} tries")

    def _unavailable(self, why: str) -> ProblemError:
        return ProblemError(
            HTTPStatus.SERVICE_UNAVAILABLE,
            "store-unavailable",
            f"Anchors of station {self._keys.station} cannot be changed now: {why}. Ask again.",
            retry_after_s=1,
        )


def _difference(count: int, before: Records, after: Records) -> AnchorsChange:
    put = tuple(record for name, record in after.items() if before.get(name) is not record)
    gone = tuple(name for name in before if name not in after)
    return AnchorsChange(count=count, put=put, gone=gone)


def _held(fields: object) -> tuple[int, Records]:
    """How often the hash was changed, and what it holds; what another version wrote is left out."""
    held = dict(fields) if isinstance(fields, dict) else {}
    count = int(held.pop(_COUNT, b"0"))
    records = {}
    for value in held.values():
        with contextlib.suppress(ValidationError):
            record = AnchorRecord.model_validate_json(value)
            records[record.anchor] = record
    return count, records
