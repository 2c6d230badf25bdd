"""Poses of a part that may explain a cluster: views of its sparse viewpoint model, laid over it.

All views of a coarse grid are compared, in all turns about the line of sight; then those of a fine
grid around the best.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models.pose import Array, Pose
from snapfit.models.viewpoint_grid import viewpoint_pose
from snapfit.tracking.body import Body
from snapfit.tracking.finding.clusters import Cluster
from snapfit.tracking.finding.misfit import Misfit
from snapfit.tracking.finding.parameters import ProposalParameters
from snapfit.tracking.finding.plane import Plane
from snapfit.tracking.finding.point_cloud import PointCloud

Indices = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Proposal:
    """A pose that may explain a cluster.

    Attributes:
        depth_from_body: the pose, in the frame of the depth camera.
        error_m: how badly the part's surface and contour fit what is measured there.
    """

    depth_from_body: Pose
    error_m: float


class PartViews:
    """Some views of a part, turned so that the camera looks along z.

    Args:
        body: the part.
        parameters: how many views, and points of each.
    """

    def __init__(self, body: Body, parameters: ProposalParameters) -> None:
        self._parameters, views = parameters, body.views
        first = views.surface_area_m2[: parameters.fine_views]
        chosen = np.flatnonzero(first > 0)
        self._n_coarse = int((chosen < parameters.coarse_views).sum())
        surface = views.surface[chosen, :, :3].astype(np.float64) * views.unit_m
        contour = views.contour[chosen, : parameters.contour_points, :3] * np.float64(views.unit_m)
        self._directions = views.directions[chosen].astype(np.float64)
        self._rotations = np.array(
            [viewpoint_pose(each, np.zeros(3), 1.0).rotation for each in self._directions]
        )
        # Samples are spread evenly over a view's image, as a cluster's points are: the means of
        # both are the same point.
        self._middles = surface.mean(axis=1)
        self._surface = self._seen(surface[:, : parameters.surface_points])
        self._contour = self._seen(contour)
        self._areas_m2 = np.asarray(first[chosen], dtype=np.float64)
        self._corners = _corners(body.mesh.vertices)

    def propose(self, cloud: PointCloud, plane: Plane | None, cluster: Cluster) -> list[Proposal]:
        """The best poses for a cluster, different from one another, the best first."""
        p = self._parameters
        ratios = np.abs(np.log(self._areas_m2[: self._n_coarse] / cluster.area_m2))
        fitting = np.flatnonzero(ratios < np.log(p.area_ratio))
        if not len(fitting):
            return []
        misfit = Misfit(cloud, plane, cluster, p)
        turns = 2 * np.pi * np.arange(p.turns) / p.turns
        views, turns = np.tile(fitting, p.turns), np.repeat(turns, len(fitting))
        sight = along(cluster.middle_m)
        rotations, errors = self._errors(misfit, sight, views, turns)
        best = apart(rotations, errors, p.followed, p.apart_deg)
        views, turns = self._around(views[best], turns[best])
        rotations, errors = self._errors(misfit, sight, views, turns)
        best = apart(rotations, errors, p.kept, p.apart_deg)
        moved = cluster.middle_m - np.einsum("nij,nj->ni", rotations, self._middles[views])
        return [
            Proposal(Pose.from_rotation_translation(rotations[i], moved[i]), float(errors[i]))
            for i in best
        ]

    def _errors(
        self, misfit: Misfit, sight: Array, views: Indices, turns: Array
    ) -> tuple[Array, Array]:
        """Rotations (N, 3, 3) of views (N,) in turns (N,), rad, and errors (N,) m."""
        turned = sight @ about_z(turns)
        rotations = turned @ self._rotations[views]
        flat = turned.transpose(0, 2, 1).astype(np.float32)
        corners = (self._corners - self._middles[views][:, None]) @ rotations.transpose(0, 2, 1)
        errors = misfit.of_surface(self._surface[views] @ flat)
        errors += misfit.of_contour(self._contour[views] @ flat)
        errors += misfit.of_area(self._areas_m2[views]) + misfit.of_support(corners)
        return rotations, errors

    def _around(self, views: Indices, turns: Array) -> tuple[Indices, Array]:
        """Views of the fine grid around given ones, each in three turns."""
        p = self._parameters
        cosines = self._directions[views] @ self._directions.T
        which, near = np.nonzero(cosines > np.cos(np.radians(p.around_deg)))
        # Rz(turn') R' is to be as near as can be to Rz(turn) R.
        relative = (
            about_z(turns[which])
            @ self._rotations[views[which]]
            @ self._rotations[near].transpose(0, 2, 1)
        )
        same = np.arctan2(
            relative[:, 1, 0] - relative[:, 0, 1], relative[:, 0, 0] + relative[:, 1, 1]
        )
        step = np.pi / p.turns
        return np.tile(near, 3), np.concatenate([same - step, same, same + step])

    def _seen(self, points: Array) -> npt.NDArray[np.float32]:
        """Points (V, P, 3) of the body's frame as their views see them, about the middles."""
        seen: Array = (points - self._middles[:, None]) @ self._rotations.transpose(0, 2, 1)
        return seen.astype(np.float32)


def _corners(vertices: npt.NDArray[np.float32]) -> Array:
    """(C, 3) vertices that lie outermost in some direction: of them one is lowest in any pose."""
    directions = np.random.default_rng(0).standard_normal((80, 3))
    outermost = np.unique((vertices @ directions.T).argmax(axis=0))
    corners: Array = vertices[outermost].astype(np.float64)
    return corners


def about_z(angles: Array) -> Array:
    """(N, 3, 3) rotations about z by angles (N,), rad."""
    result = np.zeros((len(angles), 3, 3))
    result[:, 0, 0] = result[:, 1, 1] = np.cos(angles)
    result[:, 1, 0] = np.sin(angles)
    result[:, 0, 1] = -result[:, 1, 0]
    result[:, 2, 2] = 1
    return result


def along(ray: Array) -> Array:
    """(3, 3) rotation that lays the line of sight along a ray."""
    z = ray / np.linalg.norm(ray)
    x = np.cross((0.0, 1.0, 0.0), z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


def apart(rotations: Array, errors: Array, n: int, apart_deg: float) -> list[int]:
    """Indices of the least errors whose rotations (N, 3, 3) are some degrees apart."""
    chosen: list[int] = []
    # The trace of the relative rotation is 1 + 2 cos(angle).
    largest = 1 + 2 * np.cos(np.radians(apart_deg))
    remaining = errors.copy()
    flat = rotations.reshape(-1, 9)
    while len(chosen) < n:
        best = int(np.argmin(remaining))
        if not np.isfinite(remaining[best]):
            break
        chosen.append(best)
        remaining[flat @ flat[best] > largest] = np.inf
    return chosen
