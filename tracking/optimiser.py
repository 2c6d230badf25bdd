"""The optimiser: holds the state of all bodies and runs the kernels on it.

Correspond, differentiate, solve, learn the colours: the methods are the steps of the tracker's
loop; each is a compiled call for all bodies at once. What belongs to one camera lies in its
`CameraView`; the poses are those in the first camera's frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body, alike
from snapfit.tracking.camera_view import CameraView, RigCamera
from snapfit.tracking.confidence import Evidence, seen_together
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame, check_frame
from snapfit.tracking.kernels.motion import predict
from snapfit.tracking.kernels.refine import step_all
from snapfit.tracking.kernels.rig import add_energies, clear_energies
from snapfit.tracking.kinematics import KinematicStructures
from snapfit.tracking.parameters import TrackerParameters
from snapfit.tracking.pose_covariance import PoseCovariances
from snapfit.tracking.threads import parallel_kernels, prepare_threading_layer

_LEARNING_VISIBILITY = 0.5
"""One of several cameras learns a body's colours only where it sees so much of the body."""


class Motion(NamedTuple):
    """Where all was: poses (B, 4, 4) and joints' coordinates (B, 2)."""

    poses: npt.NDArray[np.float64]
    q: npt.NDArray[np.float64]


class Attempt(NamedTuple):
    """What came of a pose that was tried out.

    Attributes:
        camera_from_body: refined.
        likelihood: its logarithm.
        evidence: what of the frame agrees.
        solved: whether the refinement could be solved.
    """

    camera_from_body: Pose
    likelihood: float
    evidence: Evidence
    solved: bool


