"""What the stream sends, and when, without a network."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import pytest
from fastapi import WebSocket

from snapfit.server.routes.pose_query import ViewQuery
from snapfit.server.routes.stream import _send_all
from snapfit.server.station import Station
from snapfit.server.watch import Moment

GOING_AWAY = 1001


class Bench:
    """A station, and a client that takes a while, during which other snapshots come.

    Args:
        seqs: of the snapshots; the next one comes while the last one is sent.
        later: whether one more comes after them.
    """

    def __init__(self, seqs: list[int], *, later: bool = False) -> None:
        self._seqs = seqs
        self._later = later
        self.said: list[str] = []
        self.is_ending = False
        self.watch = self

    def moment(self) -> Moment | None:
        return Moment("boot", self._seqs[0], False, 0) if self._seqs else None

    def poses(self, _view: object) -> Any:
        text = str(self._seqs[0])
        return SimpleNamespace(body=lambda _now_us: text.encode())

    def now_us(self) -> int:
        return 0

    async def send_text(self, text: str) -> None:
        self.said.append(text)
        if len(self._seqs) > 1:
            del self._seqs[0]

    async def change(self, _limit_s: float) -> None:
        self.said.append("waits")
        self.is_ending = not self._later
        if self._later:
            self._later, self._seqs = False, [9]

    async def sent(self) -> list[str]:
        reading: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        query = SimpleNamespace(view=lambda _station: None)
        code = await _send_all(
            cast("WebSocket", self),
            cast("Station", self),
            cast("ViewQuery", query),
            cast("asyncio.Task[None]", reading),
        )
        assert code == GOING_AWAY
        return self.said


@pytest.mark.parametrize(
    ("bench", "sent"),
    [
        (Bench([1, 2, 3]), ["1", "2", "3", "waits"]),
        (Bench([1], later=True), ["1", "waits", "9", "waits"]),
        (Bench([], later=True), ["waits", "9", "waits"]),
        (Bench([]), ["waits"]),
    ],
)
def test_it_waits_only_if_all_was_sent(bench: Bench, sent: list[str]) -> None:
    assert asyncio.run(bench.sent()) == sent
