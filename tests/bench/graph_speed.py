"""Speed of the method `gbot`: python tests/bench/run.py graph

Eight parts of the Nano Chuck through a rendered assembly, with the graph, the trials of linked
parts and the search for lost ones; then the cost of 1 to 50 free parts, and the memory. Images lie
in memory; times are those of `Tracker.track`.
"""

from __future__ import annotations

import statistics
import tempfile
from pathlib import Path

import numpy as np
from bench_scene import CAMERA, make_scene
from figure import Figure, at_most
from tracker_memory import memory_mb

from snapfit.models.asset import find_asset
from snapfit.models.pose import Pose
from snapfit.models.workbench.film import Film, FilmFrame
from snapfit.models.workbench.split import TEST_FRAMES, TEST_SEED, Condition
from snapfit.tracking.body import load_bodies
from snapfit.tracking.frame import Frame
from snapfit.tracking.methods import METHODS, create_tracker
from snapfit.tracking.tracker import Tracker

ASSET = "nano-chuck"
EVERY_MS, P95_MS, MEMORY_MB = 8.0, 11.0, 500.0
# Around two switches and in between, part by part: 4 stretches of the film.
STRETCHES = ((0, 60), (180, 240), (440, 500), (700, 760))
COUNTS = (1, 2, 4, 8, 16, 32, 50)
N_FRAMES = 48


def run() -> list[Figure]:
    """All figures; takes about two minutes."""
    durations = np.concatenate([_through(Condition.NORMAL, first, end) for first, end in STRETCHES])
    hidden = _through(Condition.HAND, 180, 260)
    medians = {n: _free_parts_ms(n) for n in COUNTS}
    slope = (medians[50] - medians[8]) / (50 - 8)
    return [
        at_most("gbot, 8 parts, median", float(np.median(durations)), "ms", EVERY_MS),
        at_most("gbot, 8 parts, p95", float(np.percentile(durations, 95)), "ms", P95_MS),
        Figure("gbot, 8 parts with a hand, median", float(np.median(hidden)), "ms"),
        Figure("gbot, 8 parts with a hand, p95", float(np.percentile(hidden, 95)), "ms"),
        *(Figure(f"gbot, {n} free parts, median", ms, "ms") for n, ms in medians.items()),
        Figure("a part more, from 8 to 50", slope, "ms"),
        at_most("gbot, 8 parts, memory of a process", _memory_mb(180, 240), "MB", MEMORY_MB),
    ]


def _through(condition: Condition, first: int, end: int) -> np.ndarray:
    """Milliseconds of each frame of a stretch of the film, from its true poses on."""
    asset = find_asset(ASSET)
    film = Film(asset, TEST_FRAMES[ASSET], 100 * TEST_SEED)
    tracker = create_tracker("gbot", asset.tracked_parts, film.camera, asset=asset)
    times = []
    for index in range(first, end):
        shown = film.frame(index, condition)
        frame = _as_frame(shown, index)
        if index == first:
            tracker.start(frame, _poses(shown))
            tracker.set_state(shown.state)
        times.append(tracker.track(frame).duration_ms)
    return np.array(times[2:])


def _memory_mb(first: int, end: int) -> float:
    """Most memory of a process that tracks through a stretch of the film and renders nothing."""
    film = Film(find_asset(ASSET), TEST_FRAMES[ASSET], 100 * TEST_SEED)
    shown = [film.frame(index, Condition.NORMAL) for index in range(first, end)]
    frames = [_as_frame(each, index) for index, each in enumerate(shown)]
    with tempfile.TemporaryDirectory() as directory:
        return memory_mb(Path(directory), ASSET, frames, _poses(shown[0]), shown[0].state)


def _as_frame(shown: FilmFrame, index: int) -> Frame:
    return Frame(str(index), index * 33_333_333, shown.color, shown.depth)


def _poses(shown: FilmFrame) -> dict[str, Pose]:
    return {name: each.camera_from_body for name, each in shown.sightings.items()}


def _free_parts_ms(n_parts: int) -> float:
    """Median of a frame of so many free parts, by the parameters of `gbot`."""
    scene = make_scene(n_parts, 16)
    tracker = Tracker(load_bodies(scene.parts), CAMERA, METHODS["gbot-without-graph"].parameters)
    tracker.start(scene.frames[0], scene.poses[0])
    return statistics.median(
        tracker.track(scene.frames[k % len(scene.frames)]).duration_ms for k in range(N_FRAMES)
    )
