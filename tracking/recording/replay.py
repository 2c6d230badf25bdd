"""Tracks a recording again: the same frames, the same answers of the finder, so the same poses."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from snapfit.models.asset import Asset
from snapfit.models.errors import SnapfitError
from snapfit.models.pose import Pose
from snapfit.tracking.errors import FrameError, RecordingError
from snapfit.tracking.finding.account import LookAccount
from snapfit.tracking.finding.create import self_starting
from snapfit.tracking.finding.lookout import Found
from snapfit.tracking.frame import Frame
from snapfit.tracking.methods import Progress, create_tracker
from snapfit.tracking.recording.reading import OpenRecording
from snapfit.tracking.recording.records import EventRecord, ResultRecord, found_of, pose_of
from snapfit.tracking.result import TrackingResult
from snapfit.tracking.tracker import Tracker


@dataclass(frozen=True, eq=False)
class Replayed:
    """A frame of a recording, tracked again.

    Attributes:
        record: what was said of it then.
        frame: its images; None where there are none in the recording.
        result: what is said of it now; None where it cannot be tracked.
        error: why not.
    """

    record: ResultRecord
    frame: Frame | None
    result: TrackingResult | None
    error: str | None = None


class _RecordedLookout:
    """Answers in the frames in which the finder answered then.

    One that was not taken yet keeps it busy, as it did.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names, self.account = tuple(names), LookAccount()
        self._found: Found | None = None
        self._is_busy = False

    def bring(self, event: EventRecord) -> None:
        """To be taken with the next frame."""
        self._found = found_of(event)

    def offer(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> bool:
        del frame, wanted, known
        if self._is_busy:
            return False
        self._is_busy = True
        return True

    def take(self) -> Found | None:
        found, self._found = self._found, None
        if found is not None:
            self._is_busy = False
        return found

    def close(self) -> None:
        """Nothing runs."""


class _RecordedCatchUp:
    """Has parts where they were in the frames in which they were caught up with then."""

    def __init__(self) -> None:
        self._poses: Mapping[str, Pose] | None = None
        self.is_busy = False

    def bring(self, event: EventRecord) -> None:
        """To be taken with the next frame."""
        self._poses = {name: pose_of(matrix) for name, matrix in event.poses.items()}

    def begin(
        self, frames: Sequence[Frame], starts: Mapping[str, Pose], *, are_rough: bool
    ) -> None:
        del frames, starts, are_rough
        self.is_busy = True

    def add(self, frame: Frame) -> None:
        """What came of it is known."""

    def take(self) -> Mapping[str, Pose] | None:
        poses, self._poses = self._poses, None
        if poses is not None:
            self.is_busy = False
        return poses

    def close(self) -> None:
        """Nothing runs."""


class Replay:
    """A recording that is tracked again.

    Attributes:
        recording: that is open; not closed here.
        asset: under assembly; None for loose parts.
        parts: that are tracked.
    """

    def __init__(
        self, recording: OpenRecording, asset: Asset | None = None, progress: Progress | None = None
    ) -> None:
        """Makes the tracker that the station had.

        Args:
            recording: that is open.
            asset: takes the place of the one that it names; must have the same parts.
            progress: told what is being done.

        Raises:
            RecordingError: nothing was tracked then, or a part's mesh is another one now.
            TrackingError: its method is not known here.
            ViewpointModelError: a viewpoint model can neither be read nor made.
        """
        station = recording.station
        if station.method is None:
            problem = "only frames were recorded, nothing was tracked: use snapfit track"
            raise RecordingError(recording.path, problem)
        self.recording = recording
        self.asset = recording.asset(asset)
        self.parts = recording.parts(self.asset)
        self._check_parts()
        rate_hz = station.frame_rate_hz
        tracker = create_tracker(
            station.method, self.parts, recording.camera, progress, asset=self.asset
        )
        self._lookout = _RecordedLookout(station.finds)
        self._catch_up = _RecordedCatchUp()
        # An operator acts on the tracker proper.
        self._proper: Any = tracker
        self._tracker: Any = tracker
        if station.detector is not None and isinstance(tracker, Tracker):
            self._tracker = self_starting(
                tracker,
                self._lookout,
                self._catch_up,
                station.detector,
                self.parts,
                rate_hz,
                self.asset,
            )

    def run(self) -> Iterator[Replayed]:
        """Tracks frame after frame; those that were not recorded are passed over."""
        for recorded in self.recording.results:
            record = self.recording.record(recorded)
            try:
                frame = self.recording.frame(recorded)
            except FrameError as error:
                self._bring(record.events)
                yield Replayed(record, None, None, str(error))
                continue
            try:
                yield Replayed(record, frame, self._track(frame, record.events))
            except SnapfitError as error:
                yield Replayed(record, frame, None, str(error))

    def _track(self, frame: Frame, events: Sequence[EventRecord]) -> TrackingResult:
        tracker = self._tracker
        self._bring(events)
        for event in events:
            if event.kind == "start":
                poses = {name: pose_of(matrix) for name, matrix in event.poses.items()}
                tracker.start(frame, poses)
            elif event.kind == "set_state":
                self._proper.set_state(event.name)
            elif event.kind == "stop":
                self._proper.stop(event.name)
        result: TrackingResult = tracker.track(frame)
        return result

    def _bring(self, events: Sequence[EventRecord]) -> None:
        for event in events:
            if event.kind == "found":
                self._lookout.bring(event)
            elif event.kind == "caught_up":
                self._catch_up.bring(event)

    def _check_parts(self) -> None:
        there = {part.name: part.mesh.digest for part in self.parts}
        for part in self.recording.station.parts:
            if there.get(part.name) != part.mesh:
                problem = (
                    f"the part {part.name} is not the one that was tracked then: "
                    "name the same asset, or track it anew with snapfit track"
                )
                raise RecordingError(self.recording.path, problem)
