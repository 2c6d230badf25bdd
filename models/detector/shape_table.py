"""The shapes of all classes as tensors, and canonical poses of many parts at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import torch
from torch import Tensor

from snapfit.models.detector.shapes import PartShape
from snapfit.models.keypoints import main_axis, reference_rotation
from snapfit.models.pose import Array, Pose
from snapfit.models.symmetry import Symmetry

_EPSILON = 1e-9


@dataclass(frozen=True, eq=False)
class ShapeTable:
    """C classes: their keypoints, their outlines, and the motions that map them onto themselves.

    Attributes:
        keypoints: (C, K, 3) m, body frame.
        hulls: (C, H, 3) corners of the convex hull, m, body frame; the first one fills up.
        motions: (C, S, 3, 3) rotations of the symmetry's discrete motions, the identity first,
            which fills up.
        shifts: (C, S, 3) their translations, m.
        axes: (C, 3) direction of the continuous axis; zero without one.
        points: (C, 3) a point on it, m.
        references: (C, 3, 3) the rotation to which a canonical pose is nearest; see
            `models.keypoints`.
        is_symmetric: (C,) whether there is more than one pose to choose from.
    """

    keypoints: Tensor
    hulls: Tensor
    motions: Tensor
    shifts: Tensor
    axes: Tensor
    points: Tensor
    references: Tensor
    is_symmetric: Tensor

    def to(self, device: torch.device) -> ShapeTable:
        """The same on another device."""
        return ShapeTable(*(getattr(self, each.name).to(device) for each in fields(self)))


def shape_table(shapes: Sequence[PartShape]) -> ShapeTable:
    """A table of the parts, by their class numbers, which go from 0 upwards."""
    ordered = sorted(shapes, key=lambda shape: shape.number)
    symmetries = [shape.symmetry for shape in ordered]
    motions = [_motions(each) for each in symmetries]
    most = max(len(each) for each in motions)
    filled = np.array([each + [np.eye(4)] * (most - len(each)) for each in motions])
    longest = max(len(shape.hull_m) for shape in ordered)
    hulls = [_filled(shape.hull_m, longest) for shape in ordered]
    axes = [np.zeros(3) if s.axis is None else s.axis.direction for s in symmetries]
    points = [np.zeros(3) if s.axis is None else s.axis.point_m for s in symmetries]
    references = [np.eye(3) if s.is_none else reference_rotation(main_axis(s)) for s in symmetries]
    arrays = (
        [shape.keypoints_m for shape in ordered],
        hulls,
        filled[..., :3, :3],
        filled[..., :3, 3],
        axes,
        points,
        references,
    )
    tensors = [torch.from_numpy(np.array(each, dtype=np.float32)) for each in arrays]
    tensors.append(torch.tensor([not s.is_none for s in symmetries]))
    return ShapeTable(*tensors)


def canonical(
    rotations: Tensor, translations: Tensor, classes: Tensor, shapes: ShapeTable
) -> tuple[Tensor, Tensor]:
    """The canonical poses of P parts, as `models.keypoints.canonical_pose` has them.

    Args:
        rotations: (P, 3, 3) camera from body.
        translations: (P, 3) m.
        classes: (P,).
        shapes: of the classes.

    Returns:
        Rotations (P, 3, 3) and translations (P, 3).
    """
    wanted = _towards(translations) @ shapes.references[classes]
    turned = rotations[:, None] @ shapes.motions[classes]
    moved = (rotations[:, None] @ shapes.shifts[classes][..., None])[..., 0]
    moved = moved + translations[:, None]
    turned, moved = _about_axis(turned, moved, classes, shapes, wanted)
    # The trace of the rotation between two frames is the larger the smaller its angle.
    agreement = (wanted[:, None] * turned).sum((-2, -1))
    best = agreement.argmax(dim=1)
    rows = torch.arange(len(classes), device=classes.device)
    keep = ~shapes.is_symmetric[classes]
    rotation = torch.where(keep[:, None, None], rotations, turned[rows, best])
    translation = torch.where(keep[:, None], translations, moved[rows, best])
    return rotation, translation


def _about_axis(
    turned: Tensor, moved: Tensor, classes: Tensor, shapes: ShapeTable, wanted: Tensor
) -> tuple[Tensor, Tensor]:
    """Turned about the continuous axis until the rotation is nearest to the wanted one.

    With M = R_wanted^T R, the trace of M R_a(t) is cos t (tr M - a^T M a) + sin t tr(M [a]x) and a
    constant.
    """
    axis = shapes.axes[classes][:, None]
    cross = _cross_matrix(axis)
    relative = wanted[:, None].transpose(-2, -1) @ turned
    along = (axis[..., None, :] @ relative @ axis[..., None])[..., 0, 0]
    cosine = relative.diagonal(dim1=-2, dim2=-1).sum(-1) - along
    sine = (relative * cross.transpose(-2, -1)).sum((-2, -1))
    angle = torch.atan2(sine, cosine)[..., None, None]
    has_axis = (axis.square().sum(-1) > _EPSILON)[..., None, None]
    eye = torch.eye(3, device=turned.device)
    turn = eye + torch.sin(angle) * cross + (1 - torch.cos(angle)) * (cross @ cross)
    turn = torch.where(has_axis, turn, eye)
    point = shapes.points[classes][:, None, :, None]
    shift = (turned @ (point - turn @ point))[..., 0]
    return turned @ turn, moved + shift


def _towards(points: Tensor) -> Tensor:
    """(P, 3, 3) the smallest rotations that bring the optical axis to the rays to points (P, 3)."""
    ray = points / points.norm(dim=-1, keepdim=True)
    eye = torch.eye(3, device=ray.device)
    cross = _cross_matrix(torch.linalg.cross(eye[2].expand_as(ray), ray))
    # Rodrigues' formula with the sine in the matrix: (1 - cos) / sin^2 = 1 / (1 + cos).
    return eye + cross + (cross @ cross) / (1 + ray[:, 2])[:, None, None]


def _cross_matrix(vectors: Tensor) -> Tensor:
    """(..., 3, 3) of (..., 3)."""
    x, y, z = vectors.unbind(-1)
    o = torch.zeros_like(x)
    rows = torch.stack([o, -z, y, z, o, -x, -y, x, o], dim=-1)
    return rows.unflatten(-1, (3, 3))


def _motions(symmetry: Symmetry) -> list[Array]:
    return [pose.matrix for pose in (Pose.identity(), *symmetry.motions)]


def _filled(points: Array, count: int) -> Array:
    return np.concatenate([points, np.repeat(points[:1], count - len(points), axis=0)])
