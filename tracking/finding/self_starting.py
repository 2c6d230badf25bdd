"""A tracker that finds its parts by itself: at the start, and again when they were lost.

Past the GBOT paper's re-initialisation: the finder works beside the tracker, what it saw is
carried forward by the motion since then, and a part goes there only where the tracker's own
likelihood says that this explains the frame better.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from snapfit.models.asset import Part
from snapfit.models.pose import Pose
from snapfit.models.symmetry import Symmetry, distance_modulo_symmetry
from snapfit.tracking.finding.assignment import Assignment
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.lookout import Found, Lookout
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.tracker import Tracker

_MEANWHILE_FRAMES = 60
"""So many frames are kept while the finder looks: 2 s, some 300 MB in 1280x720."""


@dataclass(frozen=True)
class SelfStartParameters:
    """When parts are looked for, and when they count as found.

    Attributes:
        every_frames: how often the finder looks while all parts are seen.
        trial_frames: so long after its start a part is on trial: ...
        least_confidence: ... with less than this it is searched for again.
        sure_confidence: of a part that is seen; others are looked for at once.
        same_m, same_rad: a find that is no farther from where a part is seen tells nothing new.
        given_up_frames: so long lost, a part is searched for as if it had never been seen: its
            colours may have changed with the light.
    """

    every_frames: int = 10
    trial_frames: int = 5
    least_confidence: float = 0.5
    sure_confidence: float = 0.5
    same_m: float = 0.01
    same_rad: float = 0.17
    given_up_frames: int = 90


class SelfStartingTracker:
    """Has the members of a `Tracker`, and needs no first pose.

    Args:
        tracker: that follows the parts.
        parts: that it follows, in order.
        lookout: that looks for them; closed with `close`.
        parameters: when.
        follower: another tracker of the same parts: it follows parts that start through the
            frames that came while they were looked for. None: they start where they were.
    """

    def __init__(
        self,
        tracker: Tracker,
        parts: Sequence[Part],
        lookout: Lookout,
        parameters: SelfStartParameters | None = None,
        follower: Tracker | None = None,
    ) -> None:
        self.names, self.camera, self.cameras = tracker.names, tracker.camera, tracker.cameras
        self._tracker, self._lookout, self._follower = tracker, lookout, follower
        self._meanwhile: deque[Frame] = deque(maxlen=_MEANWHILE_FRAMES)
        self._looked_at: Frame | None = None
        self._parameters = parameters or SelfStartParameters()
        self._symmetries: dict[str, Symmetry] = {part.name: part.symmetry for part in parts}
        self._assignment = Assignment(tracker.bodies)
        self._last: dict[str, PartEstimate] = {}
        self._then: dict[str, Pose] = {}
        self._trial = dict.fromkeys(self.names, 0)
        self._lost_for = dict.fromkeys(self.names, 0)
        self._since_look = self._parameters.every_frames

    def start(
        self, frame: Frame, camera_from_body: Mapping[str, Pose], *others: Frame | None
    ) -> None:
        """As `Tracker.start`, for parts whose poses are known; the others are searched for."""
        self._tracker.start(frame, camera_from_body, *others)

    def set_state(self, state: str) -> None:
        """As `Tracker.set_state`."""
        self._tracker.set_state(state)

    def close(self) -> None:
        """Look for parts no more."""
        self._lookout.close()

    def track(self, frame: Frame | None, *others: Frame | None) -> TrackingResult:
        """As `Tracker.track`; parts that were found meanwhile are started or tried out first."""
        found = self._lookout.take()
        if found is not None and frame is not None:
            self._use(found, frame, others)
        result = self._tracker.track(frame, *others)
        self._take_in(result)
        if frame is not None:
            self._meanwhile.append(frame)
            self._look(frame)
        return result

    def _use(self, found: Found, frame: Frame, others: Sequence[Frame | None]) -> None:
        """Start parts that are searched for; have poses of others tried out."""
        carried = [self._carried(each) for each in found.hypotheses]
        searched = [name for name in self.names if self._status(name) is Status.SEARCHING]
        known = {
            name: each.camera_from_body
            for name, each in self._last.items()
            if each.camera_from_body is not None and each.status is not Status.PREDICTED
        }
        starts = self._followed(self._assignment.assign(carried, searched, known))
        if starts:
            self._tracker.start(frame, starts, *others)
            self._trial.update(dict.fromkeys(starts, self._parameters.trial_frames))
        proposed: dict[str, list[Pose]] = {}
        for each in carried:
            if each.part not in searched and not self._is_told_already(each):
                proposed.setdefault(each.part, []).append(each.camera_from_body)
        if proposed and self._tracker.looks_for_parts:
            self._tracker.propose(proposed)

    def _followed(self, starts: Mapping[str, Pose]) -> Mapping[str, Pose]:
        """Where parts that start have gone since the frame in which they were found."""
        follower, frames = self._follower, list(self._meanwhile)
        if follower is None or not starts or not frames or frames[0] is not self._looked_at:
            return starts
        for name in follower.names:
            follower.stop(name)
        follower.start(frames[0], starts)
        result = follower.track(frames[0])
        for frame in frames[1:]:
            result = follower.track(frame)
        least = self._parameters.least_confidence
        return {
            each.part: each.camera_from_body
            for each in result.parts
            if each.part in starts and each.camera_from_body is not None
            if each.status is Status.TRACKED and each.confidence >= least
        }

    def _carried(self, hypothesis: Hypothesis) -> Hypothesis:
        """Where a find is by now: it went as the part was seen to go since."""
        then, now = self._then.get(hypothesis.part), self._last.get(hypothesis.part)
        if then is None or now is None or now.camera_from_body is None:
            return hypothesis
        pose = now.camera_from_body @ then.inverse() @ hypothesis.camera_from_body
        return Hypothesis(hypothesis.part, pose, hypothesis.score)

    def _is_told_already(self, hypothesis: Hypothesis) -> bool:
        """Whether the part is seen just there."""
        last, p = self._last.get(hypothesis.part), self._parameters
        if last is None or last.camera_from_body is None or not self._is_sure(last):
            return False
        symmetry = self._symmetries[hypothesis.part]
        distance_m, angle_rad = distance_modulo_symmetry(
            last.camera_from_body, hypothesis.camera_from_body, symmetry
        )
        return distance_m < p.same_m and angle_rad < p.same_rad

    def _take_in(self, result: TrackingResult) -> None:
        """Note what became of each part; one that does not stand its trial is searched for."""
        self._last = {each.part: each for each in result.parts}
        p = self._parameters
        for name, each in self._last.items():
            is_lost = each.status is Status.LOST
            self._lost_for[name] = self._lost_for[name] + 1 if is_lost else 0
            fails = self._trial[name] > 0 and each.confidence < p.least_confidence
            self._trial[name] -= min(self._trial[name], 1)
            if fails or self._lost_for[name] > p.given_up_frames:
                self._tracker.stop(name)
                self._trial[name] = self._lost_for[name] = 0

    def _look(self, frame: Frame) -> None:
        """Offer the frame where something is missing, and now and then."""
        self._since_look += 1
        missing = [name for name, each in self._last.items() if not self._is_sure(each)]
        if not missing and self._since_look < self._parameters.every_frames:
            return
        if self._lookout.offer(frame, missing or self.names):
            self._since_look = 0
            self._looked_at = frame
            self._meanwhile = deque([frame], maxlen=_MEANWHILE_FRAMES)
            self._then = {
                name: each.camera_from_body
                for name, each in self._last.items()
                if each.camera_from_body is not None
            }

    def _is_sure(self, estimate: PartEstimate) -> bool:
        seen = estimate.status in (Status.TRACKED, Status.INFERRED)
        return seen and estimate.confidence >= self._parameters.sure_confidence

    def _status(self, name: str) -> Status:
        last = self._last.get(name)
        return Status.SEARCHING if last is None else last.status
