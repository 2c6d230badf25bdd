"""What belongs to one camera: its picture, its correspondences, and the colours as it sees them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.tracking.body import Body, pack_models
from snapfit.tracking.color_histograms import N_COLORS, ColorHistograms
from snapfit.tracking.confidence import LINE_TOLERANCE_PX, POINT_TOLERANCE_M, Evidence
from snapfit.tracking.depth_modality import depth_settings, empty_points
from snapfit.tracking.errors import TrackingError
from snapfit.tracking.frame import Frame, check_frame
from snapfit.tracking.kernel_cameras import kernel_cameras
from snapfit.tracking.kernels.evidence import weigh_bodies
from snapfit.tracking.kernels.refine import correspond_all, differentiate_all, refine
from snapfit.tracking.kernels.rig import follow_first
from snapfit.tracking.kernels.types import (
    CONSIDERED,
    F64,
    OCCLUDED,
    U8,
    VALID,
    Bodies,
    Images,
    Structures,
)
from snapfit.tracking.nearby import NearbyRendering, occlusion_settings
from snapfit.tracking.parameters import DepthParameters, RegionParameters, TrackerParameters
from snapfit.tracking.region_modality import empty_lines, region_settings

_PARTS_A_BODY = 4
"""Pieces that a body's lines and points are cut into, so that one body keeps two cores busy."""
_ENOUGH_POINTS, _NOISE_RATE = 40, 0.3


@dataclass(frozen=True)
class RigCamera:
    """A further camera on the bench.

    Attributes:
        camera: its intrinsics.
        camera_from_first: where the first camera's colour camera is, in the frame of this one's.
    """

    camera: RgbdCamera
    camera_from_first: Pose = field(default_factory=Pose.identity)


class Scores(NamedTuple):
    """A camera's opinion of the poses, to be put back after an attempt; see `CameraView`."""

    support: npt.NDArray[np.int64]
    likelihoods: npt.NDArray[np.float64]
    counts: npt.NDArray[np.int64]
    depth_errors: npt.NDArray[np.float64]
    depth_scales: npt.NDArray[np.float32]


