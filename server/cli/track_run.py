"""What `snapfit track` does: opens, tracks, writes, sums up."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Sequence
from contextlib import ExitStack, closing
from pathlib import Path
from typing import NamedTuple, TextIO

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from snapfit.server.cli.video import VideoFile
from snapfit.tracking.benchmark.roster import starts_cold
from snapfit.tracking.errors import FrameError, SourceError
from snapfit.tracking.evaluation import LEAST_VISIBILITY, PartEvaluation
from snapfit.tracking.finding.create import create_offline
from snapfit.tracking.frame import Frame
from snapfit.tracking.method import MethodTracker
from snapfit.tracking.methods import create_tracker
from snapfit.tracking.offline import result_lines, track_source
from snapfit.tracking.overlay import draw_overlay
from snapfit.tracking.result import TrackingResult
from snapfit.tracking.sources import RecordedSource, open_source
from snapfit.tracking.sources.bad_frames import BadFrames


class Finding(NamedTuple):
    """What finds the parts: a detector, None for the recording's first poses, and what runs it."""

    detector: str | None
    providers: tuple[str, ...]


def run(
    sequence: Path,
    *,
    asset: str | None,
    method: str,
    finding: Finding,
    out: Path | None,
    video: Path | None,
) -> None:
    """Tracks one recording from its first frame to its last.

    Raises:
        SnapfitError: of any room; the command line shows it as one line.
    """
    console = Console(highlight=False)
    with ExitStack() as stack:
        source = stack.enter_context(closing(open_source(sequence, asset)))
        lines = stack.enter_context(open_lines(out)) if out else None
        film = None
        if video:
            camera = source.camera.color
            size_px = (camera.width, camera.height)
            film = stack.enter_context(closing(VideoFile(video, source.frame_rate_hz, size_px)))
        progress = stack.enter_context(progress_bar(console))
        bad_frames = BadFrames(lambda error: _tell(progress.console, error))
        tracker = _make_tracker(method, finding, source, progress)
        finds_parts = finding.detector is not None or starts_cold(method)
        tracked = track_source(source, tracker, bad_frames, finds_parts=finds_parts)
        evaluations, times_ms = _track(source, tracked, bad_frames, lines, film, progress)
    console.print(_summary(evaluations))
    console.print(_closing_line(len(times_ms), bad_frames.count, times_ms, evaluations))


def _track(
    source: RecordedSource,
    tracked: Iterable[tuple[Frame, TrackingResult]],
    bad_frames: BadFrames,
    lines: TextIO | None,
    film: VideoFile | None,
    progress: Progress,
) -> tuple[list[PartEvaluation], list[float]]:
    evaluations = {part.name: PartEvaluation(part) for part in source.parts}
    times_ms = []
    task = progress.add_task("tracking", total=len(source.recording.frames))
    for frame, result in tracked:
        times_ms.append(result.duration_ms)
        truth = source.truth.get(frame.name)
        for estimate in result.parts:
            evaluations[estimate.part].add(estimate, truth)
        if lines is not None:
            lines.writelines(line + "\n" for line in result_lines(result))
        if film is not None:
            film.add(draw_overlay(frame.color, source.camera.color, source.parts, result.parts))
        progress.update(task, completed=len(times_ms) + bad_frames.count)
    return list(evaluations.values()), times_ms


def _make_tracker(
    method: str, finding: Finding, source: RecordedSource, progress: Progress
) -> MethodTracker:
    task = progress.add_task("preparing", total=1.0)

    def show(message: str, share: float) -> None:
        progress.update(task, description=message, completed=share)

    camera = source.camera
    tracker: MethodTracker
    detector, providers = finding
    if detector is None:
        rate_hz = source.frame_rate_hz
        tracker = create_tracker(
            method, source.parts, camera, show, asset=source.asset, frame_rate_hz=rate_hz
        )
    elif source.asset is None:
        raise SourceError(f"{source.name}: a detector needs an asset: name it with --asset")
    else:
        rate_hz = source.frame_rate_hz
        tracker = create_offline(
            method, detector, source.parts, camera, source.asset, rate_hz, show, providers
        )
    progress.remove_task(task)
    return tracker


def open_lines(path: Path) -> TextIO:
    """A file for lines of JSON.

    Raises:
        SourceError: it cannot be written.
    """
    try:
        return path.open("w", encoding="utf-8")
    except OSError as error:
        raise SourceError(f"{path}: cannot be written: {error.strerror}") from error


def progress_bar(console: Console) -> Progress:
    """How far it is, while it goes on."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    return Progress(*columns, console=console, transient=True)


def _tell(console: Console, error: FrameError) -> None:
    console.print(f"[yellow]skipped[/yellow] {error}", soft_wrap=True)


def _summary(evaluations: Sequence[PartEvaluation]) -> Table:
    judged = any(evaluation.n_judged for evaluation in evaluations)
    table = Table("part", "frames", "tracked", "lost", "confidence")
    if judged:
        for title in ("judged", "mm", "p95", "deg", "p95", "ADD(-S) mm", "below 10 % dia."):
            table.add_column(title, justify="right")
        table.caption = (
            f"Errors: median and 95th percentile over frames in which at least "
            f"{LEAST_VISIBILITY:.0%} of the part is visible, symmetry taken out; "
            "no pose counts as infinite"
        )
    for evaluation in evaluations:
        cells = [
            evaluation.part.name,
            str(evaluation.n_frames),
            str(evaluation.n_tracked),
            str(evaluation.n_lost),
            _number(evaluation.confidence, 2),
        ]
        table.add_row(*cells, *(_error_cells(evaluation) if judged else []))
    return table


def _error_cells(evaluation: PartEvaluation) -> list[str]:
    return [
        str(evaluation.n_judged),
        _number(1000 * evaluation.translation_m(0.5), 2),
        _number(1000 * evaluation.translation_m(0.95), 2),
        _number(math.degrees(evaluation.rotation_rad(0.5)), 2),
        _number(math.degrees(evaluation.rotation_rad(0.95)), 2),
        _number(1000 * evaluation.add_m(0.5), 2),
        _number(100 * evaluation.add_recall, 1) + " %",
    ]


def _number(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def _closing_line(
    n_frames: int, n_bad: int, times_ms: Sequence[float], evaluations: Sequence[PartEvaluation]
) -> str:
    parts = "part" if len(evaluations) == 1 else "parts"
    bad = f", {n_bad} bad skipped" if n_bad else ""
    median_ms = statistics.median(times_ms) if times_ms else math.nan
    return (
        f"{n_frames} frames{bad}; {_number(median_ms, 2)} ms a frame (median) "
        f"for {len(evaluations)} {parts}"
    )
