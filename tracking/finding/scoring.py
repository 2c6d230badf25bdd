"""Refines proposed poses with the tracker's optimiser, and says how sure they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from snapfit.models.camera import RgbdCamera
from snapfit.models.pose import Pose
from snapfit.models.rasteriser import Rendering, render
from snapfit.tracking.body import Body
from snapfit.tracking.confidence import Evidence
from snapfit.tracking.finding.clusters import Cluster
from snapfit.tracking.finding.point_cloud import PointCloud
from snapfit.tracking.frame import Frame
from snapfit.tracking.optimiser import Attempt, Optimiser
from snapfit.tracking.parameters import OcclusionParameters, TrackerParameters

_ONLY = np.ones(1, dtype=np.int64)
_BEHIND_M = 0.01


@dataclass(frozen=True, eq=False)
class Refined:
    """What became of a proposal.

    Attributes:
        camera_from_body: in the frame of the colour camera.
        likelihood: its logarithm, as the tracker has it.
        evidence: what of the frame agrees.
        overlap: of its image and the cluster's, 0 to 1.
    """

    camera_from_body: Pose
    likelihood: float
    evidence: Evidence
    overlap: float

    @property
    def score(self) -> float:
        """How sure it is, 0 to 1; says which part a cluster is, if any."""
        return self.evidence.confidence * self.overlap

    @property
    def worth(self) -> float:
        """Says which of several poses of one part explains its cluster best.

        The tracker's likelihood; it knows nothing of what the part leaves unexplained.
        """
        return max(self.likelihood, 0.0) * self.overlap


class Scorer:
    """Refines and judges poses of one part, by itself.

    Args:
        body: the part.
        camera: where the frames come from.
    """

    def __init__(self, body: Body, camera: RgbdCamera) -> None:
        # Nothing is known of the others: only what is measured can hide the part.
        occlusion = OcclusionParameters(modelled=False)
        self._optimiser = Optimiser([body], camera, TrackerParameters(occlusion=occlusion))
        self._body = body
        self._depth_from_color = camera.color_from_depth.inverse()

    def see(self, frame: Frame) -> None:
        """Take a frame.

        Raises:
            FrameError: it does not fit the camera.
        """
        self._optimiser.see(frame)

    def refine(
        self, pose: Pose, margins_px: Sequence[float], cloud: PointCloud, cluster: Cluster
    ) -> Refined | None:
        """Refine a pose, learning the colours at it in turns; None where that has no solution.

        Args:
            pose: `camera_from_body`, of the colour camera.
            margins_px: a turn each; what lies this near to the contour is not learned.
            cloud: the frame's depth.
            cluster: that the pose explains.
        """
        settled = self.settle(pose, margins_px)
        if settled is None:
            return None
        overlap = _overlap(self.drawn(settled.camera_from_body, cloud), cloud, cluster)
        return Refined(settled.camera_from_body, settled.likelihood, settled.evidence, overlap)

    def settle(self, pose: Pose, margins_px: Sequence[float]) -> Attempt | None:
        """As `refine`, without a cluster to compare with."""
        optimiser = self._optimiser
        optimiser.place(0, pose)
        optimiser.correspond()
        for margin_px in margins_px:
            optimiser.learn(_ONLY, afresh_beyond_px=margin_px)
            optimiser.refine()
            if not optimiser.is_solved(0):
                return None
        optimiser.weigh()
        likelihood, evidence = float(optimiser.likelihoods[0]), optimiser.evidence(0)
        return Attempt(optimiser.pose(0), likelihood, evidence, solved=True)

    def drawn(self, pose: Pose, cloud: PointCloud) -> Rendering:
        """The part at a pose `camera_from_body`, as the cloud's camera would see it alone."""
        return render(cloud.camera, [(self._body.mesh, self._depth_from_color @ pose)])


def drawn_window(drawn: Rendering) -> tuple[slice, slice] | None:
    """Rows and columns in which something is drawn; None where nothing is."""
    is_drawn = drawn.part_id > 0
    rows, columns = np.flatnonzero(is_drawn.any(axis=1)), np.flatnonzero(is_drawn.any(axis=0))
    if not len(rows):
        return None
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _overlap(drawn: Rendering, cloud: PointCloud, cluster: Cluster) -> float:
    """Intersection over union of a drawn part and a cluster, 0 to 1.

    Where nothing is measured, or something nearer than the part, nobody can tell.
    """
    top, left = cluster.top, cluster.left
    bottom, right = top + cluster.mask.shape[0], left + cluster.mask.shape[1]
    seen = drawn_window(drawn)
    if seen is None:
        return 0.0
    rows = slice(min(top, seen[0].start), max(bottom, seen[0].stop))
    columns = slice(min(left, seen[1].start), max(right, seen[1].stop))
    z, measured_m = drawn.depth[rows, columns], cloud.depth_m[rows, columns]
    is_part = z > 0
    known = (measured_m > 0) & ~(is_part & (measured_m < z - _BEHIND_M))
    mask = np.zeros_like(is_part)
    mask[top - rows.start : bottom - rows.start, left - columns.start : right - columns.start] = (
        cluster.mask
    )
    agrees = np.abs(measured_m - z) < _BEHIND_M
    # Nearer than the part inside its own cluster is no other thing.
    known |= mask
    union = (is_part | mask) & known
    both = is_part & mask & (agrees | (measured_m == 0))
    return float(both.sum() / max(union.sum(), 1))
