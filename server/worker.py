"""The capture-and-track worker: a process of its own, `python -m snapfit.server.worker`.

Its standard input gives it a `WorkerSpec` (one line of JSON); when that pipe closes, because the
server wants it to end or is gone, the worker ends.
"""

from __future__ import annotations

import importlib
import logging
import os
import sys
import threading
import time

from snapfit.models.errors import SnapfitError
from snapfit.server.clock import Clock
from snapfit.server.logs.setup import LogChoice, configure_logging
from snapfit.server.pose_store import PoseStore, StoreNames
from snapfit.server.reporter import Reporter
from snapfit.server.schemas import Phase
from snapfit.server.tracking_loop import TrackingLoop
from snapfit.server.worker_spec import REFUSED_EXIT_CODE, WorkerSpec

_GRACE_S = 1.0
_COMPLETION_S = 5.0  # less than the server waits before it kills
_SWITCH_INTERVAL_S = 0.0005  # so that encoding pictures never holds up the tracking thread
_LOG = logging.getLogger(__name__)


def main() -> int:
    """Run until standard input closes; the exit code."""
    configure_logging(LogChoice())  # until the server tells how
    sys.setswitchinterval(_SWITCH_INTERVAL_S)
    spec = WorkerSpec.model_validate_json(_read_line())
    choice = LogChoice(spec.log_format, spec.log_level)
    configure_logging(choice, station=spec.station, boot_id=spec.boot_id)
    if sys.platform != "win32":
        os.nice(spec.niceness)
    stop, records = threading.Event(), threading.Event()
    threading.Thread(target=_wait_for_end, args=(stop, records), daemon=True).start()
    names = StoreNames(spec.poses_segment, spec.pictures_segment)
    store = PoseStore.attach(names, spec.doorbell)
    reporter = Reporter(store, spec.boot_id)
    try:
        _run(spec, store, reporter, stop, records)
    except SnapfitError as error:
        reporter.report(Phase.FAILED, str(error))
        _LOG.error("station %s: %s", spec.station, error)
        return REFUSED_EXIT_CODE
    finally:
        store.close()
    return 0


def _run(
    spec: WorkerSpec,
    store: PoseStore,
    reporter: Reporter,
    stop: threading.Event,
    records: threading.Event,
) -> None:
    reporter.report(Phase.STARTING, "loading the tracker")
    module, _, function = spec.pipeline.partition(":")
    open_pipeline = getattr(importlib.import_module(module), function)
    pipeline = open_pipeline(
        spec, lambda text, share=None: reporter.report(Phase.STARTING, text, share)
    )
    if pipeline.recording is not None:
        records.set()
    clock = Clock(spec.wall_minus_monotonic_ns)
    try:
        TrackingLoop(spec, pipeline, store, reporter, clock).run(stop)
    finally:
        pipeline.close()


def _read_line() -> bytes:
    """One line of standard input, unbuffered, so that nothing else has a lock on it at the end."""
    line = b""
    while not line.endswith(b"\n"):
        piece = os.read(0, 1)
        if not piece:
            break
        line += piece
    return line


def _wait_for_end(stop: threading.Event, records: threading.Event) -> None:
    while os.read(0, 1024):
        pass
    stop.set()
    # Only a recording is to be completed; nothing that compiles or renders needs an orderly end.
    time.sleep(_COMPLETION_S if records.is_set() else _GRACE_S)
    os._exit(0)


if __name__ == "__main__":
    sys.exit(main())
