"""Judges one part's estimates against the truth, with all that does not change made once."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

from scipy.spatial import cKDTree

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.models.symmetry import distance_modulo_symmetry
from snapfit.tracking.metrics import (
    add_m,
    add_s_m,
    model_vertices,
    mspd_px,
    mssd_m,
    symmetry_motions,
)


@dataclass(frozen=True)
class PoseErrors:
    """What is wrong with one estimate; infinite everywhere where there is none.

    Attributes:
        add_m: ADD-S of a symmetric part, ADD of any other, m.
        translation_m, rotation_rad: of the body's origin and axes, the symmetry taken out.
        mssd_m: m.
        mspd_px: px.
    """

    add_m: float = math.inf
    translation_m: float = math.inf
    rotation_rad: float = math.inf
    mssd_m: float = math.inf
    mspd_px: float = math.inf

    @property
    def values(self) -> tuple[float, ...]:
        """In the order of the attributes."""
        return astuple(self)


MISSED = PoseErrors()


class PartJudge:
    """Judges the poses of one part: ADD(-S) over a sample of its vertices, the others over all."""

    def __init__(self, part: Part, camera: PinholeCamera) -> None:
        """Makes ready.

        Args:
            part: whose poses are judged.
            camera: the colour camera.
        """
        self._symmetry = part.symmetry
        self._camera = camera
        self._sample = model_vertices(part.mesh)
        self._vertices = model_vertices(part.mesh, None)
        self._tree = cKDTree(self._sample)
        self._motions = symmetry_motions(part.symmetry, part.mesh.diameter_m)

    def judge(self, estimate: Pose | None, truth: Pose) -> PoseErrors:
        """The errors of an estimate (`camera_from_body`), or those of none at all."""
        if estimate is None:
            return MISSED
        if self._symmetry.is_none:
            error_m = add_m(self._sample, estimate, truth)
        else:
            error_m = add_s_m(self._sample, estimate, truth, self._tree)
        translation_m, rotation_rad = distance_modulo_symmetry(truth, estimate, self._symmetry)
        return PoseErrors(
            add_m=error_m,
            translation_m=translation_m,
            rotation_rad=rotation_rad,
            mssd_m=mssd_m(self._vertices, estimate, truth, self._motions),
            mspd_px=mspd_px(self._vertices, estimate, truth, self._motions, self._camera),
        )
