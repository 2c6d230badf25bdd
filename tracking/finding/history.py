"""What has become of each part so far: who is sure where it is, who is missing, who starts anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from snapfit.models.pose import Pose
from snapfit.models.symmetry import Symmetry, distance_modulo_symmetry
from snapfit.tracking.finding.finder import Hypothesis
from snapfit.tracking.finding.parameters import SelfStartParameters
from snapfit.tracking.result import PartEstimate, Status, TrackingResult


class History:
    """Notes a tracker's results.

    Args:
        symmetries: of all parts, by name, in order.
        tries_poses: whether the tracker compares poses that it is told with those it has.
        parameters: when parts count as seen, and when they start anew.
    """

    def __init__(
        self,
        symmetries: Mapping[str, Symmetry],
        parameters: SelfStartParameters,
        *,
        tries_poses: bool,
    ) -> None:
        self._symmetries, self._parameters = symmetries, parameters
        self._tries_poses = tries_poses
        self._last: dict[str, PartEstimate] = {}
        self._linked_to: dict[str, str | None] = {}
        self._lost_for = dict.fromkeys(symmetries, 0)
        self._unsure_for = dict.fromkeys(symmetries, 0)

    def add(self, result: TrackingResult) -> None:
        """Note what became of each part in a frame."""
        self._last = {each.part: each for each in result.parts}
        for name, each in self._last.items():
            if each.camera_from_body is not None:
                self._linked_to[name] = each.linked_to
            is_lost = each.status is Status.LOST
            self._lost_for[name] = self._lost_for[name] + 1 if is_lost else 0
            self._unsure_for[name] = 0 if self._is_sure(each) else self._unsure_for[name] + 1

    def begin(self, name: str) -> None:
        """A part starts anew."""
        self._lost_for[name] = self._unsure_for[name] = 0

    def sure(self) -> dict[str, Pose]:
        """Poses of the parts that are seen well, or follow from others, by name."""
        return {
            name: each.camera_from_body
            for name, each in self._last.items()
            if each.camera_from_body is not None and self._is_sure(each)
        }

    def missing(self) -> list[str]:
        """Names of the other parts: it is not known where they are by now."""
        sure = self.sure()
        return [name for name in self._symmetries if name not in sure]

    def is_searched(self, name: str) -> bool:
        """Whether a part is to start where it is found."""
        last = self._last.get(name)
        if last is None or last.status is Status.SEARCHING:
            return True
        if not self._tries_poses:
            # Whom such a tracker does not see, or only doubtfully for some time, starts anew.
            unseen = last.status in (Status.LOST, Status.PREDICTED)
            return unseen or self._unsure_for[name] > self._parameters.doubt_frames
        # A module comes back as a whole, from poses that are tried out.
        is_module = self._linked_to.get(name) is not None or name in self._linked_to.values()
        return not is_module and self._lost_for[name] > self._parameters.given_up_frames

    def is_new(self, hypothesis: Hypothesis) -> bool:
        """Whether a find tells of a part that has been started, and tells something new."""
        last, p = self._last.get(hypothesis.part), self._parameters
        if last is None or last.status is Status.SEARCHING:
            return False
        if last.camera_from_body is None or not self._is_sure(last):
            return True
        symmetry = self._symmetries[hypothesis.part]
        distance_m, angle_rad = distance_modulo_symmetry(
            last.camera_from_body, hypothesis.camera_from_body, symmetry
        )
        return bool(distance_m >= p.same_m or angle_rad >= p.same_rad)

    def tried_out(self, hypotheses: Sequence[Hypothesis]) -> dict[str, list[Pose]]:
        """Poses of finds that a tracker is to compare with those it has, by part."""
        proposed: dict[str, list[Pose]] = {}
        for each in hypotheses:
            if self._tries_poses and self.is_new(each):
                proposed.setdefault(each.part, []).append(each.camera_from_body)
        return proposed

    def _is_sure(self, estimate: PartEstimate) -> bool:
        seen = estimate.status in (Status.TRACKED, Status.INFERRED)
        return seen and estimate.confidence >= self._parameters.sure_confidence
