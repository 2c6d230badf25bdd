"""Judges one part's estimates against the truth, with all that does not change made once."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from snapfit.models.asset import Part
from snapfit.models.camera import PinholeCamera
from snapfit.models.pose import Pose
from snapfit.tracking.benchmark.consistency import UNKNOWN, normalised_error
from snapfit.tracking.metrics import (
    add_m,
    add_s_m,
    model_vertices,
    mspd_px,
    mssd_m,
    symmetry_motions,
)

Array = npt.NDArray[np.float64]


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
    """Judges the poses of one part.

    ADD(-S) is the mean over a sample of the vertices; the closest point of ADD-S is looked for
    among all of them. MSSD and MSPD go over all.
    """

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
        self._tree = cKDTree(self._vertices)
        self._motions = symmetry_motions(part.symmetry, part.mesh.diameter_m)

    def judge(
        self, estimate: Pose | None, truth: Pose, covariance: Array | None = None
    ) -> tuple[PoseErrors, Array]:
        """What is wrong with an estimate, or with none at all.

        Args:
            estimate: `camera_from_body`, None where there is none.
            truth: `camera_from_body`.
            covariance: (6, 6) of the estimate, as in `PartEstimate`.

        Returns:
            The errors; and (3,) as `normalised_error`, not a number without a covariance.
        """
        if estimate is None:
            return MISSED, UNKNOWN
        nearest = self._symmetry.nearest(estimate, truth)
        if self._symmetry.is_none:
            error_m = add_m(self._sample, estimate, truth)
        else:
            error_m = add_s_m(self._sample, estimate, truth, self._tree)
        errors = PoseErrors(
            add_m=error_m,
            # As `distance_modulo_symmetry`.
            translation_m=truth.distance_to(nearest),
            rotation_rad=truth.angle_to(nearest),
            mssd_m=mssd_m(self._vertices, estimate, truth, self._motions),
            mspd_px=mspd_px(self._vertices, estimate, truth, self._motions, self._camera),
        )
        if covariance is None:
            return errors, UNKNOWN
        return errors, normalised_error(estimate, nearest, truth, self._symmetry, covariance)
