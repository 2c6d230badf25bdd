"""The boards that the camera sees, each with its latest poses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from snapfit.server.anchor_record import ViewRecord, view_record
from snapfit.server.boards import Board
from snapfit.server.marker_message import MarkerMessage


class BoardViews:
    """Takes in what the camera sees of the boards that somebody wants.

    Attributes:
        records: by board; another mapping after each change.
    """

    def __init__(self) -> None:
        self.records: Mapping[Board, ViewRecord] = {}
        self._wanted: frozenset[Board] = frozenset()

    def keep(self, boards: Iterable[Board]) -> list[Board]:
        """Look at these boards alone; those that are forgotten now."""
        self._wanted = frozenset(boards)
        gone = [board for board in self.records if board not in self._wanted]
        if gone:
            self.records = {it: self.records[it] for it in self.records if it in self._wanted}
        return gone

    def put(self, records: Iterable[ViewRecord]) -> None:
        """Go on from what was seen before."""
        self.records = {**self.records, **{record.board: record for record in records}}

    def see(self, message: MarkerMessage) -> list[ViewRecord]:
        """Take in a frame's markers; what is new."""
        news = [
            view_record(self.records.get(marker.board), marker, message.captured_at_us)
            for marker in message.seen
            if marker.board in self._wanted
        ]
        if news:
            self.put(news)
        return news
