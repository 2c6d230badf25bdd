"""Runs methods over one sequence: each frame is decoded once.

All start from the true poses of frame 0, but those that are to find the parts by themselves.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from snapfit.models.errors import SnapfitError
from snapfit.models.recording import Recording
from snapfit.tracking.benchmark.notes import Notes
from snapfit.tracking.benchmark.roster import (
    frame_step,
    is_told_poses,
    needs_true_state,
    starts_cold,
)
from snapfit.tracking.benchmark.run import Run
from snapfit.tracking.benchmark.sequences import SequenceFolder
from snapfit.tracking.errors import FrameError, TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.sources.images import read_frame

Progress = Callable[[str, float], None]


class Entrant:
    """A method on its way through a sequence."""

    def __init__(self, method: str, recording: Recording, progress: Progress | None) -> None:
        """Makes its tracker.

        Raises:
            TrackingError: as `create_tracker`.
        """
        self._method = method
        self._recording = recording
        self._tracker = create_tracker(
            method,
            recording.parts,
            recording.camera,
            progress,
            asset=recording.asset,
            frame_rate_hz=recording.frame_rate_hz,
        )
        self._is_cold = starts_cold(method)
        self._is_told_state = needs_true_state(method)
        self._told = ""
        self._notes = Notes(recording)
        self._step = frame_step(method)

    def track(self, number: int, frame: Frame) -> None:
        """Has it track a frame, the first one from the true poses, if it is given any.

        A method that remembers nothing is not shown every frame.

        Only `track` is timed; a detector's time is in it, also where it would look beside.

        Raises:
            TrackingError: it needs the true state and there is none, or it cannot start.
            FrameError: it refuses the frame.
        """
        if number % self._step:
            return
        if number == 0 and not self._is_cold:
            self._tracker.start(frame, self._recording.initial_poses)
        if self._is_told_state:
            self._tell_state(frame.name)
        begin_s, begin_cpu_s = time.perf_counter(), time.process_time()
        result = self._tracker.track(frame)
        took_ms = 1e3 * (time.perf_counter() - begin_s), 1e3 * (time.process_time() - begin_cpu_s)
        self._notes.take(number, result, took_ms)

    def judged(self, folder: SequenceFolder) -> Run:
        """Its run, when the sequence is over."""
        return self._notes.judged(
            folder,
            self._method,
            is_told_state=self._is_told_state,
            is_told_poses=is_told_poses(self._method),
        )

    def _tell_state(self, frame: str) -> None:
        state = self._recording.truth[frame].state
        if state is None:
            problem = f"needs the true state, and the ground truth of frame {frame} has none"
            raise TrackingError(problem)
        if state != self._told:
            self._tracker.set_state(state)
            self._told = state


def run_methods(
    folder: SequenceFolder,
    recording: Recording,
    methods: Sequence[str],
    progress: Progress | None = None,
) -> dict[str, Run | SnapfitError]:
    """Tracks through a sequence by all methods side by side.

    Images are read between two frames, never beside a tracker, which is timed.

    Args:
        folder: names of asset and condition.
        recording: from `open_sequence`.
        methods: names of `METHODS`.
        progress: called with a message and the share that is done, 0 to 1.

    Returns:
        By method its run; or why there is none, which does not stop the others.

    Raises:
        FrameError: an image cannot be read: a benchmark leaves no frame out.
    """
    entrants: dict[str, Entrant] = {}
    results: dict[str, Run | SnapfitError] = {}
    for method in methods:
        try:
            entrants[method] = Entrant(method, recording, progress)
        except SnapfitError as error:
            results[method] = error
    for number in range(len(recording.frames) if entrants else 0):
        frame = _read(recording, number)
        for method, entrant in list(entrants.items()):
            try:
                entrant.track(number, frame)
            except SnapfitError as error:
                results[method] = error
                del entrants[method]
        if progress is not None:
            progress(folder.name, (number + 1) / len(recording.frames))
    for method, entrant in entrants.items():
        results[method] = entrant.judged(folder)
    return results


def _read(recording: Recording, number: int) -> Frame:
    files = recording.frames[number]
    try:
        return read_frame(files, recording.camera, round(number * 1e9 / recording.frame_rate_hz))
    except FrameError as error:
        problem = f"{error.problem}: a benchmark needs every frame; render or copy it again"
        raise FrameError(files.name, problem) from error
