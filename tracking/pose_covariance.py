"""How wrong the pose of each body can be, as it is published."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from snapfit.tracking.body import Body
from snapfit.tracking.kernels.covariance import CovarianceSettings, covariances
from snapfit.tracking.kernels.types import Bodies, Structures
from snapfit.tracking.parameters import CovarianceParameters


class PoseCovariances:
    """Covariances of some bodies' poses.

    Args:
        bodies: whose.
        parameters: of the model of the errors.
    """

    def __init__(self, bodies: Sequence[Body], parameters: CovarianceParameters) -> None:
        self._centers = np.array([body.mesh.center_m for body in bodies], dtype=np.float64)
        self._settings = CovarianceSettings(
            information=parameters.information,
            prior_rotation=parameters.prior_rotation_rad**-2,
            prior_translation=parameters.prior_translation_m**-2,
            distance=parameters.systematic_distance,
            place_m=parameters.systematic_place_m,
            turn_rad=parameters.systematic_turn_rad,
        )

    def of(self, bodies: Bodies, structures: Structures) -> npt.NDArray[np.float64]:
        """(B, 6, 6) of the right perturbations: rotation (rad), then translation (m).

        Args:
            bodies: as the last refinement has left them.
            structures: how they are linked.
        """
        found = np.empty((len(self._centers), 6, 6))
        covariances(structures, bodies, self._centers, self._settings, found)
        return found