class CameraView:
    """All bodies as one camera sees them, and both modalities bound to it.

    Args:
        bodies: what is tracked.
        placed: the camera, and where it stands.
        parameters: of the modalities.
        first: the state of the first camera, with which this one shares what is not its own;
            None for the first itself.

    Attributes:
        camera: where the frames come from.
        bodies: poses are those in this camera's frame.
        nearby: where bodies are expected to hide one another.
        support: (B, 2) lines and points that agree with the pose, after `weigh`.
        likelihoods: (B,) log likelihood of the pose, after `weigh`.

    Raises:
        TrackingError: the depth modality alone, without a depth camera.
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        placed: RigCamera,
        parameters: TrackerParameters,
        first: Bodies | None = None,
    ) -> None:
        camera, region, depth = placed.camera, parameters.region, parameters.depth
        if region is None and camera.depth is None:
            raise TrackingError("the depth modality alone needs a depth camera; add the region's")
        n, iterations = len(bodies), parameters.optimiser.correspondence_iterations
        n_lines = region.lines_max if region else 0
        n_points = depth.points_max if depth and camera.depth else 0
        self.camera = camera
        self._parameters = parameters
        self._camera_from_first = np.array(placed.camera_from_first.matrix)
        self.bodies = _empty_bodies(n)
        if first is not None:
            self.bodies = self.bodies._replace(active=first.active, solved=first.solved)
        self._models = pack_models(bodies, n_lines, n_points)
        no_points = np.zeros_like(self._models.point_counts)
        self._lines_alone = self._models._replace(point_counts=no_points)
        self._lines = empty_lines(n, n_lines)
        self._points = empty_points(n, n_points)
        self._region = region_settings(region or RegionParameters(), iterations)
        self._depth = depth_settings(depth or DepthParameters(), iterations)
        self._occlusion = occlusion_settings(
            parameters.occlusion, has_depth=camera.depth is not None
        )
        self._cameras = kernel_cameras(camera)
        self.nearby = NearbyRendering(bodies, camera.color, parameters.occlusion)
        self._histograms = ColorHistograms(n, parameters.histogram)
        self._counts = np.zeros((n, _PARTS_A_BODY, 2, 4), dtype=np.int64)
        self._images: Images | None = None
        depth_camera = camera.depth or camera.color
        self._no_depth = np.zeros((depth_camera.height, depth_camera.width), dtype=np.uint16)
        self.support = np.zeros((n, 2), dtype=np.int64)
        self.likelihoods = np.zeros(n)
        self._depth_errors = np.zeros(n)

    def place(self, body: int) -> None:
        """A body begins: its colours are unknown."""
        self.bodies.tables[body] = 0.5
        self.bodies.depth_scales[body] = 1.0

    def follow(self, first: Bodies) -> None:
        """Take over the poses of the first camera's bodies."""
        follow_first(self._camera_from_first, first, self.bodies)

    def see(self, frame: Frame, alike: U8, hiding: npt.NDArray[np.float32]) -> None:
        """Take a frame, and render where the bodies are expected to hide one another.

        Args:
            frame: of this camera.
            alike, hiding: see `Images`.

        Raises:
            FrameError: the frame does not fit the camera.
        """
        check_frame(frame, self.camera)
        if self._parameters.occlusion.modelled:
            self.nearby.render(self.bodies)
        depth = self._no_depth if frame.depth is None else frame.depth
        self._images = Images(
            color=np.ascontiguousarray(frame.color),
            depth=np.ascontiguousarray(depth),
            near_depth=self.nearby.depth,
            near_id=self.nearby.part_id,
            neighboured=self.nearby.neighboured,
            alike=alike,
            hiding=hiding,
        )

    def refine(
        self,
        iterations: int,
        updates: int,
        structures: Structures,
        tikhonov: F64,
        *,
        by_region: bool = False,
    ) -> None:
        """Correspond, differentiate and solve, coarse to fine, by this camera alone."""
        refine(
            iterations,
            updates,
            _PARTS_A_BODY,
            self._seen,
            self._cameras,
            self._lines_alone if by_region else self._models,
            self.bodies,
            structures,
            self._region,
            self._depth,
            self._occlusion,
            tikhonov,
            self._lines,
            self._points,
            self._counts,
        )

    def correspond(self, iteration: int, *, by_region: bool = False) -> None:
        """Find the correspondences of one iteration."""
        correspond_all(
            iteration,
            _PARTS_A_BODY,
            self._seen,
            self._cameras,
            self._lines_alone if by_region else self._models,
            self.bodies,
            self._region,
            self._depth,
            self._occlusion,
            self._lines,
            self._points,
            self._counts,
        )

    def differentiate(self, iteration: int, update: int, *, by_region: bool = False) -> None:
        """Write the gradients and Hessians of this camera's energy."""
        differentiate_all(
            iteration,
            update,
            self._cameras,
            self._lines_alone if by_region else self._models,
            self.bodies,
            self._region,
            self._lines,
            self._points,
        )

    def weigh(self) -> None:
        """Write `support` and `likelihoods` of the poses."""
        weigh_bodies(
            self._cameras,
            self._models,
            self.bodies,
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
        """Learn the colours at the poses of the bodies (B,) that can be believed."""
        self._histograms.learn(
            self._seen,
            self._cameras,
            self._models,
            self.bodies,
            self._lines,
            which,
            afresh_beyond_px=afresh_beyond_px,
        )

    def evidence(self, body: int) -> Evidence:
        """What of the frame agrees with a body's pose, after `weigh`."""
        return Evidence.of(self._counts[body].sum(axis=0), self.support[body])

    def sees(self, visibility: float) -> npt.NDArray[np.int64]:
        """(B,) 1 where at least this share of a body's lines and points is not hidden."""
        counts = self._counts.sum(axis=(1, 2))
        considered, visible = counts[:, CONSIDERED], counts[:, CONSIDERED] - counts[:, OCCLUDED]
        enough: npt.NDArray[np.bool_] = (considered > 0) & (visible >= visibility * considered)
        return enough.astype(np.int64)

    def scores(self, body: int) -> Scores:
        """A copy of all that weighing the attempt of a body changes."""
        return Scores(
            self.support.copy(),
            self.likelihoods.copy(),
            self._counts[body].copy(),
            self._depth_errors.copy(),
            self.bodies.depth_scales.copy(),
        )

    def put_back(self, body: int, scores: Scores) -> None:
        """Undo what an attempt has changed."""
        self.support[:], self.likelihoods[:], self._counts[body] = scores[:3]
        self._depth_errors[:], self.bodies.depth_scales[:] = scores[3:]

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
        self.bodies.depth_scales[:] += _NOISE_RATE * (scales - self.bodies.depth_scales)

    @property
    def _seen(self) -> Images:
        if self._images is None:
            raise TrackingError("there is no frame yet: call `see` first")
        return self._images


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
