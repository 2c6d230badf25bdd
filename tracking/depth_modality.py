"""The depth modality of all bodies: settings and working arrays of its kernels."""

from __future__ import annotations

import numpy as np

from snapfit.tracking.kernels.types import DepthSettings, Points
from snapfit.tracking.parameters import DepthParameters, per_iteration


def depth_settings(parameters: DepthParameters, iterations: int) -> DepthSettings:
    """The parameters as the kernels take them, with an entry for each iteration."""
    return DepthSettings(
        considered=np.array(
            per_iteration(parameters.considered_distances_m, iterations), dtype=np.float32
        ),
        sigmas=np.array(
            per_iteration(parameters.standard_deviations_m, iterations), dtype=np.float32
        ),
        strides=np.array(per_iteration(parameters.strides_m, iterations), dtype=np.float32),
        beside=np.float32(parameters.beside),
        beside_slope=np.float32(parameters.beside_slope),
    )


def empty_points(n_bodies: int, points_max: int) -> Points:
    """Working arrays for the surface points of all bodies."""
    shape = (n_bodies, max(points_max, 1))
    return Points(
        point=np.zeros((*shape, 3), dtype=np.float32),
        normal=np.zeros((*shape, 3), dtype=np.float32),
        measured=np.zeros((*shape, 3), dtype=np.float32),
        weight=np.zeros(shape, dtype=np.float32),
        valid=np.zeros(shape, dtype=np.uint8),
    )
