"""A tracker that finds its parts by itself: at the start, and again when they were lost.

Past the GBOT paper's re-initialisation: the finder works beside the tracker, what it saw is
carried forward by the motion since then, and a part goes there only where the tracker's own
likelihood says that this explains the frame better.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace

from snapfit.models.asset import Part
from snapfit.models.pose import Pose
from snapfit.tracking.finding.account import FindingAccount
from snapfit.tracking.finding.assignment import Assignment
from snapfit.tracking.finding.catch_up import CatchUp
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.history import History
from snapfit.tracking.finding.lookout import Found, Lookout
from snapfit.tracking.finding.parameters import SelfStartParameters
from snapfit.tracking.finding.twins import Twins
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import Status, TrackingResult
from snapfit.tracking.tracker import Tracker

_MEANWHILE_FRAMES = 60
"""So many frames are kept while the finder looks: 2 s, some 300 MB in 1280x720."""
_TWINS_EVERY_FRAMES = 10
_HIDDEN = 0.4
"""Of a part on trial: with less visibility it is not judged."""


class SelfStartingTracker:
    """Has the members of a `Tracker`, and needs no first pose.

    Args:
        tracker: that follows the parts.
        parts: that it follows, in order.
        lookout: that looks for them; closed with `close`.
        parameters: when.
        catch_up: follows parts that start through the frames that came while they were looked
            for. None: they start where they were.
        twins: says which of several parts of one mesh is which, where there are any.
    """

    def __init__(
        self,
        tracker: Tracker,
        parts: Sequence[Part],
        lookout: Lookout,
        parameters: SelfStartParameters | None = None,
        catch_up: CatchUp | None = None,
        twins: Twins | None = None,
    ) -> None:
        self.names, self.camera, self.cameras = tracker.names, tracker.camera, tracker.cameras
        self._tracker, self._lookout, self._catch_up = tracker, lookout, catch_up
        self._twins, self._n_frames = twins, 0
        self._meanwhile: deque[Frame] = deque(maxlen=_MEANWHILE_FRAMES)
        self._parameters = parameters or SelfStartParameters()
        self._history = History(
            {part.name: part.symmetry for part in parts},
            self._parameters,
            tries_poses=tracker.looks_for_parts,
        )
        self._assignment = Assignment(tracker.bodies)
        self._found_as = self._assignment.found_as(lookout.names)
        self._then: Mapping[str, Pose] = {}
        self._trial = dict.fromkeys(self.names, 0)
        self._since_look = self._parameters.every_frames
        self._found_in: tuple[Frame, Mapping[str, Pose]] | None = None
        self._started = self._dropped = 0

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
        if self._catch_up is not None:
            self._catch_up.close()

    @property
    def account(self) -> FindingAccount:
        """What has become of looking for parts so far."""
        return FindingAccount(self._lookout.account, self._started, self._dropped)

    def track(self, frame: Frame | None, *others: Frame | None) -> TrackingResult:
        """As `Tracker.track`; parts that were found meanwhile are started or tried out first."""
        if frame is not None:
            found = self._lookout.take()
            if found is not None:
                self._use(found, frame, others)
            if self._catch_up is not None and (starts := self._catch_up.take()) is not None:
                self._arrive(frame, starts, others)
        result = self._tracker.track(frame, *others)
        self._history.add(result)
        self._judge_trials(result)
        self._exchange_twins(result)
        if frame is not None:
            self._keep(frame)
            self._look(frame)
        return result

    def _use(self, found: Found, frame: Frame, others: Sequence[Frame | None]) -> None:
        """Follow what is missing to where it is now; have poses of others tried out."""
        known = self._history.sure()
        carried = [self._carried(each, known) for each in found.hypotheses]
        places = self._assignment.assign(carried, self._history.missing(), known)
        if self._catch_up is None:
            self._begin(frame, places, others, are_rough=True)
            places = {}
        elif places:
            are_rough = not all(each.is_refined for each in found.hypotheses)
            frames = list(self._meanwhile) or [frame]
            self._found_in = None if are_rough else (frames[0], places)
            self._catch_up.begin(frames, places, are_rough=are_rough)
        self._meanwhile.clear()
        # A find that is followed is tried out where it leads to.
        self._try_out([each for each in carried if each.part not in places])

    def _arrive(
        self, frame: Frame, arrived: Mapping[str, Pose], others: Sequence[Frame | None]
    ) -> None:
        """Use poses of parts that were found, and followed since."""
        others_found = [
            Hypothesis(name, pose, 1.0)
            for name, pose in arrived.items()
            if not self._history.is_searched(name)
        ]
        self._begin(frame, arrived, others, are_rough=False)
        self._found_in = None
        self._try_out(others_found)

    def _try_out(self, hypotheses: Sequence[Hypothesis]) -> None:
        """Have the tracker compare poses of parts that have been started with those it has."""
        if proposed := self._history.tried_out(hypotheses):
            self._tracker.propose(proposed)

    def _begin(
        self,
        frame: Frame,
        starts: Mapping[str, Pose],
        others: Sequence[Frame | None],
        *,
        are_rough: bool,
    ) -> None:
        """Start parts where they are now, on trial."""
        starts = {
            name: pose
            for name, pose in starts.items()
            if self._history.is_searched(name) and pose.translation[2] > 0
        }
        if not starts:
            return
        for name in starts:
            self._tracker.stop(name)
            self._history.begin(name)
        if self._found_in is None or len(self.cameras) > 1:
            self._tracker.start(frame, starts, *others, are_rough=are_rough)
        else:
            # A hand may hide them by now: their colours are those of the frame that was looked at.
            seen_in, found = self._found_in
            self._tracker.start(seen_in, {name: found[name] for name in starts}, are_rough=False)
            self._tracker.put(starts)
        self._trial.update(dict.fromkeys(starts, self._parameters.trial_frames))
        self._started += len(starts)

    def _carried(self, hypothesis: Hypothesis, known: Mapping[str, Pose]) -> Hypothesis:
        """Where a find is by now: it went as the part was seen to go since."""
        then, now = self._then.get(hypothesis.part), known.get(hypothesis.part)
        if then is None or now is None:
            return hypothesis
        pose = now @ then.inverse() @ hypothesis.camera_from_body
        return replace(hypothesis, camera_from_body=pose)

    def _judge_trials(self, result: TrackingResult) -> None:
        """A part that does not stand its trial is searched for."""
        for each in result.parts:
            # What is hidden neither stands its trial nor fails: it goes on when it is seen again.
            is_hidden = each.status is not Status.LOST and each.visibility < _HIDDEN
            if self._trial[each.part] == 0 or is_hidden:
                continue
            self._trial[each.part] -= 1
            if each.confidence < self._parameters.least_confidence:
                self._tracker.stop(each.part)
                self._history.begin(each.part)
                self._dropped += 1
                self._trial[each.part] = 0

    def _exchange_twins(self, result: TrackingResult) -> None:
        """Who assembles takes any of two parts that look the same: it is the one that belongs."""
        self._n_frames += 1
        if self._twins is None or result.state is None or self._n_frames % _TWINS_EVERY_FRAMES:
            return
        carriers = {each.linked_to for each in result.parts}
        free = [it.part for it in result.parts if it.linked_to is None and it.part not in carriers]
        if exchanged := self._twins.exchanged(self._history.sure(), free):
            self._tracker.put(exchanged)
            self._then = {}  # what is found now was looked for under the other name

    def _keep(self, frame: Frame) -> None:
        """Keep what comes while parts are looked for that will start."""
        if self._meanwhile:
            self._meanwhile.append(frame)
        if self._catch_up is not None:
            self._catch_up.add(frame)

    def _look(self, frame: Frame) -> None:
        """Offer the frame where something is missing, and now and then."""
        self._since_look += 1
        missing = self._history.missing()
        wanted = dict.fromkeys(each for name in missing for each in self._found_as[name])
        if not wanted and self._since_look < self._parameters.every_frames:
            return
        if self._catch_up is not None and self._catch_up.is_busy:
            return
        sure = self._history.sure()
        if self._lookout.offer(frame, tuple(wanted) or self._lookout.names, sure):
            self._since_look = 0
            self._meanwhile.clear()
            if missing:
                self._meanwhile.append(frame)
            self._then = sure
