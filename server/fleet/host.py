"""Runs stations that other machines serve: workers, no API."""

from __future__ import annotations

import logging
import signal
import threading
from collections.abc import Callable
from types import FrameType

from snapfit.server.clock import Clock
from snapfit.server.errors import WorkerRefusedError
from snapfit.server.fleet.keepers import publish_at
from snapfit.server.logs.setup import LogChoice, configure_logging
from snapfit.server.settings import Settings
from snapfit.server.stations import Stations
from snapfit.server.worker_spec import DEFAULT_PIPELINE

_LOOK_S = 0.1
_LOG = logging.getLogger(__name__)


def run_workers(
    settings: Settings, say: Callable[[str], None], pipeline: str = DEFAULT_PIPELINE
) -> None:
    """Track and publish until SIGINT or SIGTERM.

    Args:
        settings: stations and store.
        say: told what each station is doing, whenever that changes.
        pipeline: "module:function" that opens source and tracker in the workers.

    Raises:
        StoreError: the store's address cannot be understood.
        WorkerRefusedError: a worker was refused by a file or a setting.
    """
    configure_logging(LogChoice(settings.log_format, settings.log_level))
    stop = threading.Event()

    def end(_number: int, _frame: FrameType | None) -> None:
        stop.set()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, end)
    back = publish_at(settings.store)
    clock = Clock.started_now()
    stations = Stations(list(settings.all_stations), clock, pipeline, back)
    try:
        stations.open()
        _watch(stations, say, stop)
    finally:
        stations.close()


def _watch(stations: Stations, say: Callable[[str], None], stop: threading.Event) -> None:
    said: dict[str, str] = {}
    while not stop.wait(_LOOK_S):
        for station in stations:
            message = station.info().worker.message
            if station.is_refused:
                raise WorkerRefusedError(f"station {station.name}: {message}")
            if said.get(station.name) != message:
                said[station.name] = message
                say(f"{station.name}: {message}")
