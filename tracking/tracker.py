"""The tracker: the per-frame loop over all bodies (ICG; GBOT, section 3.2)."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Asset
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.calibration import Calibration
from snapfit.tracking.camera_view import RigCamera
from snapfit.tracking.confidence import NO_EVIDENCE, REGION_SHARE, Evidence, LossJudge
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.following import GraphFollower, GraphParameters
from snapfit.tracking.frame import Frame, fitting_frames
from snapfit.tracking.optimiser import Optimiser
from snapfit.tracking.parameters import StartParameters, TrackerParameters
from snapfit.tracking.recovery.recovery import Recovery
from snapfit.tracking.recovery.seen_through import SeenThrough
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.start import start_variations

_IN_DOUBT = 0.5


class Tracker:
    """Tracks several bodies through the frames of one RGB-D camera, or of several on one bench.

    Attributes:
        bodies: what is tracked.
        names: theirs, in order.
        camera: where the frames come from; of several, the first: poses are in its frame.
        cameras: all of them.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        parameters: TrackerParameters | None = None,
        *,
        asset: Asset | None = None,
        graph: GraphParameters | None = None,
        rig: Sequence[RigCamera] = (),
    ) -> None:
        """Make a tracker; nothing is tracked before `start`.

        Args:
            bodies: what is tracked.
            camera: where the frames come from.
            parameters: of the modalities and the optimiser.
            asset: with the assembly graph that is followed; needed with `graph`.
            graph: how the assembly graph is followed; None to track every body by itself.
            rig: further cameras that see the same bench, and where they stand.

        Raises:
            TrackingError: no body, depth alone without a depth camera, or no assembly graph.
        """
        if not bodies:
            raise TrackingError("a tracker needs at least one body")
        parameters = parameters or TrackerParameters()
        self.bodies = tuple(bodies)
        self.names = tuple(body.name for body in bodies)
        self.camera = camera
        self.cameras = (camera, *(placed.camera for placed in rig))
        self._start_parameters: StartParameters = parameters.start
        self._optimiser = Optimiser(bodies, camera, parameters, rig)
        self._judge = LossJudge(len(bodies), parameters.loss)
        self._parameters = parameters
        has_depth = parameters.depth is not None and any(each.depth for each in self.cameras)
        self._calibration = Calibration(
            len(bodies),
            parameters.confidence,
            parameters.covariance,
            reachable=1.0 if has_depth else REGION_SHARE,
        )
        self._agreements = [0.0] * len(bodies)
        self._graph: GraphFollower | None = None
        if graph is not None:
            if asset is None:
                raise TrackingError("this method follows an assembly graph: name an asset")
            self._graph = GraphFollower(asset, self.names, self._optimiser, graph)
        self._seen_through = SeenThrough(bodies, camera)
        self._recovery: Recovery | None = None
        if parameters.regains:
            self._recovery = Recovery(
                bodies, camera, self._optimiser, self._judge, self._seen_through
            )
        self._before = self._optimiser.motion()
        self._moving = np.zeros(len(bodies), dtype=np.uint8)

    def start(
        self,
        frame: Frame,
        camera_from_body: Mapping[str, Pose],
        *others: Frame | None,
        are_rough: bool = True,
    ) -> None:
        """Begin to track parts whose poses are known roughly; others are followed as in `track`.

        Several poses around each given one are refined, and the likeliest wins. Colours are
        learned at a pose and the pose is refined with them in turns: that takes out what the
        first pose's error brought into them.

        Args:
            frame: of the first camera.
            camera_from_body: where the parts are, roughly.
            others: frames of the further cameras; see `track`.
            are_rough: False for poses that an optimiser has refined already: nothing around them
                is tried, which takes a tenth of the time.

        Raises:
            TrackingError: a part that this tracker does not have, a pose behind the camera, or
                more frames than cameras.
            FrameError: the frame does not fit the camera.
        """
        frames, _ = fitting_frames((frame, *others), self.cameras)
        which = np.zeros(len(self.names), dtype=np.int64)
        for name in camera_from_body:
            body = self._index(name)
            if not camera_from_body[name].translation[2] > 0:
                raise TrackingError(f"the first pose of {name} is not in front of the camera")
            which[body] = 1
            self._judge.reset(body)
        best = dict(camera_from_body)
        likelihood = dict.fromkeys(camera_from_body, -np.inf)
        for variation in start_variations(self._start_parameters) if are_rough else ():
            self._settle(
                frames, which, {name: variation(pose) for name, pose in camera_from_body.items()}
            )
            for name in camera_from_body:
                body = self.names.index(name)
                if self._optimiser.likelihoods[body] > likelihood[name]:
                    likelihood[name] = self._optimiser.likelihoods[body]
                    best[name] = self._optimiser.pose(body)
        self._settle(frames, which, best)

    def track(self, frame: Frame | None, *others: Frame | None) -> TrackingResult:
        """Follow all started parts into the next frame.

        Args:
            frame: of the first camera.
            others: of the further cameras, exposed at the same time. Of several cameras, one
                without a frame (None) or with one that does not fit it takes no part this time.

        Raises:
            FrameError: no frame fits its camera; nothing has changed then.
            TrackingError: there is no frame, or there are more frames than cameras.
        """
        begin = time.perf_counter()
        frames, left_out = fitting_frames((frame, *others), self.cameras)
        frame = frames[0]
        first = next(each for each in frames if each is not None)
        last = self._optimiser.motion()
        self._optimiser.predict(self._before, self._moving)
        self._before = last
        predicted = self._optimiser.poses.copy()
        self._optimiser.see(*frames)
        self._optimiser.refine()
        if self._parameters.refined_by_region:
            self._optimiser.refine_by_region()
        self._optimiser.weigh()
        # Of this refinement: whatever is tried out below leaves other Hessians behind.
        covariances = self._optimiser.covariances()
        estimates = self._estimates(predicted, frame)
        # A pose that contradicts what is seen is still `tracked` for some frames of patience, but
        # its colours would be those of the background.
        believed = [
            each.status is Status.TRACKED
            and each.confidence >= self._judge.parameters.lost_confidence
            for each in estimates
        ]
        self._optimiser.learn(np.array(believed, dtype=np.int64))
        self._moving[:] = [each.status is Status.TRACKED for each in estimates]
        for body, each in enumerate(estimates):
            known = each.status is Status.TRACKED and each.confidence > _IN_DOUBT
            self._optimiser.trust(body, well_known=known or each.status is Status.PREDICTED)
        assembly = None
        if self._graph is not None:
            assembly, jumped = self._graph.follow(estimates, self._absent(estimates, frame))
            self._halt(self.names.index(name) for name in jumped)
        if self._recovery is not None and frame is not None:
            self._halt(self._recovery.follow(frame, estimates))
        published = self._calibration.published(estimates, self._agreements, covariances)
        duration_ms = (time.perf_counter() - begin) * 1e3
        state = None if self._graph is None else self._graph.state
        return TrackingResult(
            first.name, first.captured_at_ns, published, duration_ms, state, assembly, left_out
        )

    @property
    def looks_for_parts(self) -> bool:
        """Whether it looks for parts that it lost, and can try poses out."""
        return self._recovery is not None

    def propose(self, camera_from_body: Mapping[str, Sequence[Pose]]) -> None:
        """Let poses be tried out in the next frame, beside those that are followed.

        A part goes to one of them if that explains the frame better; its module goes with it.

        Args:
            camera_from_body: by part, as many as there are; none for a part that has not been
                started.

        Raises:
            TrackingError: a part that this tracker does not have, or a method that looks for
                nothing.
        """
        if self._recovery is None:
            raise TrackingError("this method looks for nothing: it cannot try poses out")
        bodies = {self._index(name): poses for name, poses in camera_from_body.items()}
        started = {b: poses for b, poses in bodies.items() if self._optimiser.is_active(b)}
        self._recovery.propose(started)

    def put(self, camera_from_body: Mapping[str, Pose]) -> None:
        """Put started parts elsewhere, and their modules with them, whatever speaks for it.

        Raises:
            TrackingError: a part that this tracker does not have.
        """
        for name, pose in camera_from_body.items():
            body = self._index(name)
            self._optimiser.carry_back(body, pose)
            self._judge.reset(body)
            self._halt([body])

    def stop(self, name: str) -> None:
        """Let a part be searched for again, as before it was started.

        Raises:
            TrackingError: no such part.
        """
        body = self._index(name)
        self._optimiser.deactivate(body)
        self._judge.reset(body)
        if self._recovery is not None:
            self._recovery.forget(body)

    def set_state(self, state: str) -> None:
        """Say which assembly state holds, as an operator does.

        Raises:
            TrackingError: no such state, or this tracker follows no assembly graph.
        """
        if self._graph is None:
            raise TrackingError("this method follows no assembly graph: there is no state to set")
        self._halt(self.names.index(name) for name in self._graph.set_state(state))

    def _absent(self, estimates: Sequence[PartEstimate], frame: Frame | None) -> list[str]:
        """Linked parts that are not seen although their places are."""
        if frame is None:
            return []
        return [
            each.part
            for body, each in enumerate(estimates)
            if each.status is Status.INFERRED and each.camera_from_body is not None
            if self._seen_through.is_vacant(frame, body, each.camera_from_body)
        ]

    def _index(self, name: str) -> int:
        if name not in self.names:
            known = ", ".join(self.names)
            raise TrackingError(f"there is no part {name!r} to track; the parts are {known}")
        return self.names.index(name)

    def _halt(self, jumped: Iterable[int]) -> None:
        """A pose that jumped says nothing of a motion."""
        for body in jumped:
            self._moving[self._optimiser.structures.members(body)] = 0

    def _settle(
        self,
        frames: Sequence[Frame | None],
        which: npt.NDArray[np.int64],
        camera_from_body: Mapping[str, Pose],
    ) -> None:
        """Put bodies at poses, then refine them and learn their colours in turns."""
        for name, pose in camera_from_body.items():
            self._optimiser.place(self.names.index(name), pose)
        self._optimiser.see(*frames)
        self._optimiser.correspond()
        for margin_px in self._start_parameters.margins_px:
            self._optimiser.learn(which, afresh_beyond_px=margin_px)
            self._optimiser.refine()
        self._optimiser.weigh()
        self._optimiser.learn(which, afresh_beyond_px=0.0)

    def _estimates(
        self, predicted: npt.NDArray[np.float64], frame: Frame | None
    ) -> tuple[PartEstimate, ...]:
        """What can be said of all bodies after a frame; hidden ones go back to `predicted`."""
        optimiser = self._optimiser
        evidence = [self._evidence(body, frame) for body in range(len(self.names))]
        believed = [self._judge.is_believed(body, each) for body, each in enumerate(evidence)]
        estimates = []
        for body in range(len(self.names)):
            members = [int(member) for member in optimiser.structures.members(body)]
            carrier = None
            if len(members) > 1:
                others = (evidence[m] for m in members if m != body and believed[m])
                carrier = sum(others, NO_EVIDENCE)
                if not any(believed[m] for m in members):
                    # Nobody of the module is seen well: it stays where it was expected.
                    optimiser.move(body, Pose(predicted[body]))
            estimates.append(self._estimate(body, evidence[body], carrier, predicted[body]))
        return tuple(estimates)

    def _evidence(self, body: int, frame: Frame | None) -> Evidence:
        """What speaks for a body's pose; nothing does where the depth camera sees through it."""
        evidence = self._optimiser.evidence(body)
        if self._recovery is None or frame is None or not self._optimiser.is_active(body):
            return evidence
        pose = self._optimiser.pose(body)
        if self._seen_through.contradicts(frame, body, pose, evidence):
            return replace(evidence, supporting_lines=0, supporting_points=0)
        return evidence

    def _estimate(
        self,
        body: int,
        evidence: Evidence,
        carrier: Evidence | None,
        predicted: npt.NDArray[np.float64],
    ) -> PartEstimate:
        """What can be said of a body after a frame."""
        name, optimiser = self.names[body], self._optimiser
        if not optimiser.is_active(body):
            return PartEstimate(name, Status.SEARCHING, 0.0, None)
        status = self._judge.judge(
            body, evidence, solved=optimiser.is_solved(body), carrier=carrier
        )
        if status is Status.LOST:
            optimiser.drop_if_diverged(body)
            return PartEstimate(name, status, 0.0, None, visibility=evidence.visibility)
        if status is Status.PREDICTED and carrier is None:
            # Next to no evidence would only make it drift.
            optimiser.move(body, Pose(predicted))
        confidence = evidence.confidence
        self._agreements[body] = confidence
        if status is Status.INFERRED and carrier is not None:
            confidence = self._agreements[body] = carrier.confidence
        elif status is Status.TRACKED:
            self._agreements[body] = evidence.agreement(carrier)
        return PartEstimate(
            name,
            status,
            confidence,
            optimiser.pose(body),
            visibility=evidence.visibility,
            linked_to=self._graph.parent_of(name) if self._graph is not None else None,
        )
