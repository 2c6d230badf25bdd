"""The tracker: the per-frame loop over all bodies (ICG, figure 2; GBOT, section 3.2)."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import PinholeCamera, RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body, pack_models
from snapfit.tracking.color_histograms import N_COLORS, ColorHistograms
from snapfit.tracking.confidence import (
    LINE_TOLERANCE_PX,
    POINT_TOLERANCE_M,
    Evidence,
    LossJudge,
)
from snapfit.tracking.depth_modality import depth_settings, empty_points
from snapfit.tracking.errors import FrameError, TrackingError
from snapfit.tracking.frame import Frame
from snapfit.tracking.kernels.learn import count_support
from snapfit.tracking.kernels.refine import refine
from snapfit.tracking.kernels.types import Bodies, Cameras, Images
from snapfit.tracking.nearby import NearbyRendering, occlusion_settings
from snapfit.tracking.parameters import DepthParameters, RegionParameters, TrackerParameters
from snapfit.tracking.region_modality import empty_lines, region_settings
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.threads import parallel_kernels, prepare_threading_layer

_PARTS_A_BODY = 4
"""Pieces that a body's lines and points are cut into, so that one body keeps two cores busy."""
_START_CYCLES = 3


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
        prepare_threading_layer()
        if not bodies:
            raise TrackingError("a tracker needs at least one body")
        self.names = tuple(body.name for body in bodies)
        self.camera = camera
        self._parameters = parameters or TrackerParameters()
        region, depth = self._parameters.region, self._parameters.depth
        if region is None and camera.depth is None:
            raise TrackingError("the depth modality alone needs a depth camera; add the region's")
        n_lines = region.lines_max if region else 0
        n_points = depth.points_max if depth and camera.depth else 0
        iterations = self._parameters.optimiser.correspondence_iterations
        self._models = pack_models(bodies, n_lines, n_points)
        self._bodies = _empty_bodies(len(bodies))
        self._lines = empty_lines(len(bodies), n_lines)
        self._points = empty_points(len(bodies), n_points)
        self._region = region_settings(region or RegionParameters(), iterations)
        self._depth = depth_settings(depth or DepthParameters(), iterations)
        self._occlusion = occlusion_settings(
            self._parameters.occlusion, has_depth=camera.depth is not None
        )
        self._cameras = _kernel_cameras(camera)
        self._nearby = NearbyRendering(bodies, camera.color, self._parameters.occlusion)
        self._histograms = ColorHistograms(len(bodies), self._parameters.histogram)
        self._judge = LossJudge(len(bodies))
        self._counts = np.zeros((len(bodies), _PARTS_A_BODY, 2, 4), dtype=np.int64)
        self._support = np.zeros((len(bodies), 2), dtype=np.int64)
        self._no_depth = np.zeros((1, 1), dtype=np.uint16)

    def start(self, frame: Frame, camera_from_body: Mapping[str, Pose]) -> None:
        """Begin to track parts whose poses are known roughly; others stay as they are.

        The first colours are learned at the given poses; refining and learning anew in turns
        takes out what the poses' error brought into them.

        Raises:
            TrackingError: a part that this tracker does not have.
            FrameError: the frame does not fit the camera.
        """
        which = np.zeros(len(self.names), dtype=np.int64)
        for name, pose in camera_from_body.items():
            if name not in self.names:
                known = ", ".join(self.names)
                raise TrackingError(f"there is no part {name!r} to start; the parts are {known}")
            body = self.names.index(name)
            which[body] = 1
            self._bodies.active[body] = 1
            self._bodies.poses[body] = pose.matrix
            self._bodies.tables[body] = 0.5
            self._judge.reset(body)
        images = self._see(frame)
        with parallel_kernels:
            self._refine(images, iterations=1, updates=0)
            self._learn(images, which, afresh=True)
            for _ in range(_START_CYCLES):
                self._refine(images)
                self._learn(images, which, afresh=True)

    def track(self, frame: Frame) -> TrackingResult:
        """Follow all started parts into the next frame.

        Raises:
            FrameError: the frame does not fit the camera; nothing has changed then.
        """
        begin = time.perf_counter()
        images = self._see(frame)
        with parallel_kernels:
            self._refine(images)
            count_support(
                self._cameras,
                self._models,
                self._bodies,
                self._lines,
                self._points,
                LINE_TOLERANCE_PX,
                POINT_TOLERANCE_M,
                self._support,
            )
            estimates = tuple(self._estimate(body) for body in range(len(self.names)))
            believed = [estimate.status is Status.TRACKED for estimate in estimates]
            self._learn(images, np.array(believed, dtype=np.int64))
        duration_ms = (time.perf_counter() - begin) * 1e3
        return TrackingResult(frame.name, frame.captured_at_ns, estimates, duration_ms)

    def _see(self, frame: Frame) -> Images:
        """Check a frame and render where the bodies are expected to hide one another."""
        _check_frame(frame, self.camera)
        if self._parameters.occlusion.modelled:
            self._nearby.render(self._bodies)
        return Images(
            color=np.ascontiguousarray(frame.color),
            depth=self._no_depth if frame.depth is None else np.ascontiguousarray(frame.depth),
            near_depth=self._nearby.depth,
            near_id=self._nearby.part_id,
            neighboured=self._nearby.neighboured,
        )

    def _refine(
        self, images: Images, iterations: int | None = None, updates: int | None = None
    ) -> None:
        """Correspond, differentiate and solve, coarse to fine, for all bodies."""
        optimiser = self._parameters.optimiser
        refine(
            optimiser.correspondence_iterations if iterations is None else iterations,
            optimiser.update_iterations if updates is None else updates,
            _PARTS_A_BODY,
            images,
            self._cameras,
            self._models,
            self._bodies,
            self._region,
            self._depth,
            self._occlusion,
            np.array([optimiser.tikhonov_rotation, optimiser.tikhonov_translation]),
            self._lines,
            self._points,
            self._counts,
        )

    def _learn(self, images: Images, which: npt.NDArray[np.int64], *, afresh: bool = False) -> None:
        """Learn the colours at the poses of the bodies that can be believed."""
        if self._parameters.region is not None:
            self._histograms.learn(
                images,
                self._cameras,
                self._models,
                self._bodies,
                self._lines,
                which,
                afresh=afresh,
            )

    def _estimate(self, body: int) -> PartEstimate:
        """What can be said of a body after a frame."""
        name = self.names[body]
        if not self._bodies.active[body]:
            return PartEstimate(name, Status.SEARCHING, 0.0, None)
        evidence = Evidence.of(self._counts[body].sum(axis=0), self._support[body])
        finite = bool(np.isfinite(self._bodies.poses[body]).all())
        status = self._judge.judge(
            body, evidence, solved=finite and bool(self._bodies.solved[body])
        )
        if status is Status.LOST:
            if not finite:
                self._bodies.active[body] = 0
            return PartEstimate(name, status, 0.0, None, visibility=evidence.visibility)
        return PartEstimate(
            name,
            status,
            evidence.confidence,
            Pose(self._bodies.poses[body]),
            self._covariance(body),
            evidence.visibility,
        )

    def _covariance(self, body: int) -> npt.NDArray[np.float64]:
        """(6, 6) inverse of the regularised Hessian: rotation (rad), translation (m)."""
        optimiser = self._parameters.optimiser
        hessian = self._bodies.hessians[body]
        hessian = np.tril(hessian) + np.tril(hessian, -1).T
        hessian[range(3), range(3)] += optimiser.tikhonov_rotation
        hessian[range(3, 6), range(3, 6)] += optimiser.tikhonov_translation
        covariance: npt.NDArray[np.float64] = np.linalg.inv(hessian)
        return covariance


