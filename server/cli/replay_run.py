"""What `snapfit replay` does: opens, tracks again, compares, sums up."""

from __future__ import annotations

import math
from contextlib import ExitStack, closing
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from snapfit.models.asset import Asset, find_asset
from snapfit.server.cli.track_run import open_lines, progress_bar
from snapfit.server.cli.video import VideoFile
from snapfit.tracking.offline import result_lines
from snapfit.tracking.overlay import draw_overlay
from snapfit.tracking.recording.build import build_here, differences
from snapfit.tracking.recording.comparison import Comparison
from snapfit.tracking.recording.reading import OpenRecording
from snapfit.tracking.recording.replay import Replay


def run(recording: Path, *, asset: str | None, out: Path | None, video: Path | None) -> bool:
    """Tracks a recording again, from its first frame to its last.

    Returns:
        False where poses differ that had to be the same.

    Raises:
        SnapfitError: of any room; the command line shows it as one line.
    """
    console = Console(highlight=False)
    given = None if asset is None else find_asset(asset)
    with ExitStack() as stack:
        opened = stack.enter_context(closing(OpenRecording(recording)))
        if opened.problem is not None:
            told = f"[yellow]note[/yellow] {recording} {opened.problem}"
            console.print(told, soft_wrap=True)
        lines = stack.enter_context(open_lines(out)) if out else None
        film = None
        color = opened.camera.color
        if video:
            size_px = (color.width, color.height)
            film = VideoFile(video, opened.station.frame_rate_hz, size_px)
            stack.enter_context(closing(film))
        progress = stack.enter_context(progress_bar(console))
        replayed = _made(opened, given, progress)
        comparison = Comparison()
        task = progress.add_task("replaying", total=len(opened.results))
        for each in replayed.run():
            comparison.add(each)
            if each.result is not None and lines is not None:
                lines.writelines(line + "\n" for line in result_lines(each.result))
            if film is not None and each.frame is not None:
                parts = each.result.parts if each.result else ()
                film.add(draw_overlay(each.frame.color, color, replayed.parts, parts))
            progress.advance(task)
    return _tell(console, opened, comparison)


def _made(opened: OpenRecording, asset: Asset | None, progress: Progress) -> Replay:
    task = progress.add_task("preparing", total=1.0)

    def show(message: str, share: float) -> None:
        progress.update(task, description=message, completed=share)

    made = Replay(opened, asset, show)
    progress.remove_task(task)
    return made


def _tell(console: Console, opened: OpenRecording, comparison: Comparison) -> bool:
    """The outcome in a few lines; False where it is not what had to be."""
    station = opened.station
    console.print(
        f"{comparison.frames} frames of {station.station} with {station.method}, "
        f"{comparison.poses} poses: " + _outcome(comparison),
        soft_wrap=True,
    )
    for problem in comparison.problems[:5]:
        console.print(f"  {problem}", soft_wrap=True)
    if comparison.is_identical:
        return True
    reasons = _reasons(opened, comparison)
    for reason in reasons:
        console.print(f"  to be expected: {reason}", soft_wrap=True)
    return bool(reasons)


def _outcome(comparison: Comparison) -> str:
    if comparison.is_identical:
        return "all the same, bit for bit"
    millimetres = 1e3 * comparison.largest_m
    degrees = math.degrees(comparison.largest_rad)
    return (
        f"{comparison.different} differ, the first in frame {comparison.first_different}, "
        f"by up to {millimetres:.3g} mm and {degrees:.3g} degrees"
    )


def _reasons(opened: OpenRecording, comparison: Comparison) -> list[str]:
    """Why poses may differ; none where they had to be the same."""
    reasons = differences(opened.station.build, build_here())
    if opened.station.color_format == "jpeg":
        reasons.append("colour was recorded as JPEG, which does not keep every pixel")
    if comparison.unrecorded:
        reasons.append(f"{comparison.unrecorded} frames were not recorded in time")
    return reasons
