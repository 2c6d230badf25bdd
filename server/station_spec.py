"""What a station's worker is told, from its settings."""

from __future__ import annotations

from snapfit.server.clock import Clock
from snapfit.server.logs.setup import chosen_logging
from snapfit.server.pose_store import StoreNames
from snapfit.server.settings import StationSettings
from snapfit.server.worker_spec import WorkerSpec


def station_spec(
    settings: StationSettings, clock: Clock, names: StoreNames, pipeline: str
) -> WorkerSpec:
    """Of no run yet: `boot_id` is empty.

    Args:
        settings: of the station.
        clock: the server's time line.
        names: of the station's pose store.
        pipeline: "module:function" that opens source and tracker.
    """
    return WorkerSpec(
        station=settings.name,
        source=settings.source,
        asset=settings.asset,
        method=settings.method,
        detector=settings.detector,
        providers=settings.providers,
        calibration=settings.calibration,
        record=settings.record,
        record_color=settings.record_color,
        niceness=settings.niceness,
        boot_id="",
        wall_minus_monotonic_ns=clock.wall_minus_monotonic_ns,
        poses_segment=names.poses,
        pictures_segment=names.pictures,
        pipeline=pipeline,
        log_format=chosen_logging().format,
        log_level=chosen_logging().level,
    )
