"""What happens to parts that are not seen: carried with the hand, looked for, taken back.

A part that is hidden goes where the hand before it goes; one that is lost or in doubt is looked
for; poses that somebody proposes, a detector for one, are tried out beside. A part goes elsewhere
only where the same likelihood says that this explains the frame better.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.confidence import LossJudge
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Attempt, Optimiser
from snapfit.tracking.recovery.carried import CarriedParts
from snapfit.tracking.recovery.proposals import Wanted
from snapfit.tracking.recovery.regain import Regainer
from snapfit.tracking.recovery.seen_through import SeenThrough
from snapfit.tracking.result import PartEstimate, Status

_IN_DOUBT, _MARGIN, _PROBATION_FRAMES, _SEEN_WELL = 0.5, 60.0, 45, 0.12
_AGREES, _AS_USUAL = 0.9, 0.8


class Recovery:
    """Keeps account of parts that are not seen, and brings them back.

    Args:
        bodies: all that are tracked.
        camera: where the frames come from.
        optimiser: whose bodies they are.
        judge: that tells lost parts.
        seen_through: refutes poses by the depth image.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        optimiser: Optimiser,
        judge: LossJudge,
        seen_through: SeenThrough,
    ) -> None:
        self._optimiser, self._judge = optimiser, judge
        self._regainer = Regainer(bodies, camera, optimiser, seen_through)
        self._carried = CarriedParts(bodies, camera)
        self._expected: dict[int, Pose] = {}
        self._left: dict[int, Pose] = {}
        self._unseen = [0] * len(bodies)
        self._probation = [0] * len(bodies)
        self._proposed: dict[int, tuple[Pose, ...]] = {}

    def propose(self, camera_from_body: Mapping[int, Sequence[Pose]]) -> None:
        """Let poses of bodies be tried out in the next frame."""
        self._proposed = {body: tuple(poses) for body, poses in camera_from_body.items()}

    def forget(self, body: int) -> None:
        """A body is started anew: where it was says nothing any more."""
        self._expected.pop(body, None)
        self._left.pop(body, None)
        self._unseen[body] = self._probation[body] = 0

    def follow(self, frame: Frame, estimates: Sequence[PartEstimate]) -> list[int]:
        """Take in a frame; returns the bodies whose poses jumped.

        Args:
            frame: that the optimiser has seen.
            estimates: of all bodies, in order.
        """
        self._carry(frame, estimates)
        return self._regain(frame, estimates)

    def _carry(self, frame: Frame, estimates: Sequence[PartEstimate]) -> None:
        """Let hidden parts go with the hand that hides them, for the next frame."""
        seen, hidden = {}, {}
        for body, each in enumerate(estimates):
            if each.status is Status.TRACKED:
                # Where little is seen or agrees, a pose trembles: no motion can be read from it.
                agrees = each.confidence > _AGREES * self._judge.usual(body)
                if agrees and each.visibility > _SEEN_WELL:
                    seen[body] = self._optimiser.pose(body)
            elif each.status is Status.PREDICTED:
                hidden[body] = self._optimiser.pose(body)
        for body, pose in self._carried.follow(frame, seen, hidden).items():
            if self._optimiser.structures.root(body) == body:
                self._optimiser.move(body, pose)
                self._expected[body] = pose

    def _regain(self, frame: Frame, estimates: Sequence[PartEstimate]) -> list[int]:
        """Look for parts that are lost, hidden or in doubt, or were found again just now."""
        wanted, known = {}, []
        proposed, self._proposed = self._proposed, {}
        for body, each in enumerate(estimates):
            sure = self._take_in(body, each)
            if sure:
                known.append(body)
            searched = body in self._expected and (not sure or self._probation[body] > 0)
            if self._is_carried(body, estimates) or not (searched or body in proposed):
                continue
            doubted = each.status is Status.TRACKED and not sure
            wanted[body] = self._wanted(
                body, proposed.get(body, ()), is_searched=searched, is_doubted=doubted
            )
        jumped = []
        for body, found in self._regainer.search(frame, wanted, known).items():
            if self._is_better(body, found, estimates[body]):
                self._take_back(body, found.camera_from_body)
                jumped.append(body)
        return jumped

    def _take_in(self, body: int, estimate: PartEstimate) -> bool:
        """Note where a body is seen; returns whether that is sure."""
        self._unseen[body] += 1
        least = max(_IN_DOUBT, _AS_USUAL * self._judge.usual(body))
        sure = estimate.status is Status.TRACKED and estimate.confidence >= least
        if sure:
            self._expected[body] = self._optimiser.pose(body)
            self._probation[body] -= min(self._probation[body], 1)
            if not self._probation[body]:
                self._left[body], self._unseen[body] = self._expected[body], 0
        return sure

    def _wanted(
        self, body: int, proposed: tuple[Pose, ...], *, is_searched: bool, is_doubted: bool
    ) -> Wanted:
        here = self._expected.get(body, self._optimiser.pose(body))
        return Wanted(
            here,
            self._left.get(body, here),
            self._unseen[body],
            self._judge.usual(body),
            proposed,
            is_searched,
            is_doubted,
        )

    def _is_better(self, body: int, found: Attempt, estimate: PartEstimate) -> bool:
        if estimate.status is not Status.TRACKED:
            return True
        return bool(found.likelihood > self._optimiser.likelihoods[body] + _MARGIN)

    def _take_back(self, body: int, pose: Pose) -> None:
        """Put a body, and its module, where it was found; for a while it is looked for still."""
        self._optimiser.carry_back(body, pose)
        for member in self._optimiser.structures.members(body):
            self._judge.reset(int(member))
        self._probation[body] = _PROBATION_FRAMES

    def _is_carried(self, body: int, estimates: Sequence[PartEstimate]) -> bool:
        """Whether a body is linked to another one that is seen: its module needs no search."""
        members = self._optimiser.structures.members(body)
        return any(m != body and estimates[int(m)].status is Status.TRACKED for m in members)
