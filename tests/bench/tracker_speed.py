"""Speed of the tracker and of the viewpoint models: python tests/bench/run.py tracking

Medians over frames in which every part moves by 3 mm and 1.5 degrees; 300 lines and 300 points a
part, 6 correspondence x 2 update iterations, measured and modelled occlusion, everything that
`Tracker.track` does; images lie in memory. Beside them, in the same run, a fixed yardstick.
"""

from __future__ import annotations

import statistics
import time

import numpy as np
from bench_scene import CAMERA, Scene, make_scene
from figure import Figure, at_most
from numba import njit

from snapfit.models.asset import find_asset
from snapfit.models.viewpoint_build import build_viewpoint_model
from snapfit.tracking.kernels.region import moments, posterior, segment_probabilities
from snapfit.tracking.methods import create_tracker

BOUNDS_MS = {1: 1.4, 3: 3.5, 7: 7.0}
VIEWPOINT_BOUND_S = 20.0
N_FRAMES = 160
YARDSTICK_SCALES = (9, 7, 5, 2, 2, 2)
YARDSTICK_LINES = 300


def run() -> list[Figure]:
    """All figures; takes about a minute."""
    yardstick = yardstick_ms()
    figures = [Figure("yardstick: 300 lines, six scales, one thread", yardstick, "ms")]
    for n_parts, bound in BOUNDS_MS.items():
        figures += tracking_figures(make_scene(n_parts, 16), n_parts, bound, yardstick)
    return [*figures, *viewpoint_figures()]


def tracking_figures(scene: Scene, n_parts: int, bound_ms: float, yardstick: float) -> list[Figure]:
    """Median and p95 of a frame, the median in yardsticks, and the worst error made."""
    tracker = create_tracker("icg", scene.parts, CAMERA)
    tracker.start(scene.frames[0], scene.poses[0])
    durations, errors_mm = [], []
    for k in range(N_FRAMES):
        result = tracker.track(scene.frames[k % len(scene.frames)])
        durations.append(result.duration_ms)
        truth = scene.poses[k % len(scene.frames)]
        for estimate in result.parts:
            pose = estimate.camera_from_body
            error = float("inf") if pose is None else pose.distance_to(truth[estimate.part]) * 1e3
            errors_mm.append(error)
    median = statistics.median(durations)
    label = f"tracking {n_parts} part{'s' if n_parts > 1 else ''}"
    return [
        at_most(f"{label}, median", median, "ms", bound_ms),
        Figure(f"{label}, p95", float(np.percentile(durations, 95)), "ms"),
        Figure(f"{label}, median in yardsticks", median / yardstick, "x"),
        Figure(f"{label}, median translation error", statistics.median(errors_mm), "mm"),
    ]


def viewpoint_figures() -> list[Figure]:
    """Time to generate the viewpoint model of each clamp part, compilation left out."""
    parts = find_asset("hobby-corner-clamp").tracked_parts
    build_viewpoint_model(parts[0].mesh, n_divisions=1)
    figures = []
    for part in parts:
        begin = time.perf_counter()
        build_viewpoint_model(part.mesh)
        seconds = time.perf_counter() - begin
        figures.append(at_most(f"viewpoint model of {part.name}", seconds, "s", VIEWPOINT_BOUND_S))
    return figures


def yardstick_ms() -> float:
    """Median time of 300 lines over the six scales on one thread: what one part must at least do.

    Segment probabilities, posterior and moments; no projection, no occlusion.
    """
    rng = np.random.default_rng(0)
    color = rng.integers(0, 256, (720, 1280, 3), dtype=np.uint8)
    table = rng.random(4096, dtype=np.float32)
    step = (0.5 - 0.43 * np.tanh(np.arange(8) - 3.5)).astype(np.float32)
    angles = rng.uniform(0, 2 * np.pi, YARDSTICK_LINES)
    places = np.zeros((YARDSTICK_LINES, 8), dtype=np.float32)
    places[:, :2] = rng.uniform((300, 200), (980, 520), (YARDSTICK_LINES, 2))
    places[:, 2], places[:, 3] = np.cos(angles), np.sin(angles)
    durations = []
    for _ in range(60):
        begin = time.perf_counter()
        _yardstick(color, table, np.array(YARDSTICK_SCALES), places, step)
        durations.append((time.perf_counter() - begin) * 1e3)
    return statistics.median(durations[10:])


@njit(nogil=True)
def _yardstick(color, table, scales, places, step):  # type: ignore[no-untyped-def]
    segments = np.empty(64, dtype=np.float32)
    distributions = np.empty((places.shape[0], 12), dtype=np.float32)
    moment = np.empty((places.shape[0], 2), dtype=np.float32)
    for scale in scales:
        for i in range(places.shape[0]):
            if segment_probabilities(color, table, scale, places, i, segments):
                posterior(segments, step, distributions, i)
                moments(distributions, i, np.float32(0.5), moment)
