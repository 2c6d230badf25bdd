"""Finds parts again that were lost or hidden: poses are proposed, tried out, the likeliest kept.

Proposals lie where the part's colours are seen and no other part explains them, with the last
rotation and with others. Only few are tried in a frame, so that no frame takes long; the search
goes on in the next.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Array
from snapfit.tracking.body import Body
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Attempt, Optimiser
from snapfit.tracking.recovery.places import PlaceFinder
from snapfit.tracking.recovery.proposals import Proposer, Wanted
from snapfit.tracking.recovery.seen_through import SeenThrough
from snapfit.tracking.recovery.taken import TakenPlaces

_USUAL, _DOUBTFUL = 0.85, 0.45
_AGEING = 0.97


@dataclass(frozen=True)
class RegainParameters:
    """How parts are looked for.

    Attributes:
        tries: poses tried out in a frame, for all parts together.
        convincing: confidence that a found pose needs.
        least_evidence: lines and points that it needs.
        least_visibility: share of them that are not hidden, for a pose that is far away.
        forgotten_frames: so long unseen a part may be anywhere.
    """

    tries: int = 3
    convincing: float = 0.7
    least_evidence: int = 120
    least_visibility: float = 0.5
    forgotten_frames: int = 90


class Regainer:
    """Looks for parts through the frames of one camera.

    Args:
        bodies: all that are tracked.
        camera: where the frames come from.
        optimiser: tries poses out.
        seen_through: refutes them by the depth image.
        parameters: how.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        optimiser: Optimiser,
        seen_through: SeenThrough,
        parameters: RegainParameters | None = None,
    ) -> None:
        self._optimiser, self._seen_through = optimiser, seen_through
        self._parameters = parameters or RegainParameters()
        self._places = PlaceFinder(bodies, camera, optimiser)
        self._taken = TakenPlaces(bodies)
        # The order of the proposals is the same in each run: it depends on the frames alone.
        self._proposer = Proposer(bodies, np.random.default_rng(0))
        self._round = 0
        self._promising: dict[int, Attempt] = {}

    def search(
        self, frame: Frame, wanted: Mapping[int, Wanted], known: Collection[int] = ()
    ) -> dict[int, Attempt]:
        """Look for bodies; returns those that were found, with their poses.

        Args:
            frame: that the optimiser has seen.
            wanted: bodies, and what is known of them.
            known: bodies whose poses are sure: where one of them is, there is no other.
        """
        found: dict[int, Attempt] = {}
        self._promising = {body: best for body, best in self._promising.items() if body in wanted}
        if not wanted:
            self._round = 0
            return found
        poses = {body: self._optimiser.pose(body) for body in known}
        for body, n_tries in self._shares(wanted).items():
            best = self._try(frame, body, wanted[body], n_tries)
            if best is not None and not self._taken.is_taken(body, best.camera_from_body, poses):
                found[body] = best
        return found

    def _shares(self, wanted: Mapping[int, Wanted]) -> dict[int, int]:
        """How many tries each body has in this frame; they take turns with what is left over."""
        shares = dict.fromkeys(sorted(wanted), 0)
        searched = [body for body in shares if wanted[body].is_searched]
        for i in range(self._parameters.tries if searched else 0):
            shares[searched[(self._round + i) % len(searched)]] += 1
        self._round += self._parameters.tries
        return shares

    def _try(self, frame: Frame, body: int, wanted: Wanted, n_tries: int) -> Attempt | None:
        known = [self._proposer.center(body, pose) for pose in (wanted.expected, wanted.left)]
        places = [
            place
            for place in (self._places.find(frame, body) if n_tries else [])
            if _nearest(place.middle, known) < wanted.reach_m
        ]
        best = None
        for i in range(len(wanted.proposed) + n_tries):
            is_proposed = i < len(wanted.proposed)
            if is_proposed:
                pose = wanted.proposed[i]
            else:
                promising = self._promising.get(body)
                start = promising.camera_from_body if promising is not None else None
                pose = self._proposer.pose(body, wanted, places, start)
            tried = self._optimiser.attempt(body, pose)
            self._remember(body, tried)
            center = self._proposer.center(body, tried.camera_from_body)
            in_reach = _nearest(center, known) < wanted.reach_m
            if is_proposed and not in_reach:
                in_reach = self._may_be_far(frame, body, wanted, tried)
            good = in_reach and self._is_convincing(frame, body, wanted, tried)
            if good and (best is None or tried.likelihood > best.likelihood):
                best = tried
        return best

    def _may_be_far(self, frame: Frame, body: int, wanted: Wanted, tried: Attempt) -> bool:
        """Whether a body may be farther away than it can have gone unseen.

        A detector's false find is no reason to leave a place where the body is hidden. But a bench
        is knocked, and parts come back elsewhere: then the place where it was is seen to be empty,
        or what is seen there agrees badly. After some seconds nobody knows.
        """
        p, evidence = self._parameters, tried.evidence
        if wanted.unseen_frames >= p.forgotten_frames:
            return True
        if evidence.confidence < p.convincing or evidence.visibility < p.least_visibility:
            return False
        return wanted.is_doubted or self._seen_through.is_vacant(frame, body, wanted.expected)

    def _is_convincing(self, frame: Frame, body: int, wanted: Wanted, tried: Attempt) -> bool:
        """Whether there is enough evidence, it agrees, and the depth image does not object."""
        p, evidence = self._parameters, tried.evidence
        least = min(p.convincing, max(_USUAL * wanted.usual_confidence, _DOUBTFUL))
        enough = evidence.lines + evidence.points >= p.least_evidence
        if not (tried.solved and enough and evidence.confidence >= least):
            return False
        return not self._seen_through.contradicts(frame, body, tried.camera_from_body, evidence)

    def _remember(self, body: int, tried: Attempt) -> None:
        """Keep the likeliest pose so far, and go on from there; it ages, for the part may move."""
        best = self._promising.get(body)
        if best is not None:
            best = self._promising[body] = best._replace(likelihood=_AGEING * best.likelihood)
        if tried.solved and tried.likelihood > max(0.0, best.likelihood if best else 0.0):
            self._promising[body] = tried


def _nearest(point: Array, others: Sequence[Array]) -> float:
    return min(float(np.linalg.norm(point - other)) for other in others)
