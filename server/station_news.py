"""What happens at a station besides its poses: events, anchors, the time spent in each state."""

from __future__ import annotations

from typing import Any

from snapfit.server.anchor_shelf import AnchorShelf
from snapfit.server.anchors import Anchor, Anchors
from snapfit.server.answers import SnapshotAnswers
from snapfit.server.clock import Clock
from snapfit.server.command_desk import CommandDesk
from snapfit.server.event_detector import EventDetector
from snapfit.server.events import EventKind, EventLog
from snapfit.server.marker_message import MarkerMessage
from snapfit.server.pose_store import PoseStore
from snapfit.server.state_clock import StateClock


class StationNews:
    """Takes in each snapshot, and what the camera sees of markers.

    Args:
        station: its name.
        store: of the station.
        clock: the server's time line.
        commands: told which boards the camera shall look for.
        shelf: keeps the anchors.

    Attributes:
        events: what happened.
        anchors: clients' worlds.
        state_clock: how long each assembly state has held.
    """

    def __init__(
        self,
        station: str,
        store: PoseStore,
        clock: Clock,
        commands: CommandDesk,
        shelf: AnchorShelf,
    ) -> None:
        self._station = station
        self._store = store
        self._clock = clock
        self._detector = EventDetector()
        self._markers_seen = 0
        self._identity: dict[str, Any] = {}
        self._shelf = shelf
        self.events = EventLog()
        self.anchors = Anchors(
            station, clock.now_us, shelf, commands.look_for, self._on_anchor_drift
        )
        self.state_clock = StateClock()
        self.anchors.update()

    def take_in(self, answers: SnapshotAnswers | None, *, stale: bool) -> None:
        """Another snapshot, or the latest one has become stale; None before the first one."""
        self._look_at_markers()
        self.anchors.update()
        self._shelf.save()
        if answers is None:
            return
        self._identity = answers.identity
        assembly = answers.snapshot.get("assembly")
        self.state_clock.enter(None if stale or assembly is None else assembly["state"])
        for kind, data in self._detector.happened(answers.snapshot, stale=stale):
            self._tell(kind, data)

    def _look_at_markers(self) -> None:
        if self._store.markers.latest == self._markers_seen:
            return
        self._markers_seen = self._store.markers.latest
        message = self._store.markers.read()
        if message is not None:
            self._shelf.see(MarkerMessage.model_validate_json(message.payload))

    def _on_anchor_drift(self, anchor: Anchor) -> None:
        drift = {} if anchor.drift is None else anchor.drift._asdict()
        self._tell(EventKind.ANCHOR_DRIFT, {"anchor": anchor.name, **drift})

    def _tell(self, kind: EventKind, data: dict[str, Any]) -> None:
        """Note an event, at the latest snapshot."""
        header = {"station": self._station, "at_us": self._clock.now_us(), **self._identity}
        self.events.add(kind, {**header, **data})
