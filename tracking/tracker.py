"""The tracker: the per-frame loop over all bodies (ICG; GBOT, section 3.2)."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body
from snapfit.tracking.confidence import Evidence, LossJudge
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Optimiser
from snapfit.tracking.parameters import StartParameters, TrackerParameters
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.start import start_variations


class Tracker:
    """Tracks several bodies through the frames of one RGB-D camera.

    Attributes:
        names: the bodies' names, in order.
        camera: where the frames come from.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        parameters: TrackerParameters | None = None,
    ) -> None:
        """Make a tracker; nothing is tracked before `start`.

        Raises:
            TrackingError: no body, or depth alone without a depth camera.
        """
        if not bodies:
            raise TrackingError("a tracker needs at least one body")
        parameters = parameters or TrackerParameters()
        self.names = tuple(body.name for body in bodies)
        self.camera = camera
        self._start_parameters: StartParameters = parameters.start
        self._optimiser = Optimiser(bodies, camera, parameters)
        self._judge = LossJudge(len(bodies))

    def start(self, frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        """Begin to track parts whose poses are known roughly; others are followed as in `track`.

        Several poses around each given one are refined, and the likeliest wins. Colours are
        learned at a pose and the pose is refined with them in turns: that takes out what the
        first pose's error brought into them.

        Raises:
            TrackingError: a part that this tracker does not have, or a pose behind the camera.
            FrameError: the frame does not fit the camera.
        """
        which = np.zeros(len(self.names), dtype=np.int64)
        for name in camera_from_body:
            if name not in self.names:
                known = ", ".join(self.names)
                raise TrackingError(f"there is no part {name!r} to start; the parts are {known}")
            if not camera_from_body[name].translation[2] > 0:
                raise TrackingError(f"the first pose of {name} is not in front of the camera")
            which[self.names.index(name)] = 1
            self._judge.reset(self.names.index(name))
        best = dict(camera_from_body)
        likelihood = dict.fromkeys(camera_from_body, -np.inf)
        for variation in start_variations(self._start_parameters):
            self._settle(
                frame, which, {name: variation(pose) for name, pose in camera_from_body.items()}
            )
            for name in camera_from_body:
                body = self.names.index(name)
                if self._optimiser.likelihoods[body] > likelihood[name]:
                    likelihood[name] = self._optimiser.likelihoods[body]
                    best[name] = self._optimiser.pose(body)
        self._settle(frame, which, best)

    def track(self, frame: Frame) -> TrackingResult:
        """Follow all started parts into the next frame.

        Raises:
            FrameError: the frame does not fit the camera; nothing has changed then.
        """
        begin = time.perf_counter()
        self._optimiser.see(frame)
        self._optimiser.refine()
        self._optimiser.weigh()
        estimates = tuple(self._estimate(body) for body in range(len(self.names)))
        # A pose that contradicts what is seen is still `tracked` for some frames of patience, but
        # its colours would be those of the background.
        believed = [
            estimate.status is Status.TRACKED
            and estimate.confidence >= self._judge.parameters.lost_confidence
            for estimate in estimates
        ]
        self._optimiser.learn(np.array(believed, dtype=np.int64))
        duration_ms = (time.perf_counter() - begin) * 1e3
        return TrackingResult(frame.name, frame.captured_at_ns, estimates, duration_ms)

    def _settle(
        self, frame: Frame, which: npt.NDArray[np.int64], camera_from_body: Mapping[str, Pose]
    ) -> None:
        """Put bodies at poses, then refine them and learn their colours in turns."""
        for name, pose in camera_from_body.items():
            self._optimiser.place(self.names.index(name), pose)
        self._optimiser.see(frame)
        self._optimiser.correspond()
        for margin_px in self._start_parameters.margins_px:
            self._optimiser.learn(which, afresh_beyond_px=margin_px)
            self._optimiser.refine()
        self._optimiser.weigh()
        self._optimiser.learn(which, afresh_beyond_px=0.0)

    def _estimate(self, body: int) -> PartEstimate:
        """What can be said of a body after a frame."""
        name = self.names[body]
        if not self._optimiser.is_active(body):
            return PartEstimate(name, Status.SEARCHING, 0.0, None)
        evidence = Evidence.of(self._optimiser.counts(body), self._optimiser.support[body])
        status = self._judge.judge(body, evidence, solved=self._optimiser.is_solved(body))
        if status is Status.LOST:
            self._optimiser.drop_if_diverged(body)
            return PartEstimate(name, status, 0.0, None, visibility=evidence.visibility)
        return PartEstimate(
            name,
            status,
            evidence.confidence,
            self._optimiser.pose(body),
            self._optimiser.covariance(body),
            evidence.visibility,
        )
