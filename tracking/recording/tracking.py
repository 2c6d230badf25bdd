"""Records what a tracker gets and what it says of it."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import Any, Protocol

from snapfit.models.errors import SnapfitError
from snapfit.models.pose import Pose
from snapfit.tracking.frame import Frame
from snapfit.tracking.recording.events import EventLog, poses_event
from snapfit.tracking.recording.recorder import Recorder
from snapfit.tracking.recording.records import EventRecord, error_fields, result_fields
from snapfit.tracking.result import TrackingResult


class RecordedTracker(Protocol):
    """What is needed of a tracker that is recorded."""

    def start(self, frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        """Begins with these poses in this frame."""

    def track(self, frame: Frame) -> TrackingResult:
        """Follows the parts into this frame."""


class RecordingTracker:
    """Has the members of a tracker; each frame goes to the recording with what is said of it.

    Args:
        tracker: that tracks.
        events: that also notes what works beside the tracker.
        recorder: where it goes; not closed here.
    """

    def __init__(self, tracker: RecordedTracker, events: EventLog, recorder: Recorder) -> None:
        self._tracker, self._events, self._recorder = tracker, events, recorder

    def start(self, frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        """As the tracker's."""
        self._tracker.start(frame, camera_from_body)
        self._events.add(poses_event("start", camera_from_body))

    def track(self, frame: Frame) -> TrackingResult:
        """As the tracker's."""
        try:
            result = self._tracker.track(frame)
        except SnapfitError as error:
            self._recorder.add(frame, self._events.take(), error_fields(error))
            raise
        self._recorder.add(frame, self._events.take(), result_fields(result))
        return result

    def __getattr__(self, name: str) -> Any:
        """What does not change what the tracker does, its names for instance."""
        return getattr(self._tracker, name)


class OperatorControls(Protocol):
    """What an operator can do to a tracker between two frames."""

    def set_state(self, state: str) -> None:
        """Says which assembly state holds."""

    def search(self, part: str) -> None:
        """Lets a part be looked for again."""


class RecordingControls:
    """Controls whose use is written down with the next frame.

    Args:
        controls: that act on the tracker proper, as a replay does.
        events: of the recording.
    """

    def __init__(self, controls: OperatorControls, events: EventLog) -> None:
        self._controls, self._events = controls, events

    def set_state(self, state: str) -> None:
        """As the controls'."""
        self._controls.set_state(state)
        self._events.add(EventRecord(kind="set_state", name=state))

    def search(self, part: str) -> None:
        """As the controls'."""
        self._controls.search(part)
        self._events.add(EventRecord(kind="stop", name=part))


class LogToRecording(logging.Handler):
    """Writes the log of snapfit into a recording."""

    def __init__(self, recorder: Recorder) -> None:
        super().__init__(logging.INFO)
        self._recorder = recorder

    def emit(self, record: logging.LogRecord) -> None:
        """Hand a line over."""
        try:
            text = record.getMessage()
        except (TypeError, ValueError):  # a line whose arguments do not fit it
            self.handleError(record)
            return
        self._recorder.log(round(record.created * 1e9), record.levelno, text, record.name)
