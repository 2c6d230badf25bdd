"""Colour histograms of foreground and background, a pair for each body or one for all."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from snapfit.tracking.kernels import learn
from snapfit.tracking.kernels.types import Bodies, Cameras, Images, Lines, Models
from snapfit.tracking.parameters import HistogramParameters

N_COLORS = 16**3


class ColorHistograms:
    """Learns the colours on both sides of the contours, and turns them into posteriors.

    Attributes:
        histograms: (pairs, 2, 4096) foreground and background, each sums to one.
    """

    def __init__(self, n_bodies: int, parameters: HistogramParameters) -> None:
        self._parameters = parameters
        self._owner = (
            np.zeros(n_bodies, dtype=np.int64)
            if parameters.shared
            else np.arange(n_bodies, dtype=np.int64)
        )
        self._colors = np.zeros((n_bodies, 2, N_COLORS), dtype=np.float32)
        n_pairs = 1 if parameters.shared else n_bodies
        self.histograms = np.zeros((n_pairs, 2, N_COLORS), dtype=np.float32)

    def learn(
        self,
        images: Images,
        cameras: Cameras,
        models: Models,
        bodies: Bodies,
        lines: Lines,
        which: npt.NDArray[np.int64],
        *,
        afresh_beyond_px: float | None = None,
    ) -> None:
        """Blend the colours of this frame in and write `bodies.tables`.

        Args:
            images, cameras, models, bodies, lines: as the kernels hold them after a refinement.
            which: (B,) 1 for the bodies whose pose can be believed.
            afresh_beyond_px: forget what was learned before, and learn from this far beside the
                contour on: as far as the pose may be off.
        """
        parameters = self._parameters
        rates = [parameters.foreground_rate, parameters.background_rate]
        margin_px = parameters.unconsidered_length_px
        if afresh_beyond_px is not None:
            rates, margin_px = [1.0, 1.0], max(afresh_beyond_px, margin_px)
        reach_px = np.array([margin_px, parameters.considered_length_px], dtype=np.float32)
        learn.count_colors(images, cameras, models, bodies, lines, reach_px, self._colors)
        learn.learn_colors(
            self._owner,
            which,
            self._colors,
            np.array(rates, dtype=np.float32),
            self.histograms,
            bodies.tables,
        )
