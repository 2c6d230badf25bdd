"""How well a method notices that a part has been put where it does not belong.

A mistake is found if the method reports the part within 45 frames after it came to rest: it has to
stand still for some time before anybody can say that it is meant to stay there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from snapfit.models.pose import Pose
from snapfit.models.recording import Recording
from snapfit.models.symmetry import distance_modulo_symmetry
from snapfit.models.workbench.mistake import Mistake, MistakeFolder, read_mistake
from snapfit.tracking.assembly.estimate import Misassembly
from snapfit.tracking.benchmark.roster import check_methods, starts_cold
from snapfit.tracking.benchmark.sequences import SequenceFolder, open_sequence
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.method import MethodTracker
from snapfit.tracking.methods import METHODS, create_tracker
from snapfit.tracking.result import TrackingResult
from snapfit.tracking.sources.images import read_frame

FOUND_FRAMES = 45
_SETTLED_FRAMES = 15
_RIGHT_MM, _RIGHT_DEG = 10.0, 15.0

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Verdict:
    """What a method said of one mistake.

    Attributes:
        asset: the asset's name.
        sequence: name of its folder.
        method: the method's name.
        mistake: the truth.
        delay_frames: from the rest to the first report of the part; None if none came.
        reported_kind: the last report's kind within the time; "" without one.
        false_events: "frame: part kind" of each report of another part, or of one not at rest.
        last_state: assembly state reported in the last frame.
        off_mm: how wrong the part's pose against its parent was, 15 frames after it came to rest;
            None without an estimate.
        off_deg: likewise.
    """

    asset: str
    sequence: str
    method: str
    mistake: Mistake
    delay_frames: int | None
    reported_kind: str
    false_events: tuple[str, ...]
    last_state: str
    off_mm: float | None
    off_deg: float | None

    @property
    def is_found(self) -> bool:
        """Whether the part was reported in time."""
        return self.delay_frames is not None and self.delay_frames <= FOUND_FRAMES

    @property
    def is_named(self) -> bool:
        """Whether it was also said in what way it is wrong."""
        return self.is_found and self.reported_kind == self.mistake.kind

    @property
    def is_pose_right(self) -> bool:
        """Whether the part was tracked, within a centimetre and 15 degrees."""
        if self.off_mm is None or self.off_deg is None:
            return False
        return self.off_mm < _RIGHT_MM and self.off_deg < _RIGHT_DEG

    @property
    def is_state_right(self) -> bool:
        """Whether no step was taken to be done."""
        return self.last_state == self.mistake.state


def check_can_judge(methods: Sequence[str]) -> None:
    """Makes sure that methods follow the assembly graph by themselves.

    Raises:
        TrackingError: there is no such method, or it does not.
    """
    check_methods(methods)
    for method in methods:
        graph = METHODS[method].graph
        if graph is None or graph.is_told:
            able = [
                name
                for name, each in METHODS.items()
                if each.graph and not each.graph.is_told and not starts_cold(name)
            ]
            problem = f"{method} does not judge the assembly; --mistakes needs one of"
            raise TrackingError(f"{problem} {', '.join(able)}")
        if starts_cold(method):
            problem = "is told no first poses, and --mistakes tells them; name it without -cold"
            raise TrackingError(f"{method} {problem}")


def judge_mistake(folder: MistakeFolder, method: str, progress: Progress | None = None) -> Verdict:
    """Tracks through a sequence, told poses and state of its first frame, and judges the reports.

    Args:
        folder: the sequence.
        method: a name of `METHODS`.
        progress: called with a message and the share that is done, 0 to 1.

    Raises:
        SequenceError: the sequence is incomplete.
        TrackingError, FrameError: it cannot be tracked.
    """
    mistake = read_mistake(folder.directory)
    recording = open_sequence(SequenceFolder(folder.asset, "mistake", folder.directory))
    if mistake.rest_frame + FOUND_FRAMES >= len(recording.frames):
        problem = f"ends less than {FOUND_FRAMES} frames after the part came to rest"
        raise TrackingError(f"{folder.directory}: {problem}: render it again")
    tracker = create_tracker(
        method,
        recording.parts,
        recording.camera,
        asset=recording.asset,
        frame_rate_hz=recording.frame_rate_hz,
    )
    results = []
    for i, result in enumerate(_tracked(tracker, recording, mistake.state)):
        results.append(result)
        if progress is not None:
            progress(f"{folder.asset} {folder.directory.name}", (i + 1) / len(recording.frames))
    return _judged(folder, method, mistake, recording, results)


def _tracked(tracker: MethodTracker, recording: Recording, state: str) -> Iterator[TrackingResult]:
    for number, files in enumerate(recording.frames):
        captured_ns = round(number * 1e9 / recording.frame_rate_hz)
        frame = read_frame(files, recording.camera, captured_ns)
        if number == 0:
            tracker.start(frame, recording.initial_poses)
            tracker.set_state(state)
        yield tracker.track(frame)


def _judged(
    folder: MistakeFolder,
    method: str,
    mistake: Mistake,
    recording: Recording,
    results: Sequence[TrackingResult],
) -> Verdict:
    reports = [_reports(result) for result in results]
    rest, last = mistake.rest_frame, mistake.rest_frame + FOUND_FRAMES
    own = {
        frame: event
        for frame, events in enumerate(reports)
        for event in events
        if event.part == mistake.part and frame >= rest
    }
    in_time = [event for frame, event in own.items() if frame <= last]
    off_mm, off_deg = _off(mistake, recording, results)
    return Verdict(
        asset=folder.asset,
        sequence=folder.directory.name,
        method=method,
        mistake=mistake,
        delay_frames=min(own) - rest if own else None,
        reported_kind=in_time[-1].kind.value if in_time else "",
        false_events=tuple(_false_events(mistake, reports)),
        last_state=results[-1].state or "",
        off_mm=off_mm,
        off_deg=off_deg,
    )


def _reports(result: TrackingResult) -> tuple[Misassembly, ...]:
    return result.assembly.misassemblies if result.assembly else ()


def _false_events(mistake: Mistake, reports: Sequence[Sequence[Misassembly]]) -> Iterator[str]:
    """Each told once, when it comes up."""
    before: set[str] = set()
    for frame, events in enumerate(reports):
        for event in events:
            is_right = event.part == mistake.part and frame >= mistake.rest_frame
            if not is_right and event.part not in before:
                yield f"{frame}: {event.part} {event.kind}"
        before = {event.part for event in events}


def _off(
    mistake: Mistake, recording: Recording, results: Sequence[TrackingResult]
) -> tuple[float | None, float | None]:
    """Error (mm, deg) of the part's pose against its parent, symmetry taken out."""
    frame = mistake.rest_frame + _SETTLED_FRAMES
    truth = recording.truth[recording.frames[frame].name].camera_from_body
    found = {each.part: each.camera_from_body for each in results[frame].parts}
    part, parent = found.get(mistake.part), found.get(mistake.parent)
    if part is None or parent is None:
        return None, None
    right: Pose = truth[mistake.parent].inverse() @ truth[mistake.part]
    symmetry = next(each.symmetry for each in recording.parts if each.name == mistake.part)
    way_m, turn_rad = distance_modulo_symmetry(parent.inverse() @ part, right, symmetry)
    return round(1000 * way_m, 2), round(math.degrees(turn_rad), 2)


def median_delay(verdicts: Sequence[Verdict]) -> float:
    """Frames from rest to report, of the mistakes that were found; not a number if none was."""
    delays = [each.delay_frames or 0 for each in verdicts if each.is_found]
    return float(np.median(delays)) if delays else math.nan
