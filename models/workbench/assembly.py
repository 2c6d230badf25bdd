"""The assembly of any asset in a given number of frames, at the speed of a quick hand.

Parts lie on the bench at first. Step by step one is taken, looked at from all sides, brought
before its place and put in along a straight line, turned in where its joint turns.
"""

from __future__ import annotations

import math

import numpy as np

from snapfit.models.asset import Asset
from snapfit.models.workbench.choreography import Bodies, Choreographer, Pace
from snapfit.models.workbench.layout import laid_out
from snapfit.models.workbench.mounting import plan_mounts
from snapfit.models.workbench.scene import Scene
from snapfit.models.workbench.script import Script
from snapfit.models.workbench.speed import Speed, speed_of

_MEDIAN_MM, _MEDIAN_DEG = 3.0, 1.5
_CALIBRATIONS, _CLOSE_ENOUGH = 8, 0.02


def timed_assembly(asset: Asset, scene: Scene, n_frames: int, seed: int) -> Script:
    """The assembly of an asset from its first frame to its last.

    The pace is chosen so that a part that is moved goes at 3 mm and 1.5 degrees a frame in the
    median, as near as it can be had.

    Args:
        asset: with an assembly graph.
        scene: on which it lies.
        n_frames: at 30 a second.
        seed: of the places, the ways and the tremor.

    Raises:
        WorkbenchError: no assembly graph, or the parts do not fit on the bench.
    """
    plan = plan_mounts(asset)
    initial = laid_out(asset, scene, plan, np.random.default_rng((seed, 0)))
    first = asset.states[0].name
    bodies = Bodies.of({part.name: part.mesh for part in asset.parts})
    tracked = frozenset(part.name for part in asset.tracked_parts)
    pace, best, best_cost = Pace(), None, math.inf
    for _ in range(_CALIBRATIONS):
        script = Choreographer(first, tracked, bodies, initial, plan, pace, seed).play(n_frames)
        speed = speed_of(script, n_frames, tracked)
        off_mm, off_deg = _ratios(speed)
        cost = abs(math.log(off_mm)) + abs(math.log(off_deg))
        if cost < best_cost:
            best, best_cost = script, cost
        if cost < _CLOSE_ENOUGH:
            break
        pace = Pace(
            float(np.clip(pace.step_m / off_mm, 0.001, 0.008)),
            float(np.clip(pace.turn_rad / off_deg, 0.005, 0.08)),
        )
    return best or script


def _ratios(speed: Speed) -> tuple[float, float]:
    return max(speed.median_mm / _MEDIAN_MM, 0.1), max(speed.median_deg / _MEDIAN_DEG, 0.1)
