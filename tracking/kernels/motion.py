"""The motion prior: each structure goes on as it went, a little slower."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from snapfit.tracking.kernels.solve import apply_variation
from snapfit.tracking.kernels.structure import place_child
from snapfit.tracking.kernels.types import F64, U8, Bodies, Structures


@njit(cache=True, nogil=True)
def predict(
    bodies: Bodies,
    structures: Structures,
    before: F64,
    q_before: F64,
    moving: U8,
    damping: float,
    least_turn: float,
    least_way: float,
) -> None:
    """Move roots and joints on by their last motion, damped; children follow their parents.

    Args:
        bodies: poses are moved in place.
        structures: coordinates are moved in place, within their limits.
        before: (B, 4, 4) poses of the frame before the last.
        q_before: (B, 2) coordinates of the frame before the last.
        moving: (B,) 1 where the last motion can be believed.
        damping: share of it that is expected again.
        least_turn, least_way: what moves by less is at rest, rad and m.
    """
    step = np.empty(6)
    for place in range(len(structures.order)):
        body = structures.order[place]
        if bodies.active[body] == 0:
            continue
        if structures.parents[body] >= 0:
            for d in range(structures.n_dof[body] * moving[body]):
                low, high = structures.limits[body, d]
                moved = structures.q[body, d] + damping * (
                    structures.q[body, d] - q_before[body, d]
                )
                structures.q[body, d] = min(max(moved, low), high)
            place_child(body, structures, bodies.poses)
        elif moving[body]:
            relative_motion(before[body], bodies.poses[body], step)
            turn = math.sqrt(step[0] ** 2 + step[1] ** 2 + step[2] ** 2)
            way = math.sqrt(step[3] ** 2 + step[4] ** 2 + step[5] ** 2)
            if turn > least_turn or way > least_way:
                apply_variation(bodies.poses[body], damping * step)


@njit(cache=True, nogil=True)
def relative_motion(before: F64, now: F64, step: F64) -> None:
    """The variation (6,) that takes one pose (4, 4) to the next: rotation vector, translation.

    Expressed in the frame of `now`, so that applying it again goes on in the same direction; for
    turns below a half turn.
    """
    skew = np.zeros(3)
    trace = 0.0
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for r in range(3):
            trace += before[r, i] * now[r, i]
            skew[i] += before[r, k] * now[r, j] - before[r, j] * now[r, k]
    sine = 0.5 * math.sqrt(skew[0] ** 2 + skew[1] ** 2 + skew[2] ** 2)
    angle = math.atan2(sine, 0.5 * (trace - 1.0))
    factor = 0.5 * angle / sine if sine > 1e-9 else 0.5
    for i in range(3):
        step[i] = factor * skew[i]
        step[3 + i] = (
            now[0, i] * (now[0, 3] - before[0, 3])
            + now[1, i] * (now[1, 3] - before[1, 3])
            + now[2, i] * (now[2, 3] - before[2, 3])
        )
