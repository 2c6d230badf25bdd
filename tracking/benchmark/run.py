"""Runs one method over one sequence from the true pose of frame 0, and judges every frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Pose
from snapfit.models.recording import Recording
from snapfit.tracking.benchmark.judge import MISSED, PartJudge, PoseErrors
from snapfit.tracking.benchmark.sequences import SequenceFolder
from snapfit.tracking.errors import FrameError, TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.sources.images import read_frame

Array = npt.NDArray[np.float64]
Progress = Callable[[str, float], None]

STATUSES = tuple(Status)


@dataclass(frozen=True, eq=False)
class Run:
    """What a method did on a sequence: F frames, P parts.

    Attributes:
        asset, condition, method: as in the tables.
        parts: names.
        symmetric: whether each part has a symmetry.
        diameters_m: of each part.
        image_width: px.
        frame_rate_hz: of the sequence.
        frames: names.
        errors: (F, P, 5) as `PoseErrors.values`; infinite without an estimate.
        camera_from_body: (F, P, 4, 4) estimates, m; not a number without one.
        statuses: (F, P) index into `STATUSES`.
        visibility: (F, P) true share that is visible; not a number where unknown.
        times_ms: (F,) tracking of the whole frame, reading of images left out.
        true_states, states: (F,) assembly states, true and reported; "" where unknown.
    """

    asset: str
    condition: str
    method: str
    parts: tuple[str, ...]
    symmetric: npt.NDArray[np.bool_]
    diameters_m: Array
    image_width: int
    frame_rate_hz: float
    frames: npt.NDArray[np.str_]
    errors: Array
    camera_from_body: Array
    statuses: npt.NDArray[np.int8]
    visibility: Array
    times_ms: Array
    true_states: npt.NDArray[np.str_]
    states: npt.NDArray[np.str_]

    def error(self, name: str) -> Array:
        """(F, P) one kind of error, by the name of `PoseErrors`' attribute."""
        errors: Array = self.errors[:, :, list(PoseErrors.__dataclass_fields__).index(name)]
        return errors

    @property
    def has_estimate(self) -> npt.NDArray[np.bool_]:
        """(F, P) whether there is an estimate."""
        return np.isfinite(self.camera_from_body[:, :, 0, 0])

    def estimates(self, frame: int) -> tuple[PartEstimate, ...]:
        """The estimates of a frame, for drawing."""
        return tuple(
            PartEstimate(name, STATUSES[self.statuses[frame, i]], 0.0, self._pose(frame, i))
            for i, name in enumerate(self.parts)
        )

    def _pose(self, frame: int, part: int) -> Pose | None:
        matrix = self.camera_from_body[frame, part]
        return Pose(matrix) if np.isfinite(matrix[0, 0]) else None


def run_method(
    folder: SequenceFolder, recording: Recording, method: str, progress: Progress | None = None
) -> Run:
    """Tracks through a sequence.

    Images are read between two frames, never beside the tracker, which is timed.

    Args:
        folder: names of asset and condition.
        recording: from `open_sequence`.
        method: a name of `METHODS`.
        progress: called with a message and the share that is done, 0 to 1.

    Raises:
        TrackingError: as `create_tracker`.
        FrameError: an image cannot be read: a benchmark leaves no frame out.
    """
    tracker = create_tracker(method, recording.parts, recording.camera, progress)
    results = []
    for number, files in enumerate(recording.frames):
        frame = _read(recording, number)
        if number == 0:
            tracker.start(frame, recording.initial_poses)
        results.append(tracker.track(frame))
        if progress is not None:
            progress(f"{folder.name}: {method}", (number + 1) / len(recording.frames))
        if results[-1].frame != files.name:
            raise TrackingError(f"{method} answered frame {files.name} as {results[-1].frame}")
    return _judged(folder, recording, method, results)


def _read(recording: Recording, number: int) -> Frame:
    files = recording.frames[number]
    try:
        return read_frame(files, recording.camera, round(number * 1e9 / recording.frame_rate_hz))
    except FrameError as error:
        raise FrameError(files.name, f"{error.problem}: a benchmark needs every frame") from error


def _judged(
    folder: SequenceFolder, recording: Recording, method: str, results: Sequence[TrackingResult]
) -> Run:
    parts = recording.parts
    shape = (len(results), len(parts))
    errors = np.empty((*shape, len(MISSED.values)))
    poses = np.full((*shape, 4, 4), np.nan)
    statuses = np.zeros(shape, dtype=np.int8)
    visibility = np.full(shape, np.nan)
    truths = [recording.truth[frame.name] for frame in recording.frames]
    for i, part in enumerate(parts):
        judge = PartJudge(part, recording.camera.color)
        for f, (result, truth) in enumerate(zip(results, truths, strict=True)):
            estimate = next((each for each in result.parts if each.part == part.name), None)
            pose = estimate.camera_from_body if estimate else None
            errors[f, i] = judge.judge(pose, truth.camera_from_body[part.name]).values
            visibility[f, i] = truth.visibility.get(part.name, np.nan)
            if estimate is not None:
                statuses[f, i] = STATUSES.index(estimate.status)
            if pose is not None:
                poses[f, i] = pose.matrix
    return Run(
        asset=folder.asset,
        condition=folder.condition,
        method=method,
        parts=tuple(part.name for part in parts),
        symmetric=np.array([not part.symmetry.is_none for part in parts]),
        diameters_m=np.array([part.mesh.diameter_m for part in parts]),
        image_width=recording.camera.color.width,
        frame_rate_hz=recording.frame_rate_hz,
        frames=np.array([frame.name for frame in recording.frames]),
        errors=errors,
        camera_from_body=poses,
        statuses=statuses,
        visibility=visibility,
        times_ms=np.array([result.duration_ms for result in results]),
        true_states=np.array([truth.state or "" for truth in truths]),
        states=np.array([result.state or "" for result in results]),
    )
