"""The optimiser: holds the state of all bodies and runs the kernels on it.

Correspond, differentiate, solve, learn the colours: the methods are the steps of the tracker's
loop; each is a compiled call for all bodies at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body, alike, pack_models
from snapfit.tracking.color_histograms import N_COLORS, ColorHistograms
from snapfit.tracking.confidence import LINE_TOLERANCE_PX, POINT_TOLERANCE_M, Evidence
from snapfit.tracking.depth_modality import depth_settings, empty_points
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame, check_frame
from snapfit.tracking.kernel_cameras import kernel_cameras
from snapfit.tracking.kernels.evidence import weigh_bodies
from snapfit.tracking.kernels.motion import predict
from snapfit.tracking.kernels.refine import refine
from snapfit.tracking.kernels.types import CONSIDERED, OCCLUDED, VALID, Bodies, Images, Models
from snapfit.tracking.kinematics import KinematicStructures
from snapfit.tracking.nearby import NearbyRendering, occlusion_settings
from snapfit.tracking.parameters import DepthParameters, RegionParameters, TrackerParameters
from snapfit.tracking.region_modality import empty_lines, region_settings
from snapfit.tracking.threads import parallel_kernels, prepare_threading_layer

_PARTS_A_BODY = 4
"""Pieces that a body's lines and points are cut into, so that one body keeps two cores busy."""
_ENOUGH_POINTS, _NOISE_RATE = 40, 0.3


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
    """The poses of all bodies, and the steps that refine them against a frame.

    Attributes:
        support: (B, 2) lines and points that agree with the pose, after `weigh`.
        likelihoods: (B,) log likelihood of the pose, after `weigh`.
        structures: how the bodies are linked; all are free at first.
    """

    def __init__(
        self, bodies: Sequence[Body], camera: RgbdCamera, parameters: TrackerParameters
    ) -> None:
        prepare_threading_layer()
        region, depth = parameters.region, parameters.depth
        if region is None and camera.depth is None:
            raise TrackingError("the depth modality alone needs a depth camera; add the region's")
        self._camera = camera
        self._parameters = parameters
        n, iterations = len(bodies), parameters.optimiser.correspondence_iterations
        n_lines = region.lines_max if region else 0
        n_points = depth.points_max if depth and camera.depth else 0
        self._kept_alive = tuple(bodies)
        self._models = pack_models(bodies, n_lines, n_points)
        self._alike = alike(bodies)
        if not parameters.occlusion.region_checking:
            self._alike[:] = 0
        self._hiding = np.full(n, parameters.occlusion.measured_threshold_m, dtype=np.float32)
        self._bodies = _empty_bodies(n)
        self.structures = KinematicStructures(n)
        self._lines = empty_lines(n, n_lines)
        self._points = empty_points(n, n_points)
        self._region = region_settings(region or RegionParameters(), iterations)
        self._depth = depth_settings(depth or DepthParameters(), iterations)
        self._occlusion = occlusion_settings(
            parameters.occlusion, has_depth=camera.depth is not None
        )
        self._cameras = kernel_cameras(camera)
        self._nearby = NearbyRendering(bodies, camera.color, parameters.occlusion)
        self._histograms = ColorHistograms(n, parameters.histogram)
        self._tikhonov = np.array(
            [parameters.optimiser.tikhonov_rotation, parameters.optimiser.tikhonov_translation]
        )
        self._alone = KinematicStructures(n)
        self._counts = np.zeros((n, _PARTS_A_BODY, 2, 4), dtype=np.int64)
        self._images: Images | None = None
        depth_camera = camera.depth or camera.color
        self._no_depth = np.zeros((depth_camera.height, depth_camera.width), dtype=np.uint16)
        self.support = np.zeros((n, 2), dtype=np.int64)
        self.likelihoods = np.zeros(n)
        self._depth_errors = np.zeros(n)

    def place(self, body: int, pose: Pose) -> None:
        """Put a body at a pose `camera_from_body`, its colours unknown, and let it take part."""
        self._bodies.active[body] = 1
        self._bodies.poses[body] = pose.matrix
        self._bodies.tables[body] = 0.5
        self._bodies.depth_scales[body] = 1.0

    def pose(self, body: int) -> Pose:
        """`camera_from_body` of a body."""
        return Pose(self._bodies.poses[body])

    @property
    def poses(self) -> npt.NDArray[np.float64]:
        """(B, 4, 4) `camera_from_body` of all bodies; theirs, not a copy."""
        return self._bodies.poses

    @property
    def tables(self) -> npt.NDArray[np.float32]:
        """(B, 4096) posterior of each body's foreground, by colour."""
        return self._bodies.tables

    @property
    def nearby_id(self) -> npt.NDArray[np.uint8]:
        """(h, w) the small rendering: index of the body in front + 1."""
        return self._nearby.part_id

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

    def counts(self, body: int) -> npt.NDArray[np.int64]:
        """(2, 4) what became of a body's lines and points: considered, hidden, valid, -."""
        counts: npt.NDArray[np.int64] = self._counts[body].sum(axis=0)
        return counts

    def covariance(self, body: int) -> npt.NDArray[np.float64]:
        """(6, 6) inverse of the regularised Hessian: rotation (rad), translation (m)."""
        lower = np.tril(self._bodies.hessians[body])
        hessian = lower + np.tril(lower, -1).T
        hessian[range(3), range(3)] += self._tikhonov[0]
        hessian[range(3, 6), range(3, 6)] += self._tikhonov[1]
        covariance: npt.NDArray[np.float64] = np.linalg.inv(hessian)
        return covariance

    def see(self, frame: Frame) -> None:
        """Take a frame, and render where the bodies are expected to hide one another.

        Raises:
            FrameError: the frame does not fit the camera.
        """
        check_frame(frame, self._camera)
        if self._parameters.occlusion.modelled:
            self._nearby.render(self._bodies)
        depth = self._no_depth if frame.depth is None else frame.depth
        self._images = Images(
            color=np.ascontiguousarray(frame.color),
            depth=np.ascontiguousarray(depth),
            near_depth=self._nearby.depth,
            near_id=self._nearby.part_id,
            neighboured=self._nearby.neighboured,
            alike=self._alike,
            hiding=self._hiding,
        )

    def correspond(self) -> None:
        """Find correspondences at the coarsest scale; the poses stay."""
        self._run(iterations=1, updates=0)

    def refine(self) -> None:
        """Correspond, differentiate and solve, coarse to fine."""
        optimiser = self._parameters.optimiser
        self._run(optimiser.correspondence_iterations, optimiser.update_iterations)

    def refine_by_region(self) -> None:
        """Refine once more by the region modality alone (ICG+SRT3D, Li et al.)."""
        points = np.zeros_like(self._models.point_counts)
        optimiser = self._parameters.optimiser
        self._run(
            optimiser.correspondence_iterations,
            optimiser.update_iterations,
            self._models._replace(point_counts=points),
        )

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

    def attempt(self, body: int, pose: Pose) -> Attempt:
        """What the frame makes of a body that starts from a pose, free; nothing is changed."""
        bodies, structures = self._bodies, self.structures
        kept = bodies.active.copy(), bodies.poses[body].copy(), bodies.solved.copy()
        scores = self.support.copy(), self.likelihoods.copy(), self._counts[body].copy()
        errors, scale = self._depth_errors.copy(), bodies.depth_scales.copy()
        hiding = self._hiding[body]
        self.trust(body, well_known=False)
        bodies.active[:] = 0
        bodies.active[body] = 1
        bodies.poses[body] = pose.matrix
        self.structures = self._alone
        self.refine()
        self.weigh()
        found = Attempt(
            Pose(bodies.poses[body].copy()),
            float(self.likelihoods[body]),
            Evidence.of(self.counts(body), self.support[body]),
            self.is_solved(body),
        )
        self.structures = structures
        bodies.active[:], bodies.poses[body], bodies.solved[:] = kept
        self.support[:], self.likelihoods[:], self._counts[body] = scores
        self._depth_errors[:], bodies.depth_scales[:] = errors, scale
        self._hiding[body] = hiding
        return found

    def weigh(self) -> None:
        """Write `support` and `likelihoods` of the poses."""
        weigh_bodies(
            self._cameras,
            self._models,
            self._bodies,
            self._lines,
            self._points,
            LINE_TOLERANCE_PX,
            POINT_TOLERANCE_M,
            self.support,
            self.likelihoods,
            self._depth_errors,
        )
        self._learn_noise()

    def learn(self, which: npt.NDArray[np.int64], *, afresh_beyond_px: float | None = None) -> None:
        """Learn the colours at the poses of the bodies (B,) that can be believed.

        See `ColorHistograms.learn`.
        """
        if self._parameters.region is None:
            return
        with parallel_kernels:
            self._histograms.learn(
                self._seen,
                self._cameras,
                self._models,
                self._bodies,
                self._lines,
                which,
                afresh_beyond_px=afresh_beyond_px,
            )

    def _learn_noise(self) -> None:
        """How much each body's measured points can be trusted, from their last errors."""
        depth = self._parameters.depth
        if depth is None:
            return
        points = self._counts.sum(axis=1)[:, 1]
        visible = points[:, CONSIDERED] - points[:, OCCLUDED]
        trusted = points[:, VALID] > np.maximum(depth.trusted_share * visible, _ENOUGH_POINTS)
        noise = depth.noise * self._depth_errors / depth.standard_deviations_m[-1]
        scales = np.where(trusted, np.clip(noise, depth.least_scale, 1.0), 1.0)
        self._bodies.depth_scales[:] += _NOISE_RATE * (scales - self._bodies.depth_scales)

    @property
    def _seen(self) -> Images:
        if self._images is None:
            raise TrackingError("there is no frame yet: call `see` first")
        return self._images

    def _run(self, iterations: int, updates: int, models: Models | None = None) -> None:
        with parallel_kernels:
            refine(
                iterations,
                updates,
                _PARTS_A_BODY,
                self._seen,
                self._cameras,
                models or self._models,
                self._bodies,
                self.structures.arrays,
                self._region,
                self._depth,
                self._occlusion,
                self._tikhonov,
                self._lines,
                self._points,
                self._counts,
            )


def _empty_bodies(n: int) -> Bodies:
    return Bodies(
        active=np.zeros(n, dtype=np.uint8),
        poses=np.tile(np.eye(4), (n, 1, 1)),
        color_poses=np.zeros((n, 4, 4), dtype=np.float32),
        depth_poses=np.zeros((n, 4, 4), dtype=np.float32),
        views=np.zeros(n, dtype=np.int64),
        tables=np.full((n, N_COLORS), 0.5, dtype=np.float32),
        depth_scales=np.ones(n, dtype=np.float32),
        solved=np.ones(n, dtype=np.uint8),
        gradients=np.zeros((n, 6)),
        hessians=np.zeros((n, 6, 6)),
    )
