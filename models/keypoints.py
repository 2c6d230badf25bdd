"""Surface keypoints of a part, and which of its equivalent poses they are shown in.

Keypoints are chosen by farthest point sampling (Gonzalez, 1985; Peng et al., "PVNet", CVPR 2019).

A symmetric part looks the same in several poses, yet its keypoints stand elsewhere in each: a
network cannot know which is meant. So keypoints are always those of the canonical pose: of all
that look alike, the one whose rotation, seen along the ray to the part, is nearest to a fixed
reference. It depends on nothing but what the camera sees. A rotation found from keypoints by PnP
is then the canonical one, which is as good as any other.

No such rule can be continuous everywhere (a part with n turns must jump somewhere when it is
turned by one of them). The reference is laid so that the worst of it, where all turns about the
main axis are equally far, happens in one direction of that axis only: level, from right to left
across the picture and a little away from the camera, which nothing that stands or is held upright
has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from snapfit.models.asset import Part
from snapfit.models.mesh import Mesh
from snapfit.models.pose import Array, Pose, rotation_vector
from snapfit.models.symmetry import Symmetry

N_KEYPOINTS = 17

_CANDIDATES = 20_000
_SEED = 17
# Where the main axis of a symmetric part points in the reference: right and towards the camera.
_MAIN_AXIS = np.array([0.8, 0.0, -0.6])


@dataclass(frozen=True, eq=False)
class KeypointModel:
    """A part as the keypoint network knows it.

    Attributes:
        name: of the part.
        class_id: as in the asset.
        points: (K, 3) float64 keypoints, m, body frame.
        normals: (K, 3) unit, out of the surface there.
        symmetry: of the part.
    """

    name: str
    class_id: int
    points: Array
    normals: Array
    symmetry: Symmetry

    def in_camera(self, camera_from_body: Pose) -> Array:
        """(K, 3) keypoints of the canonical pose, m, camera frame."""
        return canonical_pose(camera_from_body, self.symmetry).transform(self.points)


def keypoint_models(
    parts: Sequence[Part], n_keypoints: int = N_KEYPOINTS
) -> tuple[KeypointModel, ...]:
    """One for each part, in their order."""
    return tuple(
        KeypointModel(p.name, p.class_id, *surface_keypoints(p.mesh, n_keypoints), p.symmetry)
        for p in parts
    )


def surface_keypoints(mesh: Mesh, n_keypoints: int = N_KEYPOINTS) -> tuple[Array, Array]:
    """Points spread over the surface, (K, 3), m, body frame, and (K, 3) its normals there.

    The same mesh gives the same.

    The first is the farthest from the surface's centroid, each other one the farthest from all
    before it, of 20,000 points drawn evenly over the surface.
    """
    candidates, normals = surface_samples(mesh, _CANDIDATES, np.random.default_rng(_SEED))
    squared = ((candidates - candidates.mean(axis=0)) ** 2).sum(axis=1)
    chosen = [int(np.argmax(squared))]
    nearest = np.full(len(candidates), np.inf)
    while len(chosen) < n_keypoints:
        nearest = np.minimum(nearest, ((candidates - candidates[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(nearest)))
    return candidates[chosen], normals[chosen]


def surface_samples(mesh: Mesh, n: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Points drawn evenly over the surface, (n, 3), m, body frame, and (n, 3) unit normals."""
    corners = mesh.vertices.astype(np.float64)[mesh.faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = np.cross(first, second)
    area = np.linalg.norm(normals, axis=1)
    faces = np.searchsorted(np.cumsum(area) / area.sum(), rng.random(n))
    faces = np.minimum(faces, len(area) - 1)
    u, v = rng.random((2, n))
    outside = u + v > 1
    u, v = np.where(outside, 1 - u, u), np.where(outside, 1 - v, v)
    points = corners[faces, 0] + u[:, None] * first[faces] + v[:, None] * second[faces]
    return points, normals[faces] / np.maximum(area[faces], 1e-30)[:, None]


def canonical_pose(camera_from_body: Pose, symmetry: Symmetry) -> Pose:
    """Of all poses that look like this one, the one in which keypoints are given.

    Args:
        camera_from_body: any of them, in front of the camera.
        symmetry: of the part; its motions form a group, as those of real parts do.
    """
    if symmetry.is_none:
        return camera_from_body
    towards = _ray_rotation(camera_from_body.translation)
    reference = towards @ reference_rotation(main_axis(symmetry))
    nearest = Pose.from_rotation_translation(reference, camera_from_body.translation)
    return symmetry.nearest(camera_from_body, nearest)


def main_axis(symmetry: Symmetry) -> npt.NDArray[np.float64]:
    """(3,) unit axis, body frame, about which most of a symmetry's turns go."""
    if symmetry.axis is not None:
        return symmetry.axis.direction
    vectors = [rotation_vector(motion.rotation) for motion in symmetry.motions]
    axes = [vector / np.linalg.norm(vector) for vector in vectors if np.linalg.norm(vector) > 1e-6]
    if not axes:
        return np.array([0.0, 0.0, 1.0])
    counts = [sum(abs(float(axis @ other)) > 0.999 for other in axes) for axis in axes]
    best = axes[int(np.argmax(counts))]
    # A turn by half may be stated about either end: take the one that points forward.
    largest = int(np.argmax(np.abs(best) > 0.9 * np.abs(best).max()))
    return best if best[largest] > 0 else -best


def reference_rotation(axis: Array) -> Array:
    """(3, 3) a fixed rotation that brings a body's axis to `_MAIN_AXIS` in the camera frame."""
    return _frame_along(_MAIN_AXIS) @ _frame_along(axis).T


def _frame_along(axis: Array) -> Array:
    """(3, 3) rotation whose third column is a unit axis."""
    helper = np.zeros(3)
    helper[int(np.argmin(np.abs(axis)))] = 1.0
    x = np.cross(helper, axis)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def _ray_rotation(point: Array) -> Array:
    """(3, 3) the smallest rotation that brings the optical axis to the ray to a point (3,)."""
    ray = point / np.linalg.norm(point)
    turn = np.cross((0.0, 0.0, 1.0), ray)
    sine = float(np.linalg.norm(turn))
    if sine < 1e-9:
        return np.eye(3)
    angle = np.arctan2(sine, ray[2])
    return Pose.exp([*(turn / sine * angle), 0, 0, 0]).rotation
