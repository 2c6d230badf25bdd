"""After the final pose of a frame: learn the colours of all bodies."""

from __future__ import annotations

import numpy as np
from numba import njit, prange

from snapfit.tracking.kernels.geometry import intrinsics
from snapfit.tracking.kernels.histogram import (
    add_colors,
    blend,
    posterior_table,
)
from snapfit.tracking.kernels.types import (
    F32,
    I64,
    Bodies,
    Cameras,
    Images,
    Lines,
    Models,
)


@njit(cache=True, nogil=True, parallel=True)
def count_colors(
    images: Images,
    cameras: Cameras,
    models: Models,
    bodies: Bodies,
    lines: Lines,
    reach_px: F32,
    colors: F32,
) -> None:
    """Colours (B, 2, 4096) on both sides of every body's contour at its pose.

    Args:
        images, cameras, models, bodies, lines: as in `refine`, after it.
        reach_px: (2,) from where to where along the normal.
        colors: (B, 2, 4096) written.
    """
    for body in prange(bodies.poses.shape[0]):
        colors[body] = np.float32(0.0)
        if not bodies.active[body]:
            continue
        bodies.color_poses[body] = bodies.poses[body]
        add_colors(
            body,
            models.line_counts[body, bodies.views[body]],
            images.color,
            intrinsics(cameras.color),
            bodies.color_poses[body],
            lines,
            reach_px[0],
            reach_px[1],
            colors[body],
        )


@njit(cache=True, nogil=True)
def learn_colors(
    owner: I64, learning: I64, colors: F32, rates: F32, histograms: F32, tables: F32
) -> None:
    """Blend counted colours into the histograms and make the posterior tables anew.

    Args:
        owner: (B,) histogram pair of a body; several bodies may share one.
        learning: (B,) 1 where the body's colours are to be learned.
        colors: (B, 2, 4096) counted colours; changed.
        rates: (2,) learning rates of foreground and background.
        histograms: (pairs, 2, 4096) blended.
        tables: (B, 4096) written.
    """
    n_bodies = owner.shape[0]
    for pair in range(histograms.shape[0]):
        first = -1
        for body in range(n_bodies):
            if owner[body] != pair or learning[body] == 0:
                continue
            if first < 0:
                first = body
            else:
                colors[first] += colors[body]
        if first < 0:
            continue
        for side in range(2):
            blend(histograms[pair, side], colors[first, side], rates[side])
        for body in range(n_bodies):
            if owner[body] == pair:
                posterior_table(histograms[pair, 0], histograms[pair, 1], tables[body])
