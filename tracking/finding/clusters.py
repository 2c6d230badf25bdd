"""Clusters of points: things that lie apart from one another, by DBSCAN (Open3D)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import cv2
import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from snapfit.models.pose import Array
from snapfit.tracking.finding.open3d_module import open3d
from snapfit.tracking.finding.parameters import CloudParameters
from snapfit.tracking.finding.point_cloud import PointCloud, extent_m

_MARGIN = 12
_FEW = 0.3


@dataclass(frozen=True, eq=False)
class Cluster:
    """Points of one thing, or of several that touch.

    Attributes:
        pieces: which of the pieces of the cloud it is made of; two clusters that share one cannot
            both be parts.
        middle_m: (3,) mean of its points, frame of the depth camera.
        extent_m: how far its points lie apart at most.
        area_m2: of its image, as large as it is at the middle's distance.
        top, left: row and column of the window around it.
        mask: (h, w) bool, its image in that window, small holes filled.
        outline: (h, w) float32, points (rows or columns) from each to the image's border.
    """

    pieces: frozenset[int]
    middle_m: Array
    extent_m: float
    area_m2: float
    top: int
    left: int
    mask: npt.NDArray[np.bool_]
    outline: npt.NDArray[np.float32]


def find_clusters(
    cloud: PointCloud, rises: npt.NDArray[np.bool_], parameters: CloudParameters, largest_m: float
) -> list[Cluster]:
    """The clusters among the points that rise above the plane, the largest first.

    Pieces that lie near one another are given together too, after all single ones: depth is
    missing at thin and at steep places, and what is one thing falls into pieces.

    Args:
        cloud: all points.
        rises: (h, w) those in question.
        parameters: of the clustering.
        largest_m: what extends farther is no part.

    Raises:
        TrackingError: Open3D cannot be imported.
    """
    points = cloud.points_m[rises]
    if len(points) < parameters.least_points:
        return []
    module = open3d()
    wrapped = module.geometry.PointCloud(module.utility.Vector3dVector(points))
    labels = np.asarray(wrapped.cluster_dbscan(parameters.neighbour_m, parameters.neighbours))
    counts = np.bincount(labels[labels >= 0], minlength=1)
    order = np.argsort(-counts, kind="stable")
    order = order[counts[order] >= _FEW * parameters.least_points]
    pieces = [points[labels == label] for label in order]
    pieces = [each for each in pieces if extent_m(each) <= largest_m]
    groups = [frozenset([i]) for i in range(len(pieces))]
    groups += _together(pieces, parameters.gap_m)
    found = []
    for group in groups:
        joined = np.concatenate([pieces[i] for i in sorted(group)])
        enough = len(joined) >= parameters.least_points
        if enough and (len(group) == 1 or extent_m(joined) <= largest_m):
            found.append(_cluster(cloud, group, joined))
    return found


def _together(pieces: Sequence[Array], gap_m: float) -> list[frozenset[int]]:
    """Pairs of pieces with small gaps, and all that hang together by such."""
    trees = [cKDTree(each) for each in pieces]
    middles = np.array([each.mean(axis=0) for each in pieces])
    radii = [
        np.linalg.norm(each - middle, axis=1).max()
        for each, middle in zip(pieces, middles, strict=True)
    ]
    pairs = []
    for i, j in combinations(range(len(pieces)), 2):
        apart_m = np.linalg.norm(middles[i] - middles[j]) - radii[i] - radii[j]
        if (
            apart_m < gap_m
            and trees[i].query(pieces[j], distance_upper_bound=gap_m)[0].min() < gap_m
        ):
            pairs.append(frozenset([i, j]))
    joined = list(pairs)
    whole: list[frozenset[int]] = []
    for pair in pairs:
        touching = [each for each in whole if each & pair]
        whole = [each for each in whole if not each & pair] + [pair.union(*touching)]
    return joined + [each for each in whole if len(each) > 2]


def _cluster(cloud: PointCloud, pieces: frozenset[int], points: Array) -> Cluster:
    columns, rows = np.rint(cloud.camera.project(points)).astype(np.int64).T
    top, left = max(rows.min() - _MARGIN, 0), max(columns.min() - _MARGIN, 0)
    bottom = min(rows.max() + _MARGIN + 1, cloud.camera.height)
    right = min(columns.max() + _MARGIN + 1, cloud.camera.width)
    window = np.zeros((bottom - top, right - left), dtype=np.uint8)
    window[rows - top, columns - left] = 1
    # Depth is missing at steep sides: that is no hole in the thing.
    window = cv2.morphologyEx(window, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    inside = cv2.distanceTransform(window, cv2.DIST_L2, 5)
    outside = cv2.distanceTransform(1 - window, cv2.DIST_L2, 5)
    outline = np.maximum(inside, outside) - np.float32(0.5)
    middle_m = points.mean(axis=0)
    pixel_m2 = middle_m[2] ** 2 / (cloud.camera.fx * cloud.camera.fy)
    return Cluster(
        pieces=pieces,
        middle_m=middle_m,
        extent_m=extent_m(points),
        area_m2=float(window.sum() * pixel_m2),
        top=int(top),
        left=int(left),
        mask=window.astype(bool),
        outline=outline,
    )