class Optimiser:
    """The poses of all bodies, and the steps that refine them against a frame of each camera.

    Args:
        bodies: what is tracked.
        camera: whose frame the poses are in.
        parameters: of the modalities and the optimiser.
        rig: further cameras on the same bench.

    Attributes:
        support: (B, 2) lines and points that agree with the pose, after `weigh`; of all cameras.
        likelihoods: (B,) log likelihood of the pose, after `weigh`; of all cameras.
        structures: how the bodies are linked; all are free at first.

    Raises:
        TrackingError: the depth modality alone, without a depth camera.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        camera: RgbdCamera,
        parameters: TrackerParameters,
        rig: Sequence[RigCamera] = (),
    ) -> None:
        prepare_threading_layer()
        self._parameters = parameters
        n = len(bodies)
        self._kept_alive = tuple(bodies)
        self._alike = alike([body.color_rgb for body in bodies])
        if not parameters.occlusion.region_checking:
            self._alike[:] = 0
        self._hiding = np.full(n, parameters.occlusion.measured_threshold_m, dtype=np.float32)
        self._first = CameraView(bodies, RigCamera(camera), parameters)
        self._bodies = self._first.bodies
        others = [CameraView(bodies, placed, parameters, self._bodies) for placed in rig]
        self._views = (self._first, *others)
        self._seeing: list[CameraView] = []
        self.structures = KinematicStructures(n)
        self._tikhonov = np.array(
            [parameters.optimiser.tikhonov_rotation, parameters.optimiser.tikhonov_translation]
        )
        self._alone = KinematicStructures(n)
        self._covariances = PoseCovariances(bodies, parameters.covariance)
        self.support = self._first.support if not rig else np.zeros((n, 2), dtype=np.int64)
        self.likelihoods = self._first.likelihoods if not rig else np.zeros(n)

    def place(self, body: int, pose: Pose) -> None:
        """Put a body at a pose `camera_from_body`, its colours unknown, and let it take part."""
        self._bodies.active[body] = 1
        self._bodies.poses[body] = pose.matrix
        for view in self._views:
            view.place(body)

    def pose(self, body: int) -> Pose:
        """`camera_from_body` of a body."""
        return Pose(self._bodies.poses[body])

    @property
    def poses(self) -> npt.NDArray[np.float64]:
        """(B, 4, 4) `camera_from_body` of all bodies; theirs, not a copy."""
        return self._bodies.poses

    @property
    def tables(self) -> npt.NDArray[np.float32]:
        """(B, 4096) posterior of each body's foreground, by colour; the first camera's."""
        return self._bodies.tables

    @property
    def nearby_id(self) -> npt.NDArray[np.uint8]:
        """(h, w) the first camera's small rendering: index of the body in front + 1."""
        return self._first.nearby.part_id

    def move(self, body: int, pose: Pose) -> None:
        """Put a body, and all that it carries, at another pose; what was learned stays."""
        self._bodies.active[body] = 1
        self._bodies.poses[body] = pose.matrix
        self.structures.place(body, self._bodies.poses)

    def carry_back(self, body: int, pose: Pose) -> None:
        """Put a whole structure where one of its bodies stands; the joints stay as they are."""
        root = self.structures.root(body)
        chain = Pose.identity()
        while (parent := self.structures.parent(body)) is not None:
            chain = self.structures.parent_from_child(body) @ chain
            body = parent
        self.move(root, pose @ chain.inverse())

    def trust(self, body: int, *, well_known: bool) -> None:
        """Whether a body's pose is known so well that something close before it must hide it."""
        occlusion = self._parameters.occlusion
        known, rough = occlusion.held_threshold_m, occlusion.measured_threshold_m
        self._hiding[body] = known if well_known else rough

    def motion(self) -> Motion:
        """Where all is now, for `predict`; a copy."""
        return Motion(self._bodies.poses.copy(), self.structures.arrays.q.copy())

    def activate(self, body: int) -> None:
        """Let a body take part from where it stands."""
        self._bodies.active[body] = 1

    def deactivate(self, body: int) -> None:
        """Let a body take no part any more."""
        self._bodies.active[body] = 0

    def is_active(self, body: int) -> bool:
        """Whether a body takes part."""
        return bool(self._bodies.active[body])

    def is_solved(self, body: int) -> bool:
        """Whether the last refinement could be solved and left a finite pose."""
        finite = bool(np.isfinite(self._bodies.poses[body]).all())
        return finite and bool(self._bodies.solved[body])

    def drop_if_diverged(self, body: int) -> None:
        """Let a body whose pose is not finite take no part any more."""
        if not np.isfinite(self._bodies.poses[body]).all():
            self._bodies.active[body] = 0

    def evidence(self, body: int) -> Evidence:
        """What of the frames agrees with a body's pose, after `weigh`."""
        return seen_together([view.evidence(body) for view in self._seeing])

    def inverse_hessians(self) -> npt.NDArray[np.float64]:
        """(B, 6, 6) inverses of the bodies' own regularised Hessians: rotation (rad), way (m).

        They compare poses of one frame; how wrong a pose can be, `covariances` say.
        """
        lower = np.tril(self._bodies.hessians)
        hessians = lower + np.tril(lower, -1).swapaxes(1, 2)
        hessians[:, range(6), range(6)] += np.repeat(self._tikhonov, 3)
        return np.linalg.inv(hessians).astype(np.float64, copy=False)

    def covariances(self) -> npt.NDArray[np.float64]:
        """(B, 6, 6) of all bodies' right perturbations, with their links and systematic errors.

        Of the last refinement; rotation (rad), then translation (m).
        """
        return self._covariances.of(self._bodies, self.structures.arrays)

    def see(self, *frames: Frame | None) -> None:
        """Take a frame of each camera, in their order; one that has none takes no part.

        Raises:
            FrameError: a frame does not fit its camera; nothing has changed then.
            TrackingError: there is no frame at all.
        """
        seen = [
            (view, frame)
            for view, frame in zip(self._views, frames, strict=False)
            if frame is not None
        ]
        if not seen:
            raise TrackingError("no camera has a frame: give at least one")
        for view, frame in seen:
            check_frame(frame, view.camera)
        self._spread()
        for view, frame in seen:
            view.see(frame, self._alike, self._hiding)
        self._seeing = [view for view, _ in seen]

    def correspond(self) -> None:
        """Find correspondences at the coarsest scale; the poses stay."""
        self._run(iterations=1, updates=0)

    def refine(self) -> None:
        """Correspond, differentiate and solve, coarse to fine."""
        optimiser = self._parameters.optimiser
        self._run(optimiser.correspondence_iterations, optimiser.update_iterations)

    def refine_by_region(self) -> None:
        """Refine once more by the region modality alone (ICG+SRT3D, Li et al.)."""
        optimiser = self._parameters.optimiser
        self._run(optimiser.correspondence_iterations, optimiser.update_iterations, by_region=True)

    def predict(self, before: Motion, moving: npt.NDArray[np.uint8]) -> None:
        """Move on what moved, as far as the motion prior goes; (B,) `moving` where it may."""
        motion = self._parameters.motion
        predict(
            self._bodies,
            self.structures.arrays,
            before.poses,
            before.q,
            moving,
            motion.damping,
            motion.least_turn_rad,
            motion.least_way_m,
        )

    def attempt(self, body: int, pose: Pose, *, in_front: bool = False) -> Attempt:
        """What the frame makes of a body that starts from a pose, free; nothing is changed.

        Args:
            body: its index.
            pose: `camera_from_body` to start from.
            in_front: it hides others there: what is rendered to tell which body is in front shows
                it where it is tried, not where it was expected. Needed far from there, where it
                is close to others: a sleeve on a bar would count as hidden by the bar.
        """
        bodies, structures = self._bodies, self.structures
        kept = bodies.active.copy(), bodies.poses[body].copy(), bodies.solved.copy()
        scores = [view.scores(body) for view in self._seeing]
        hiding = self._hiding[body]
        self.trust(body, well_known=False)
        bodies.poses[body] = pose.matrix
        bodies.active[body] = 1
        self._spread()
        drawn_anew = in_front and self._parameters.occlusion.modelled
        renderings = [v.nearby.shown(v.bodies) for v in self._seeing if drawn_anew]
        bodies.active[:] = 0
        bodies.active[body] = 1
        self.structures = self._alone
        self.refine()
        self.weigh()
        found = Attempt(
            Pose(bodies.poses[body].copy()),
            float(self.likelihoods[body]),
            self.evidence(body),
            self.is_solved(body),
        )
        self.structures = structures
        bodies.active[:], bodies.poses[body], bodies.solved[:] = kept
        for view, kept_scores in zip(self._seeing, scores, strict=True):
            view.put_back(body, kept_scores)
        for view, rendering in zip(self._seeing, renderings, strict=False):
            view.nearby.put_back(rendering)
        self._add_up()
        self._hiding[body] = hiding
        return found

    def weigh(self) -> None:
        """Write `support` and `likelihoods` of the poses."""
        self._spread()
        for view in self._seeing:
            view.weigh()
        self._add_up()

    def learn(self, which: npt.NDArray[np.int64], *, afresh_beyond_px: float | None = None) -> None:
        """Learn the colours at the poses of the bodies (B,) that can be believed.

        Of several cameras, only those learn that see the body. See `ColorHistograms.learn`.
        """
        if self._parameters.region is None:
            return
        self._spread()
        with parallel_kernels:
            for view in self._seeing:
                learning = which
                if len(self._views) > 1:
                    learning = which * view.sees(_LEARNING_VISIBILITY)
                view.learn(learning, afresh_beyond_px=afresh_beyond_px)

    def _run(self, iterations: int, updates: int, *, by_region: bool = False) -> None:
        if not self._seeing:
            raise TrackingError("there is no frame yet: call `see` first")
        structures = self.structures.arrays
        with parallel_kernels:
            if len(self._views) == 1:
                self._first.refine(
                    iterations, updates, structures, self._tikhonov, by_region=by_region
                )
                return
            self._bodies.solved[:] = 1
            for iteration in range(iterations):
                self._spread()
                for view in self._seeing:
                    view.correspond(iteration, by_region=by_region)
                for update in range(updates):
                    self._differentiate(iteration, update, by_region=by_region)
                    step_all(structures, self._bodies, self._tikhonov)

    def _differentiate(self, iteration: int, update: int, *, by_region: bool) -> None:
        """The energies of all cameras, added up in the first one's bodies."""
        self._spread()
        clear_energies(self._bodies)
        for view in self._seeing:
            view.differentiate(iteration, update, by_region=by_region)
            if view is not self._first:
                add_energies(view.bodies, self._bodies)

    def _spread(self) -> None:
        """Take the poses to the other cameras."""
        for view in self._views[1:]:
            view.follow(self._bodies)

    def _add_up(self) -> None:
        """What all cameras say together; the arrays of a single one are its own."""
        if len(self._views) > 1:
            self.support[:] = sum(view.support for view in self._seeing)
            self.likelihoods[:] = sum(view.likelihoods for view in self._seeing)
