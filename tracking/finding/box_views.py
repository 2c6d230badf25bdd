"""Poses of a part that may explain a region: views of its viewpoint model, fitted into its box.

Where a part is joined to others, or in a hand, no outline of it stands out in the depth image.
What the network says of it remains: the box around the whole of it. Each view, in each turn about
the line of sight, has a box of its own: those of another shape are left out; the others are moved
until the boxes agree and half of the surface lies before, half behind what is measured.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Array, Pose
from snapfit.tracking.body import Body
from snapfit.tracking.finding.misfit import Points
from snapfit.tracking.finding.parameters import BoxParameters, ProposalParameters
from snapfit.tracking.finding.plane import Plane
from snapfit.tracking.finding.point_cloud import PointCloud
from snapfit.tracking.finding.proposals import PartViews, Proposal, about_z, along, apart
from snapfit.tracking.finding.regions import Region

_KNOWN = 0.3

Indices = npt.NDArray[np.int64]


class BoxViews(PartViews):
    """Views of a part that are fitted into boxes.

    Args:
        body: the part.
        parameters: of the views.
        box: of the fit.
    """

    def __init__(self, body: Body, parameters: ProposalParameters, box: BoxParameters) -> None:
        super().__init__(body, parameters)
        self._box = box
        # Coordinates first: minima and maxima are then taken along what lies together in memory.
        self._outline = np.ascontiguousarray(self._contour.transpose(0, 2, 1))
        self._face = np.ascontiguousarray(self._surface.transpose(0, 2, 1))

    def propose_in(self, cloud: PointCloud, plane: Plane | None, region: Region) -> list[Proposal]:
        """The best poses for a region, different from one another, the best first."""
        box = self._box
        fit = BoxFit(cloud, plane, region, box)
        turns = 2 * np.pi * np.arange(box.turns) / box.turns
        views = np.tile(np.arange(self._n_coarse), box.turns)
        turns = np.repeat(turns, self._n_coarse)
        best = self._fitted(fit, views, turns, box.followed)
        if best is None:
            return []
        views, turns = self._around(best[0], best[1])
        best = self._fitted(fit, views, turns, box.kept)
        if best is None:
            return []
        views, _, rotations, middles, errors = best
        moved = middles - np.einsum("nij,nj->ni", rotations, self._middles[views])
        return [
            Proposal(Pose.from_rotation_translation(rotations[i], moved[i]), float(errors[i]))
            for i in range(len(views))
        ]

    def _fitted(
        self, fit: BoxFit, views: Indices, turns: Array, n: int
    ) -> tuple[Indices, Array, Array, Array, Array] | None:
        """The best: views, turns, rotations (n, 3, 3), where their middles are, and errors, m."""
        turned = fit.along @ about_z(turns)
        flat = turned.astype(np.float32)
        contour = flat @ self._outline[views]
        fits = np.flatnonzero(fit.has_shape(contour))
        if not len(fits):
            return None
        views, turns, turned, contour = views[fits], turns[fits], turned[fits], contour[fits]
        rotations = turned @ self._rotations[views]
        surface = flat[fits] @ self._face[views]
        middles = fit.placed(contour, surface)
        errors = fit.of_surface(surface, middles) + fit.of_box(contour, middles)
        corners = (self._corners - self._middles[views][:, None]) @ rotations.transpose(0, 2, 1)
        errors += fit.of_support(corners + middles[:, None])
        best = apart(rotations, errors, n, self._parameters.apart_deg)
        return views[best], turns[best], rotations[best], middles[best], errors[best]


class BoxFit:
    """Places views in a region, and says how badly they fit it.

    Args:
        cloud: what is measured.
        plane: that the part may lie on, but not in; None where there is none.
        region: that is to be explained.
        parameters: of the fit.
    """

    def __init__(
        self, cloud: PointCloud, plane: Plane | None, region: Region, parameters: BoxParameters
    ) -> None:
        self._camera, self._plane, self._region = cloud.camera, plane, region
        self._depth_m = np.where(cloud.depth_m > 0, cloud.depth_m, np.nan).astype(np.float32)
        self._parameters = parameters
        u, v = region.center_px
        camera = cloud.camera
        self._ray = np.array([(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0])
        self.along = along(self._ray)

    def has_shape(self, contour: Points) -> npt.NDArray[np.bool_]:
        """(N,) whether the boxes of contours (N, 3, C) are like the region's, in shape and size."""
        size = np.ptp(contour[:, :2], axis=2)
        scale = self._camera.fx / self._region.middle_z_m
        ratios = np.maximum(size, 1e-4) * scale / self._region.size_px
        p, opens = self._parameters, self._region.open_edges
        most = np.where(opens[:2] | opens[2:], p.open_ratio, p.size_ratio)
        result: npt.NDArray[np.bool_] = ((ratios > 1 / p.size_ratio) & (ratios < most)).all(axis=1)
        return result

    def placed(self, contour: Points, surface: Points) -> Array:
        """(N, 3) where the middles are to be: boxes agree, and so does the median of the depth."""
        middles = np.tile(self._ray * self._region.middle_z_m, (len(contour), 1))
        for _ in range(2):
            low, high = self._bounds(contour, middles)
            off_px = self._off_px(low, high)
            middles[:, 0] += off_px[:, 0] * middles[:, 2] / self._camera.fx
            middles[:, 1] += off_px[:, 1] * middles[:, 2] / self._camera.fy
            behind = self._behind(surface, middles)
            shift = _median(behind)
            middles *= (1 + shift / middles[:, 2])[:, None]
        return middles

    def of_surface(self, surface: Points, middles: Array) -> Array:
        """(N,) m, mean distance along z between surfaces (N, 3, P) and what is measured there."""
        behind, reach_m = self._behind(surface, middles), self._parameters.reach_m
        errors = np.minimum(np.abs(behind), reach_m)
        # What is nearer may hide the part.
        errors = np.where(behind < -reach_m, self._parameters.hidden_share * reach_m, errors)
        known = np.isfinite(behind)
        errors = np.where(known, errors, 0.0)
        count = known.sum(axis=1)
        few = count < _KNOWN * behind.shape[1]
        mean: Array = np.where(few, reach_m, errors.sum(axis=1) / np.maximum(count, 1))
        return mean.astype(np.float64)

    def of_box(self, contour: Points, middles: Array) -> Array:
        """(N,) m, weighted differences of the boxes' edges as shares of their sizes."""
        low, high = self._bounds(contour, middles)
        off = np.abs(self._region.off_px(low, high))
        shares = off / np.tile(self._region.size_px, 2)
        result: Array = self._parameters.box_weight_m * np.minimum(shares, 1.0).mean(axis=1)
        return result

    def of_support(self, corners: Array) -> Array:
        """(N,) m that poses with corners (N, C, 3) lie in the plane."""
        if self._plane is None:
            return np.zeros(len(corners))
        lowest_m = self._plane.heights_m(corners).min(axis=1)
        result: Array = np.clip(-lowest_m, 0, self._parameters.reach_m)
        return result

    def _off_px(self, low: Array, high: Array) -> Array:
        """(N, 2) how far boxes are to be moved: by their middles, or by the edge that is known."""
        opens, box = self._region.open_edges, self._region.box_px
        at_low, at_high = box[:2] - low, box[2:] - high
        middle = (at_low + at_high) / 2
        result: Array = np.where(
            opens[:2] == opens[2:], middle, np.where(opens[:2], at_high, at_low)
        )
        return result

    def _bounds(self, points: Points, middles: Array) -> tuple[Array, Array]:
        """(N, 2) each, the least and the largest column and row of points."""
        u, v, _ = self._pixels(points, middles)
        low = np.stack([u.min(axis=1), v.min(axis=1)], axis=1)
        high = np.stack([u.max(axis=1), v.max(axis=1)], axis=1)
        return low.astype(np.float64), high.astype(np.float64)

    def _pixels(self, points: Points, middles: Array) -> tuple[Points, Points, Points]:
        """(N, P) each: columns and rows of points (N, 3, P) about middles (N, 3), and z, m."""
        camera, places = self._camera, middles.astype(np.float32)[:, :, None]
        x, y, z = (points[:, k] + places[:, k] for k in range(3))
        z = np.maximum(z, np.float32(0.01))
        u = x / z * np.float32(camera.fx) + np.float32(camera.cx)
        v = y / z * np.float32(camera.fy) + np.float32(camera.cy)
        return u, v, z

    def _behind(self, points: Points, middles: Array) -> Points:
        """(N, P) m, how far behind the points something is measured; NaN where nothing is."""
        u, v, z = self._pixels(points, middles)
        columns, rows = np.rint(u).astype(np.int64), np.rint(v).astype(np.int64)
        height, width = self._depth_m.shape
        inside = (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)
        measured = self._depth_m[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
        behind: Points = np.where(inside, measured - z, np.nan)
        return behind


def _median(behind: Points) -> Array:
    """(N,) medians over the points that are known; 0 where none is."""
    known = np.isfinite(behind)
    ordered = np.sort(behind, axis=1)
    middle = np.maximum(known.sum(axis=1) - 1, 0) // 2
    medians = ordered[np.arange(len(ordered)), middle]
    result: Array = np.where(known.any(axis=1), medians, 0.0)
    return result
