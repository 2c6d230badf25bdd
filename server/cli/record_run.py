"""What `snapfit record` does: opens a source, writes its frames down, sums up."""

from __future__ import annotations

import time
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from snapfit.models.asset import find_asset
from snapfit.server.clock import Clock
from snapfit.server.worker_spec import ColorFormat
from snapfit.tracking.errors import FrameError, RecordingError
from snapfit.tracking.recording.recorder import Recorder
from snapfit.tracking.recording.station import loose_meshes, station_record
from snapfit.tracking.sources import open_any
from snapfit.tracking.sources.bad_frames import BadFrames
from snapfit.tracking.sources.base import Source, is_live

_CLOSE_LIMIT_S = 60.0


def run(
    source: str,
    out: Path,
    *,
    asset: str | None,
    calibration: Path | None,
    seconds: float | None,
    color: ColorFormat,
) -> None:
    """Records a source until its end, for so long, or until Ctrl-C.

    Raises:
        SnapfitError: of any room; the command line shows it as one line.
    """
    console = Console(highlight=False)
    given = None if asset is None else find_asset(asset)
    with closing(open_any(source, given, "no", calibration)) as opened:
        station = station_record(
            opened, station=out.stem, method=None, detector=None, finds=(), color_format=color
        )
        recorder = Recorder.begin(out, station, loose_meshes(opened), time.time_ns())
        bad_frames = BadFrames(lambda error: console.print(f"[yellow]skipped[/yellow] {error}"))
        try:
            with suppress(KeyboardInterrupt):
                _record(opened, recorder, bad_frames, seconds, console)
        finally:
            recorder.close(_CLOSE_LIMIT_S)
    account = recorder.account
    bad = f", {bad_frames.count} bad skipped" if bad_frames.count else ""
    console.print(
        f"{account.frames} frames{bad}, {account.dropped} dropped, "
        f"{account.n_bytes / 1e6:.1f} MB in {out}",
        soft_wrap=True,
    )
    if account.problem is not None:
        raise RecordingError(out, account.problem)


def _record(
    source: Source,
    recorder: Recorder,
    bad_frames: BadFrames,
    seconds: float | None,
    console: Console,
) -> None:
    begin_s, live, clock = time.monotonic(), is_live(source), Clock.started_now()
    period_s = 0.0 if live else 1.0 / source.frame_rate_hz
    columns = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("recording; Ctrl-C ends it")
        for number in range(2**63):
            elapsed_s = time.monotonic() - begin_s
            if recorder.account.problem or (seconds is not None and elapsed_s >= seconds):
                return
            # A recording is played at its own rate: nothing of it is to be dropped.
            time.sleep(max(0.0, number * period_s - elapsed_s))
            try:
                frame = source.read()
            except FrameError as error:
                bad_frames.add(error)
                continue
            if frame is None:
                return
            at_ns = frame.captured_at_ns + (clock.wall_minus_monotonic_ns if live else 0)
            named = replace(frame, name=f"{number:06d}", captured_at_ns=at_ns)
            recorder.add(named, [], {})
            told = f"{recorder.account.frames} frames; Ctrl-C ends it"
            progress.update(task, description=told)
