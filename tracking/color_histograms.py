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
        self._reach_px = np.array(
            [parameters.unconsidered_length_px, parameters.considered_length_px], dtype=np.float32
        )
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
        afresh: bool = False,
    ) -> None:
        """Blend the colours of this frame in and write `bodies.tables`.

        Args:
            images, cameras, models, bodies, lines: as the kernels hold them after a refinement.
            which: (B,) 1 for the bodies whose pose can be believed.
            afresh: forget what was learned before.
        """
        learn.count_colors(images, cameras, models, bodies, lines, self._reach_px, self._colors)
        rates = (
            [1.0, 1.0]
            if afresh
            else [self._parameters.foreground_rate, self._parameters.background_rate]
        )
        learn.learn_colors(
            self._owner,
            which,
            self._colors,
            np.array(rates, dtype=np.float32),
            self.histograms,
            bodies.tables,
        )
