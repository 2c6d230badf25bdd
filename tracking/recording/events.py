"""Notes what comes to a tracker beside its frames, so that a replay can bring it again.

A finder works in a thread of its own: in which frame its answer comes depends on the machine and
its load. All else that a tracker does follows from its frames.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from snapfit.models.pose import Pose
from snapfit.tracking.finding.account import LookAccount
from snapfit.tracking.finding.catch_up import CatchUp
from snapfit.tracking.finding.lookout import Found, Lookout
from snapfit.tracking.frame import Frame
from snapfit.tracking.recording.records import EventRecord, found_event, matrix_of


class EventLog:
    """What came since the last frame; used in the tracking thread alone.

    Attributes:
        finds: names of the parts that the noted lookout can look for.
    """

    def __init__(self) -> None:
        self.finds: tuple[str, ...] = ()
        self._events: list[EventRecord] = []

    def add(self, event: EventRecord) -> None:
        """Notes an event."""
        self._events.append(event)

    def take(self) -> list[EventRecord]:
        """What was noted since the last call, in order."""
        events, self._events = self._events, []
        return events

    def lookout(self, lookout: Lookout) -> Lookout:
        """The same lookout, its answers noted."""
        self.finds = lookout.names
        return _NotedLookout(lookout, self)

    def catch_up(self, catch_up: CatchUp) -> CatchUp:
        """The same catching up, its results noted."""
        return _NotedCatchUp(catch_up, self)


def poses_event(kind: str, poses: Mapping[str, Pose]) -> EventRecord:
    """An event that brings poses: "start" or "caught_up"."""
    matrices = {name: matrix_of(pose) for name, pose in poses.items()}
    return EventRecord.model_validate({"kind": kind, "poses": matrices})


class _NotedLookout:
    def __init__(self, lookout: Lookout, log: EventLog) -> None:
        self.names = lookout.names
        self._lookout, self._log = lookout, log

    @property
    def account(self) -> LookAccount:
        return self._lookout.account

    def offer(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> bool:
        return self._lookout.offer(frame, wanted, known)

    def take(self) -> Found | None:
        found = self._lookout.take()
        if found is not None:
            self._log.add(found_event(found))
        return found

    def close(self) -> None:
        self._lookout.close()


class _NotedCatchUp:
    def __init__(self, catch_up: CatchUp, log: EventLog) -> None:
        self._catch_up, self._log = catch_up, log

    @property
    def is_busy(self) -> bool:
        return self._catch_up.is_busy

    def begin(
        self, frames: Sequence[Frame], starts: Mapping[str, Pose], *, are_rough: bool
    ) -> None:
        self._catch_up.begin(frames, starts, are_rough=are_rough)

    def add(self, frame: Frame) -> None:
        self._catch_up.add(frame)

    def take(self) -> Mapping[str, Pose] | None:
        poses = self._catch_up.take()
        if poses is not None:
            self._log.add(poses_event("caught_up", poses))
        return poses

    def close(self) -> None:
        self._catch_up.close()
