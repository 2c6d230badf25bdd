"""The region modality of all bodies: settings and working arrays of its kernels."""

from __future__ import annotations

import numpy as np

from snapfit.tracking.kernels.types import Lines, RegionSettings
from snapfit.tracking.parameters import (
    DISTRIBUTION_LENGTH,
    FUNCTION_LENGTH,
    RegionParameters,
    per_iteration,
)


def region_settings(parameters: RegionParameters, iterations: int) -> RegionSettings:
    """The parameters as the kernels take them, with an entry for each iteration."""
    x = np.arange(FUNCTION_LENGTH) - (FUNCTION_LENGTH - 1) / 2
    # The smoothed step function of the foreground (SRT3D).
    step = 0.5 - parameters.amplitude * np.tanh(x / (2 * parameters.slope))
    return RegionSettings(
        scales=np.array(per_iteration(parameters.scales_px, iterations), dtype=np.int64),
        sigmas=np.array(
            per_iteration(parameters.standard_deviations_px, iterations), dtype=np.float32
        ),
        step_foreground=step.astype(np.float32),
        min_continuous=np.float32(parameters.min_continuous_distance),
        min_variance=np.float32(parameters.min_variance),
        learning_rate=np.float32(parameters.learning_rate),
        outlying=np.float32(parameters.outlying),
        global_updates=parameters.global_updates,
    )


def empty_lines(n_bodies: int, lines_max: int) -> Lines:
    """Working arrays for the correspondence lines of all bodies."""
    shape = (n_bodies, max(lines_max, 1))
    return Lines(
        point=np.zeros((*shape, 3), dtype=np.float32),
        place=np.zeros((*shape, 8), dtype=np.float32),
        posterior=np.zeros((*shape, DISTRIBUTION_LENGTH), dtype=np.float32),
        moments=np.zeros((*shape, 2), dtype=np.float32),
        valid=np.zeros(shape, dtype=np.uint8),
    )
