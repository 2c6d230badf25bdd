"""Compiles what the tests need of Numba's kernels, once, beside the first of them.

Each of pytest's processes, and each worker of a server that they start, would otherwise compile
the same kernels at the same time: minutes of both cores. What is compiled is kept in the cache.
It follows the simulated bench until every part is tracked: the tracker's kernels have run then.
"""

from __future__ import annotations

import time

from snapfit.server.open_pipeline import open_pipeline
from snapfit.server.worker_spec import WorkerSpec
from snapfit.tracking.result import Status

MOST_FRAMES = 300


def main() -> None:
    spec = WorkerSpec(
        station="bench",
        source="demo",
        asset="hobby-corner-clamp",
        method="gbot",
        boot_id="",
        wall_minus_monotonic_ns=0,
        poses_segment="",
        pictures_segment="",
        detector="auto",
    )
    pipeline = open_pipeline(spec, lambda _text, _share: None)
    for _ in range(MOST_FRAMES):
        frame = pipeline.source.read()
        result = None if frame is None else pipeline.tracker.track(frame)
        if result is None or all(part.status is Status.TRACKED for part in result.parts):
            break
        time.sleep(1 / 30)  # as a camera: the parts are found beside
    pipeline.close()


if __name__ == "__main__":
    main()
