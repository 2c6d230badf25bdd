"""The optimiser: holds the state of all bodies and runs the kernels on it.

Correspond, differentiate, solve, learn the colours: the methods are the steps of the tracker's
loop; each is a compiled call for all bodies at once.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body, pack_models
from snapfit.tracking.color_histograms import N_COLORS, ColorHistograms
from snapfit.tracking.confidence import LINE_TOLERANCE_PX, POINT_TOLERANCE_M
from snapfit.tracking.depth_modality import depth_settings, empty_points
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame, check_frame
from snapfit.tracking.kernel_cameras import kernel_cameras
from snapfit.tracking.kernels.evidence import weigh_bodies
from snapfit.tracking.kernels.refine import refine
from snapfit.tracking.kernels.types import CONSIDERED, OCCLUDED, VALID, Bodies, Images
from snapfit.tracking.kinematics import KinematicStructures
from snapfit.tracking.nearby import NearbyRendering, occlusion_settings
from snapfit.tracking.parameters import DepthParameters, RegionParameters, TrackerParameters
from snapfit.tracking.region_modality import empty_lines, region_settings
from snapfit.tracking.threads import parallel_kernels, prepare_threading_layer

_PARTS_A_BODY = 4
"""Pieces that a body's lines and points are cut into, so that one body keeps two cores busy."""
_ENOUGH_POINTS, _NOISE_RATE = 40, 0.3


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
        )

    def correspond(self) -> None:
        """Find correspondences at the coarsest scale; the poses stay."""
        self._run(iterations=1, updates=0)

    def refine(self) -> None:
        """Correspond, differentiate and solve, coarse to fine."""
        optimiser = self._parameters.optimiser
        self._run(optimiser.correspondence_iterations, optimiser.update_iterations)

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

    def _run(self, iterations: int, updates: int) -> None:
        with parallel_kernels:
            refine(
                iterations,
                updates,
                _PARTS_A_BODY,
                self._seen,
                self._cameras,
                self._models,
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
