"""What a detector beside the tracker costs its frames: make bench, suite `detector`.

Seven moving parts at 30 frames a second, in turns with the detector looking all the time, as it
does while parts are searched for, and without it; with the kernel threads that a worker uses.
"""

from __future__ import annotations

import statistics
import time

from bench_scene import CAMERA, Scene, make_scene
from figure import Figure, at_most

from snapfit.models.asset import find_asset
from snapfit.models.detector.card import ONNX_NAME
from snapfit.tracking.detection.detector import Detector
from snapfit.tracking.detection.parameters import DetectorParameters, RangeParameters
from snapfit.tracking.finding.lookout import Lookout, LookoutThread
from snapfit.tracking.kernel_threads import KernelThreads
from snapfit.tracking.methods import MethodTracker, create_tracker

MOST_RISE_PERCENT = 15.0
N_TURNS, N_FRAMES, PERIOD_S = 6, 45, 1 / 30


def run() -> list[Figure]:
    """The rise of the median; nothing where the clamp has no network."""
    clamp = find_asset("hobby-corner-clamp")
    if not (clamp.directory / ONNX_NAME).is_file():
        return [Figure("detection beside tracking: not measured, no network", float("nan"), "")]
    settings = DetectorParameters(range=RangeParameters(), threads=1)
    detector = Detector(clamp.directory, clamp.tracked_parts, CAMERA, settings)
    scene = make_scene(7, 16)
    tracker = create_tracker("icg", scene.parts, CAMERA)
    tracker.start(scene.frames[0], scene.poses[0])
    threads = KernelThreads(1e3 * PERIOD_S)
    lookout = LookoutThread(detector)
    alone: list[float] = []
    beside: list[float] = []
    for _ in range(N_TURNS):
        alone += _turn(tracker, scene, threads, None)
        beside += _turn(tracker, scene, threads, lookout)
    lookout.close()
    first, second = statistics.median(alone), statistics.median(beside)
    rise = 100 * (second / first - 1)
    return [
        Figure("tracking 7 parts at 30 Hz, median", first, "ms"),
        Figure("the same while a detector looks all the time", second, "ms"),
        at_most("rise of the median by detection beside it", rise, "%", MOST_RISE_PERCENT),
        Figure("looks meanwhile", float(lookout.account.looks), ""),
    ]


def _turn(
    tracker: MethodTracker, scene: Scene, threads: KernelThreads, lookout: Lookout | None
) -> list[float]:
    """Milliseconds of each frame of a turn."""
    times = []
    due_s = time.perf_counter()
    for k in range(N_FRAMES):
        due_s += PERIOD_S
        frame = scene.frames[k % len(scene.frames)]
        if lookout is not None:
            lookout.take()
            lookout.offer(frame, lookout.names)
        times.append(tracker.track(frame).duration_ms)
        threads.tracked(times[-1])
        time.sleep(max(0.0, due_s - time.perf_counter()))
    return times[3:]
