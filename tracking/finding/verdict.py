"""How sure a pose is that was found in a box."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from snapfit.models.pose import Array, Pose
from snapfit.models.rasteriser import Rendering
from snapfit.tracking.confidence import Evidence
from snapfit.tracking.finding.point_cloud import PointCloud
from snapfit.tracking.finding.regions import Region
from snapfit.tracking.optimiser import Attempt

_AGREES_M = 0.008
_SURE = 0.57
_AROUND, _NEARER_M, _FARTHER_M = 4, 0.01, 0.02


@dataclass(frozen=True, eq=False)
class Verdict:
    """A refined pose, and what speaks for it.

    The outline of a joined or hidden part stands out nowhere: none is asked for. What is left: the
    share of the tracker's lines and points that agree, its likelihood a line or point, the share of
    the drawn surface that lies where depth is measured (what is hidden by something nearer is not
    asked, what is seen through speaks against it), and the network's box. The box is often a little
    off; where the network is sure of the part, and it explains all that stands there, that is as
    good.

    Attributes:
        camera_from_body: the pose, of the colour camera.
        likelihood: its logarithm, as the tracker has it.
        evidence: what of the frame agrees.
        agrees: share of the drawn surface, 0 to 1.
        box: intersection over union of the drawn part's box and the network's, 0 to 1.
        alone: share of what stands out at the part and around it, at its distance, that it
            explains, 0 to 1; 0 where the network is not sure of it.
    """

    camera_from_body: Pose
    likelihood: float
    evidence: Evidence
    agrees: float
    box: float
    alone: float = 0.0

    @property
    def score(self) -> float:
        """How sure it is, 0 to 1; comparable between parts."""
        count = max(self.evidence.lines + self.evidence.points, 1)
        likely = min(max(self.likelihood / count, 0.0), 1.0)
        return float(
            self.evidence.confidence * likely * self.agrees * np.sqrt(max(self.box, self.alone))
        )


def judged(settled: Attempt, drawn: Rendering, cloud: PointCloud, region: Region) -> Verdict:
    """The verdict on a pose.

    Args:
        settled: the pose, refined.
        drawn: the part alone at this pose, in the image of the cloud's camera.
        cloud: what is measured.
        region: in which the part was looked for.
    """
    agrees, box, alone = 0.0, 0.0, 0.0
    is_part = drawn.depth > 0
    if is_part.any():
        rows, columns = np.flatnonzero(is_part.any(axis=1)), np.flatnonzero(is_part.any(axis=0))
        edges = np.array([columns[0], rows[0], columns[-1] + 1, rows[-1] + 1]) - 0.5
        box = _overlap(edges, _known_box(edges, region))
        behind = cloud.depth_m[is_part] - drawn.depth[is_part]
        asked = (cloud.depth_m[is_part] > 0) & (behind >= -_AGREES_M)
        n_there = int((behind[asked] <= _AGREES_M).sum())
        agrees = n_there / max(int(asked.sum()), 1)
        if region.score > _SURE:
            alone = n_there / max(n_there + _beside(drawn, cloud, region), 1)
    pose, likelihood, evidence = settled.camera_from_body, settled.likelihood, settled.evidence
    return Verdict(pose, likelihood, evidence, agrees, box, alone)


def _beside(drawn: Rendering, cloud: PointCloud, region: Region) -> int:
    """How many points stand out around a drawn part, at its distance, and do not belong to it."""
    is_part = drawn.depth > 0
    rows, columns = np.flatnonzero(is_part.any(axis=1)), np.flatnonzero(is_part.any(axis=0))
    window = np.s_[
        max(rows[0] - _AROUND, 0) : rows[-1] + _AROUND + 1,
        max(columns[0] - _AROUND, 0) : columns[-1] + _AROUND + 1,
    ]
    part, z, measured = is_part[window], drawn.depth[window], cloud.depth_m[window]
    near, far = z[part].min() - _NEARER_M, z[part].max() + _FARTHER_M
    others = region.stands[window] & ~part & (measured > near) & (measured < far)
    return int(others.sum())


def _known_box(drawn: Array, region: Region) -> Array:
    """The region's box (4,), its open edges as far out as those of a drawn part."""
    box, opens = region.box_px, region.open_edges
    low, high = np.minimum(box, drawn), np.maximum(box, drawn)
    result: Array = np.where(opens, np.concatenate([low[:2], high[2:]]), box)
    return result


def _overlap(box: Array, other: Array) -> float:
    """Intersection over union of two boxes (4,), 0 to 1."""
    near, far = np.maximum(box[:2], other[:2]), np.minimum(box[2:], other[2:])
    common = float(np.maximum(far - near, 0).prod())
    total = float((box[2:] - box[:2]).prod() + (other[2:] - other[:2]).prod()) - common
    return common / max(total, 1e-9)
