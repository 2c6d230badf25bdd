"""Parts that start: from the frame in which they were found to where they are now.

A finder takes a second, and a part in a hand goes far in a second. So another tracker follows it
through the frames that came meanwhile, before the tracker proper takes it over.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Mapping, Sequence
from typing import Protocol

from snapfit.models.errors import SnapfitError
from snapfit.models.pose import Pose
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.threads import started_pair
from snapfit.tracking.tracker import Tracker

_LOG = logging.getLogger(__name__)
_LEAST_CONFIDENCE = 0.5
_HIDDEN = 0.4
_MOST_FRAMES = 150
"""Who is not there after so many frames never will be: this machine is too slow for it."""
_MOST_HELD, _BEHIND = 60, 20
"""So many frames wait at most (300 MB in 1280x720); of more than so many every second is left out.
"""


class CatchUp(Protocol):
    """Follows parts to the newest frame, one group at a time."""

    @property
    def is_busy(self) -> bool:
        """Whether a group is followed, or was and has not been taken yet."""

    def begin(
        self, frames: Sequence[Frame], starts: Mapping[str, Pose], *, are_rough: bool
    ) -> None:
        """Follow parts.

        Args:
            frames: at least one; the parts were found in the first.
            starts: `camera_from_body` by part, there.
            are_rough: as in `Tracker.start`.
        """

    def add(self, frame: Frame) -> None:
        """A newer frame, while it is busy."""

    def take(self) -> Mapping[str, Pose] | None:
        """Where the parts are in the newest frame, once; None while they are followed.

        Those that could not be followed are left out.
        """

    def close(self) -> None:
        """Follow no more."""


class ImmediateCatchUp:
    """Follows at once, while the tracker waits: for recordings, the same in each run.

    Args:
        follower: of the same parts as the tracker, and used here alone.
    """

    def __init__(self, follower: Tracker) -> None:
        self._pursuit = _Pursuit(follower)
        self._poses: Mapping[str, Pose] | None = None

    @property
    def is_busy(self) -> bool:
        """As in `CatchUp`."""
        return self._poses is not None

    def begin(
        self, frames: Sequence[Frame], starts: Mapping[str, Pose], *, are_rough: bool
    ) -> None:
        """As in `CatchUp`."""
        self._pursuit.start(frames[0], starts, are_rough=are_rough)
        for frame in frames[1:]:
            self._pursuit.follow(frame)
        self._poses = self._pursuit.poses()

    def add(self, frame: Frame) -> None:
        """As in `CatchUp`; there is nothing left to do."""

    def take(self) -> Mapping[str, Pose] | None:
        """As in `CatchUp`."""
        poses, self._poses = self._poses, None
        return poses

    def close(self) -> None:
        """Nothing runs."""


class CatchUpThread:
    """Follows in a thread of its own: the tracker never waits.

    As in `LookoutThread`, one thread leaves the cores to the tracker, and another does what
    concerns all parts: then there is no tracker to disturb.

    Args:
        follower: of the same parts as the tracker, and used in these threads alone.
    """

    def __init__(self, follower: Tracker) -> None:
        self._names = frozenset(follower.names)
        self._pursuit = _Pursuit(follower)
        self._changed = threading.Condition()
        self._begun: tuple[Mapping[str, Pose], bool] | None = None
        self._frames: list[Frame] = []
        self._poses: Mapping[str, Pose] | None = None
        self._is_busy = False
        self._closed = threading.Event()
        self._threads = started_pair(self._run, "catch-up")

    @property
    def is_busy(self) -> bool:
        """As in `CatchUp`."""
        return self._is_busy

    def begin(
        self, frames: Sequence[Frame], starts: Mapping[str, Pose], *, are_rough: bool
    ) -> None:
        """As in `CatchUp`."""
        with self._changed:
            self._frames, self._begun, self._is_busy = list(frames), (starts, are_rough), True
            self._changed.notify_all()

    def add(self, frame: Frame) -> None:
        """As in `CatchUp`."""
        with self._changed:
            if self._is_busy and self._poses is None:
                self._frames.append(frame)
                if len(self._frames) > _MOST_HELD:
                    # The first is where they were found, the last where they are to be.
                    del self._frames[1:-1:2]

    def take(self) -> Mapping[str, Pose] | None:
        """As in `CatchUp`."""
        with self._changed:
            poses, self._poses = self._poses, None
            if poses is not None:
                self._is_busy = False
        return poses

    def close(self) -> None:
        """As in `CatchUp`; waits for the frame that is in work."""
        with self._changed:
            self._closed.set()
            self._changed.notify_all()
        for thread in self._threads:
            thread.join()

    def _is_for(self, is_urgent: bool) -> bool:
        """Whether there are parts to follow, all of them or not."""
        return self._begun is not None and (self._names <= set(self._begun[0])) == is_urgent

    def _run(self, is_urgent: bool) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed.is_set() or self._is_for(is_urgent))
                if self._closed.is_set() or self._begun is None:
                    return
                (starts, are_rough), self._begun = self._begun, None
            poses: Mapping[str, Pose] = {}
            try:
                poses = self._followed(starts, are_rough=are_rough)
            except Exception:  # noqa: BLE001  # a bug here costs a start, and tracking goes on
                _LOG.exception("following parts that were found failed")
            with self._changed:
                self._poses, self._frames = poses, []

    def _followed(self, starts: Mapping[str, Pose], *, are_rough: bool) -> Mapping[str, Pose]:
        n_followed = 0
        while not self._closed.is_set() and n_followed <= _MOST_FRAMES:
            frame = self._next(is_first=n_followed == 0)
            if frame is None:
                break
            if n_followed == 0:
                self._pursuit.start(frame, starts, are_rough=are_rough)
            else:
                self._pursuit.follow(frame)
            n_followed += 1
        return self._pursuit.poses()

    def _next(self, *, is_first: bool) -> Frame | None:
        """The next frame, or the one after it where this falls behind; None at the newest."""
        with self._changed:
            if not self._frames:
                return None
            if len(self._frames) > _BEHIND and not is_first:
                del self._frames[0]
            return self._frames.pop(0)


class _Pursuit:
    """A tracker that begins anew with each group of parts."""

    def __init__(self, follower: Tracker) -> None:
        self._follower = follower
        self._parts: Mapping[str, Pose] = {}
        self._result: TrackingResult | None = None
        self._are_rough = True

    def start(self, frame: Frame, starts: Mapping[str, Pose], *, are_rough: bool) -> None:
        for name in self._follower.names:
            self._follower.stop(name)
        self._parts, self._result, self._are_rough = starts, None, are_rough
        try:
            self._follower.start(frame, starts, are_rough=are_rough)
            self._result = self._follower.track(frame)
        except SnapfitError as error:
            _LOG.warning("parts that were found cannot be started: %s", error)

    def follow(self, frame: Frame) -> None:
        if self._result is not None:
            self._result = self._follower.track(frame)

    def poses(self) -> Mapping[str, Pose]:
        """Where the parts are that are seen well; those that were found for sure may be hidden."""
        if self._result is None:
            return {}
        return {
            each.part: each.camera_from_body
            for each in self._result.parts
            if each.part in self._parts and each.camera_from_body is not None
            if self._is_followed(each)
        }

    def _is_followed(self, estimate: PartEstimate) -> bool:
        if estimate.status is Status.PREDICTED:
            return not self._are_rough and estimate.visibility < _HIDDEN
        return estimate.status is Status.TRACKED and estimate.confidence >= _LEAST_CONFIDENCE
