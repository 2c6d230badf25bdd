"""How soon all parts are tracked: from a cold start, and after the camera was covered.

Cold: a tracker that is given no pose begins anywhere in a sequence, also in the midst of the
assembly. Covered: a tracker that was told poses and state follows for a second; then the camera
sees nothing for two, while the world goes on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from snapfit.models.errors import SnapfitError
from snapfit.models.recording import GroundTruth, Recording
from snapfit.tracking.benchmark.covered import Cover, covered
from snapfit.tracking.benchmark.rightness import Rightness
from snapfit.tracking.benchmark.roster import (
    check_methods,
    finds_parts,
    follows_states,
    needs_true_state,
    starts_cold,
)
from snapfit.tracking.benchmark.sequences import SequenceFolder
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.method import MethodTracker
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.sources.images import read_frame

EVERY_FRAMES = 100
"""A trial begins at every hundredth frame of a sequence, as long as enough frames follow."""

LEAD_S, COVERED_S, LIMIT_S = 1.0, 2.0, 5.0
"""Tracking before the camera is covered, the cover, and when a trial is given up."""

Progress = Callable[[str, float], None]


class TrialKind(StrEnum):
    """What has to be recovered from."""

    COLD = "cold start"
    COVERED = "covered camera"


@dataclass(frozen=True)
class Trial:
    """A stretch of a sequence.

    Attributes:
        kind: what has to be recovered from.
        first: its first frame.
        covered_frames: of them the camera sees nothing; empty without a cover.
        judged_from: from here on it is asked whether all parts are right.
        end: the frame behind its last.
        cover: what is before the camera.
    """

    kind: TrialKind
    first: int
    covered_frames: range
    judged_from: int
    end: int
    cover: Cover = Cover.LENS


@dataclass(frozen=True)
class Recovered:
    """How long a method took in a trial.

    Attributes:
        asset, condition, method: as in the tables.
        kind: what it had to recover from.
        first_frame: number of the trial's first frame in the sequence.
        frames: from the first frame that shows a part to the first in which every part of which
            enough is seen is right; None if that did not come in time.
        rate_hz: of the frames.
        wrong: parts that were not right when the trial was given up.
    """

    asset: str
    condition: str
    method: str
    kind: TrialKind
    first_frame: int
    frames: int | None
    rate_hz: float
    wrong: tuple[str, ...] = ()


def check_can_recover(methods: Sequence[str]) -> None:
    """Makes sure that these methods can be tried.

    Raises:
        TrackingError: there is no such method, it is told the true states, or its name ends in
            `-cold`: of any that finds parts the cold start is measured.
    """
    check_methods(methods)
    for method in methods:
        if needs_true_state(method):
            raise TrackingError(f"{method} is told the true states: it recovers from nothing")
        if starts_cold(method):
            plain = method.removesuffix("-cold")
            raise TrackingError(f"--recovery tries {plain} from a cold start, too: name that")


def trials(n_frames: int, rate_hz: float) -> tuple[Trial, ...]:
    """All trials in a sequence; the two covers take turns."""
    lead, hidden, limit = (round(rate_hz * each) for each in (LEAD_S, COVERED_S, LIMIT_S))
    found = []
    for number, first in enumerate(range(0, n_frames - limit + 1, EVERY_FRAMES)):
        found.append(Trial(TrialKind.COLD, first, range(0), first, first + limit))
        begin, end = first + lead, first + lead + hidden
        if end + limit <= n_frames:
            cover = tuple(Cover)[number % len(Cover)]
            stretch = range(begin, end)
            found.append(Trial(TrialKind.COVERED, first, stretch, end, end + limit, cover))
    return tuple(found)


def run_trials(
    folder: SequenceFolder,
    recording: Recording,
    methods: Sequence[str],
    progress: Progress | None = None,
) -> tuple[list[Recovered], dict[str, SnapfitError]]:
    """Tries methods on all trials of a sequence.

    Args:
        folder: names of asset and condition.
        recording: from `open_sequence`.
        methods: names of `METHODS`, checked by `check_can_recover`.
        progress: called with a message and the share that is done, 0 to 1.

    Returns:
        What came out; and by method why there is nothing, which does not stop the others.

    Raises:
        TrackingError: the sequence is too short for a trial.
        FrameError: an image cannot be read.
    """
    todo = trials(len(recording.frames), recording.frame_rate_hz)
    if not todo:
        raise TrackingError(f"{folder.name}: shorter than {LIMIT_S:.0f} s: no trial fits")
    results: list[Recovered] = []
    problems: dict[str, SnapfitError] = {}
    for number, trial in enumerate(todo):
        trackers: dict[str, MethodTracker] = {}
        for method in methods:
            if method in problems or (trial.kind is TrialKind.COLD and not finds_parts(method)):
                continue
            try:
                trackers[method] = _tracker(method, recording)
            except SnapfitError as error:
                problems[method] = error
        results += _tried(folder, recording, trial, trackers)
        if progress is not None:
            progress(folder.name, (number + 1) / len(todo))
    return results, problems


def _tracker(method: str, recording: Recording) -> MethodTracker:
    rate_hz = recording.frame_rate_hz
    parts, camera = recording.parts, recording.camera
    return create_tracker(method, parts, camera, asset=recording.asset, frame_rate_hz=rate_hz)


def _tried(
    folder: SequenceFolder,
    recording: Recording,
    trial: Trial,
    trackers: Mapping[str, MethodTracker],
) -> list[Recovered]:
    """A trial by all trackers side by side, until all of them have recovered."""
    # Who was told which part is which is to know it afterwards.
    rightness = Rightness(recording.parts, interchangeable=trial.kind is TrialKind.COLD)
    began: int | None = None
    took: dict[str, int] = {}
    wrong: dict[str, tuple[str, ...]] = {}
    for number, frame in _frames(recording, trial) if trackers else ():
        truth = recording.truth[frame.name]
        if began is None and number >= trial.judged_from and rightness.shows(truth):
            began = number
        for method, tracker in trackers.items():
            if method in took:
                continue
            if number == trial.first and trial.kind is TrialKind.COVERED:
                _tell(tracker, method, frame, truth)
            estimates = {each.part: each.camera_from_body for each in tracker.track(frame).parts}
            if began is not None and rightness.shows(truth):
                wrong[method] = rightness.wrong(estimates, truth)
                if not wrong[method]:
                    took[method] = number - began
        if len(took) == len(trackers):
            break
    names = folder.asset, folder.condition
    where = trial.kind, trial.first
    return [
        Recovered(*names, method, *where, took.get(method), recording.frame_rate_hz, wrong[method])
        for method in trackers
        # In a trial that shows no part nothing can be found.
        if began is not None
    ]


def _tell(tracker: MethodTracker, method: str, frame: Frame, truth: GroundTruth) -> None:
    """The true poses and, where it is followed, the true state of a trial's first frame."""
    names = tracker.names
    tracker.start(frame, {name: truth.camera_from_body[name] for name in names})
    if follows_states(method) and truth.state is not None:
        tracker.set_state(truth.state)


def _frames(recording: Recording, trial: Trial) -> Iterator[tuple[int, Frame]]:
    rng = np.random.default_rng(trial.first)
    for number in range(trial.first, trial.end):
        captured_ns = round(number * 1e9 / recording.frame_rate_hz)
        frame = read_frame(recording.frames[number], recording.camera, captured_ns)
        if number in trial.covered_frames:
            frame = covered(frame, trial.cover, recording.camera.depth_scale_m, rng)
        yield number, frame
