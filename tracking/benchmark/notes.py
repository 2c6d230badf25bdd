"""Notes down what a method says of each frame, and has it judged when the sequence is over."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from snapfit.models.pose import Pose
from snapfit.models.recording import GroundTruth, Recording
from snapfit.tracking.benchmark.instances import matched
from snapfit.tracking.benchmark.judge import MISSED, PartJudge
from snapfit.tracking.benchmark.run import STATUSES, Array, Run
from snapfit.tracking.benchmark.sequences import SequenceFolder
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.result import TrackingResult


class Notes:
    """The results of one method on one sequence, as arrays: the results themselves are large."""

    def __init__(self, recording: Recording) -> None:
        """Makes room for every frame of a recording."""
        n_frames, n_parts = len(recording.frames), len(recording.parts)
        shape = (n_frames, n_parts)
        self._recording = recording
        self._column = {part.name: i for i, part in enumerate(recording.parts)}
        self._poses = np.full((*shape, 4, 4), np.nan)
        self._covariances = np.full((*shape, 6, 6), np.nan)
        self._confidences = np.zeros(shape)
        self._statuses = np.zeros(shape, dtype=np.int8)
        self._times_ms = np.zeros((2, n_frames))
        self._misassembled = np.zeros(shape, dtype=np.bool_)
        self._states = [""] * n_frames
        self._taken: list[int] = []

    def take(self, number: int, result: TrackingResult, took_ms: tuple[float, float]) -> None:
        """Notes down a frame.

        Args:
            number: of the frame in the recording.
            result: what the method said of it.
            took_ms: by the clock, and in time of a core.

        Raises:
            TrackingError: the result is that of another frame.
        """
        name = self._recording.frames[number].name
        if result.frame != name:
            raise TrackingError(f"frame {name} was answered as {result.frame}")
        self._taken.append(number)
        self._times_ms[:, number] = took_ms
        self._states[number] = result.state or ""
        for wrong in result.assembly.misassemblies if result.assembly else ():
            if wrong.part in self._column:
                self._misassembled[number, self._column[wrong.part]] = True
        for estimate in result.parts:
            i = self._column.get(estimate.part)
            if i is None:
                continue
            self._statuses[number, i] = STATUSES.index(estimate.status)
            self._confidences[number, i] = estimate.confidence
            if estimate.camera_from_body is not None:
                self._poses[number, i] = estimate.camera_from_body.matrix
                if estimate.covariance is not None:
                    self._covariances[number, i] = estimate.covariance

    def judged(
        self,
        folder: SequenceFolder,
        method: str,
        *,
        is_told_state: bool,
        is_told_poses: bool = True,
    ) -> Run:
        """The run, every frame judged that it was shown.

        Args:
            folder: names of asset and condition.
            method: its name.
            is_told_state: as in `Run`.
            is_told_poses: whether it was given first poses, and so which part is which.
        """
        recording = self._recording
        parts = recording.parts
        taken = self._taken
        names = [recording.frames[number].name for number in taken]
        truths = [recording.truth[name] for name in names]
        if not is_told_poses:
            self._match(truths)
        errors, nees = self._errors(names)
        visibility = [[t.visibility.get(part.name, np.nan) for part in parts] for t in truths]
        return Run(
            asset=folder.asset,
            condition=folder.condition,
            method=method,
            parts=tuple(part.name for part in parts),
            symmetric=np.array([not part.symmetry.is_none for part in parts]),
            diameters_m=np.array([part.mesh.diameter_m for part in parts]),
            image_width=recording.camera.color.width,
            frame_rate_hz=recording.frame_rate_hz,
            is_told_state=is_told_state,
            frames=np.array(names),
            errors=errors,
            nees=nees,
            confidences=self._confidences[taken],
            camera_from_body=self._poses[taken],
            statuses=self._statuses[taken],
            visibility=np.array(visibility, dtype=np.float64),
            times_ms=self._times_ms[0, taken],
            cpu_ms=self._times_ms[1, taken],
            misassembled=self._misassembled[taken],
            true_states=np.array([truth.state or "" for truth in truths]),
            states=np.array([self._states[number] for number in taken]),
        )

    def _match(self, truths: Sequence[GroundTruth]) -> None:
        """Give estimates of parts that are made alike to those that they are nearest to."""
        taken = np.array(self._taken, dtype=np.int64)[:, None]
        true_poses = [truth.camera_from_body for truth in truths]
        columns = matched(self._poses[self._taken], true_poses, self._recording.parts)
        for noted in (self._poses, self._covariances, self._confidences, self._statuses):
            noted[taken[:, 0]] = noted[taken, columns]

    def _errors(self, names: Sequence[str]) -> tuple[Array, Array]:
        """(F, P, 5) errors and (F, P, 3) normalised ones, of the frames taken."""
        shape = len(names), len(self._recording.parts)
        errors = np.empty((*shape, len(MISSED.values)))
        nees = np.empty((*shape, 3))
        for i, part in enumerate(self._recording.parts):
            judge = PartJudge(part, self._recording.camera.color)
            for f, (number, name) in enumerate(zip(self._taken, names, strict=True)):
                truth = self._recording.truth[name].camera_from_body[part.name]
                matrix, covariance = self._poses[number, i], self._covariances[number, i]
                judged, nees[f, i] = judge.judge(
                    Pose(matrix) if np.isfinite(matrix[0, 0]) else None,
                    truth,
                    covariance if np.isfinite(covariance[0, 0]) else None,
                )
                errors[f, i] = judged.values
        return errors, nees
