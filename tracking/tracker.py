"""The tracker: the per-frame loop over all bodies (ICG; GBOT, section 3.2)."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.assessment import Assessment
from snapfit.tracking.body import Body
from snapfit.tracking.calibration import Calibration
from snapfit.tracking.camera_view import RigCamera
from snapfit.tracking.confidence import REGION_SHARE, LossJudge
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.following import GraphFollower, GraphParameters
from snapfit.tracking.frame import Frame, fitting_frames
from snapfit.tracking.optimiser import Optimiser
from snapfit.tracking.parameters import TrackerParameters
from snapfit.tracking.recovery.recovery import Recovery
from snapfit.tracking.recovery.seen_through import SeenThrough
from snapfit.tracking.result import Status, TrackingResult
from snapfit.tracking.start import Starter

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
        self._optimiser = Optimiser(bodies, camera, parameters, rig)
        self._starter = Starter(self._optimiser, parameters.start)
        self._judge = LossJudge(len(bodies), parameters.loss)
        self._parameters = parameters
        has_depth = parameters.depth is not None and any(each.depth for each in self.cameras)
        self._calibration = Calibration(
            len(bodies),
            parameters.confidence,
            parameters.covariance,
            reachable=1.0 if has_depth else REGION_SHARE,
        )
        self._graph: GraphFollower | None = None
        if graph is not None:
            if asset is None:
                raise TrackingError("this method follows an assembly graph: name an asset")
            self._graph = GraphFollower(asset, self.names, self._optimiser, graph)
        seen_through = SeenThrough(bodies, camera)
        self._recovery: Recovery | None = None
        if parameters.regains:
            self._recovery = Recovery(bodies, camera, self._optimiser, self._judge, seen_through)
        self._assessment = Assessment(
            self.names,
            self._optimiser,
            self._judge,
            seen_through,
            refutes=parameters.regains,
            graph=self._graph,
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
        for name, pose in camera_from_body.items():
            body = self._index(name)
            if not pose.translation[2] > 0:
                raise TrackingError(f"the first pose of {name} is not in front of the camera")
            self._judge.reset(body)
        poses = {self.names.index(name): pose for name, pose in camera_from_body.items()}
        self._starter.start(frames, poses, are_rough=are_rough)

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
        estimates = self._assessment.estimates(predicted, frame)
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
            assembly, jumped = self._graph.follow(
                estimates, self._assessment.absent(estimates, frame)
            )
            self._halt(self.names.index(name) for name in jumped)
        if self._recovery is not None and frame is not None:
            self._halt(self._recovery.follow(frame, estimates))
        published = self._calibration.published(estimates, self._assessment.agreements, covariances)
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

    def _index(self, name: str) -> int:
        if name not in self.names:
            known = ", ".join(self.names)
            raise TrackingError(f"there is no part {name!r} to track; the parts are {known}")
        return self.names.index(name)

    def _halt(self, jumped: Iterable[int]) -> None:
        """A pose that jumped says nothing of a motion."""
        for body in jumped:
            self._moving[self._optimiser.structures.members(body)] = 0
