"""Opens the source and the tracker of a station; the heavy imports are here. Workers only."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from snapfit.models.asset import Asset, find_asset
from snapfit.server.pipeline import Image, Pipeline, Report
from snapfit.server.worker_spec import DEMO_SOURCE, WorkerSpec
from snapfit.tracking.errors import SourceError
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.overlay import draw_overlay
from snapfit.tracking.result import PartEstimate, Status, TrackingResult
from snapfit.tracking.sources.recorded import RecordedSource, load_recording


def open_pipeline(spec: WorkerSpec, report: Report) -> Pipeline:
    """The source and the tracker of a station.

    A recording is played forwards and backwards for ever, so that poses never jump.

    Raises:
        SnapfitError: whatever is refused: the asset, the source, the method.
    """
    asset = None if spec.asset is None else find_asset(spec.asset)
    folder = _demo(asset, report) if spec.source == DEMO_SOURCE else Path(spec.source)
    report("opening the source", None)
    source = RecordedSource(load_recording(folder, asset), loop="pingpong")
    try:
        tracker = create_tracker(
            spec.method, source.parts, source.camera, report, asset=source.asset
        )
    except BaseException:
        source.close()
        raise

    def draw(image: Image, result: TrackingResult) -> Image:
        return draw_overlay(image, source.camera.color, source.parts, result.parts)

    # Once now, so that the first picture does not wait for the compiler.
    blank = np.zeros((source.camera.color.height, source.camera.color.width, 3), dtype=np.uint8)
    poses = source.initial_poses.items()
    draw_overlay(
        blank,
        source.camera.color,
        source.parts,
        [PartEstimate(name, Status.TRACKED, 1.0, pose) for name, pose in poses],
    )
    return Pipeline(source, tracker, draw)


def _demo(asset: Asset | None, report: Report) -> Path:
    from snapfit.models.workbench.demo import demo_sequence  # its renderer is for the demo alone

    if asset is None:
        raise SourceError("the simulated bench needs an asset: set station.asset")
    message = "rendering the simulated bench"
    report(message, None)
    return demo_sequence(asset, lambda share: report(message, share))