def _empty_bodies(n: int) -> Bodies:
    return Bodies(
        active=np.zeros(n, dtype=np.uint8),
        poses=np.tile(np.eye(4), (n, 1, 1)),
        color_poses=np.zeros((n, 4, 4), dtype=np.float32),
        depth_poses=np.zeros((n, 4, 4), dtype=np.float32),
        views=np.zeros(n, dtype=np.int64),
        tables=np.full((n, N_COLORS), 0.5, dtype=np.float32),
        solved=np.ones(n, dtype=np.uint8),
        hessians=np.zeros((n, 6, 6)),
    )


def _kernel_cameras(camera: RgbdCamera) -> Cameras:
    return Cameras(
        color=_kernel_intrinsics(camera.color),
        depth=_kernel_intrinsics(camera.depth or camera.color),
        depth_unit=np.float32(camera.depth_scale_m),
        color_from_depth=np.array(camera.color_from_depth.matrix, dtype=np.float32),
        depth_from_color=np.array(camera.color_from_depth.inverse().matrix),
    )


def _kernel_intrinsics(camera: PinholeCamera) -> npt.NDArray[np.float32]:
    values = (camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height)
    return np.array(values, dtype=np.float32)


def _check_frame(frame: Frame, camera: RgbdCamera) -> None:
    size = (camera.color.height, camera.color.width, 3)
    if frame.color.shape != size or frame.color.dtype != np.uint8:
        found = f"{frame.color.shape} {frame.color.dtype}"
        raise FrameError(frame.name, f"the colour image is {found}, the camera's {size} uint8")
    if camera.depth is None or frame.depth is None:
        return
    depth_size = (camera.depth.height, camera.depth.width)
    if frame.depth.shape != depth_size or frame.depth.dtype != np.uint16:
        found = f"{frame.depth.shape} {frame.depth.dtype}"
        raise FrameError(
            frame.name, f"the depth image is {found}, the camera's {depth_size} uint16"
        )
