"""The GBOT paper's re-initialisation: every 10th frame, where detection is more than 5 cm away."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from snapfit.models.pose import Pose
from snapfit.tracking.finding.finder import Finder, Hypothesis
from snapfit.tracking.finding.lookout import look
from snapfit.tracking.frame import Frame
from snapfit.tracking.result import TrackingResult
from snapfit.tracking.tracker import Tracker


@dataclass(frozen=True)
class PaperReinitParameters:
    """As published (GBOT, section 3.3).

    Attributes:
        every_frames: how often parts are detected.
        apart_m: a part that is tracked farther from where it is detected is put there.
    """

    every_frames: int = 10
    apart_m: float = 0.05


class PaperReinitialisation:
    """Has the members of a `Tracker`; waits for the detector.

    Args:
        tracker: that follows the parts.
        finder: that detects them.
        parameters: when.
    """

    def __init__(
        self, tracker: Tracker, finder: Finder, parameters: PaperReinitParameters | None = None
    ) -> None:
        self.names, self.camera, self.cameras = tracker.names, tracker.camera, tracker.cameras
        self._tracker, self._finder = tracker, finder
        self._parameters = parameters or PaperReinitParameters()
        self._frame = 0
        self._last: dict[str, Pose | None] = {}

    def start(
        self, frame: Frame, camera_from_body: Mapping[str, Pose], *others: Frame | None
    ) -> None:
        """As `Tracker.start`."""
        self._tracker.start(frame, camera_from_body, *others)

    def set_state(self, state: str) -> None:
        """As `Tracker.set_state`."""
        self._tracker.set_state(state)

    def close(self) -> None:
        """Nothing runs."""

    def track(self, frame: Frame | None, *others: Frame | None) -> TrackingResult:
        """As `Tracker.track`, from where the parts are detected if that is far away."""
        self._frame += 1
        if frame is not None and self._last and self._frame % self._parameters.every_frames == 0:
            found = look(self._finder, frame, self.names).hypotheses
            self._tracker.put(self._far(found))
        result = self._tracker.track(frame, *others)
        self._last = {each.part: each.camera_from_body for each in result.parts}
        return result

    def _far(self, found: tuple[Hypothesis, ...]) -> dict[str, Pose]:
        """The surest find of each part that is tracked elsewhere, or not at all."""
        best: dict[str, Hypothesis] = {}
        for each in found:
            if each.part not in best or each.score > best[each.part].score:
                best[each.part] = each
        far = {}
        for name, each in best.items():
            tracked = self._last.get(name)
            if (
                tracked is None
                or tracked.distance_to(each.camera_from_body) > self._parameters.apart_m
            ):
                far[name] = each.camera_from_body
        return far
