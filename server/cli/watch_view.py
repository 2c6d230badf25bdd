"""What `snapfit watch` shows: parts, assembly, events, and how fresh they are."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from snapfit.clients.python import (
    AssemblySummary,
    ClientError,
    Event,
    PartPose,
    PoseSnapshot,
    StationEvent,
    Status,
)

_EVENTS = 6
_RATE_OVER_S = 2.0
_BAR_CELLS = 8
_NONE = "-"
_STYLES = {
    Status.TRACKED: "green",
    Status.INFERRED: "cyan",
    Status.PREDICTED: "yellow",
    Status.SEARCHING: "magenta",
    Status.LOST: "red",
}


class Watched:
    """What is known of a station by now.

    Args:
        url: the server's address.
    """

    def __init__(self, url: str) -> None:
        self.url = url
        self.snapshot: PoseSnapshot | None = None
        self.trouble = ""
        self.events: deque[Event] = deque(maxlen=_EVENTS)
        self._came_at_s = 0.0
        self._recent: deque[PoseSnapshot] = deque()

    def take(self, snapshot: PoseSnapshot) -> None:
        """Another snapshot."""
        self.snapshot, self._came_at_s = snapshot, time.monotonic()
        if snapshot.stale:
            return
        self.trouble = ""
        if self._recent and self._recent[-1].boot_id != snapshot.boot_id:
            self._recent.clear()
        self._recent.append(snapshot)
        while snapshot.captured_at_us - self._recent[0].captured_at_us > 1e6 * _RATE_OVER_S:
            self._recent.popleft()

    def fail(self, error: ClientError, wait_s: float) -> None:
        """The connection was lost; it is tried again after a wait."""
        self.trouble = f"{error} Trying again in {wait_s:.1f} s."

    def happened(self, event: Event) -> None:
        """Another event."""
        self.events.append(event)

    @property
    def age_s(self) -> float:
        """How old the snapshot is by now."""
        told_s = 0.0 if self.snapshot is None else self.snapshot.age_us / 1e6
        return told_s + time.monotonic() - self._came_at_s

    @property
    def rate_hz(self) -> float | None:
        """Frames a second that the station publishes; None until there are two."""
        if len(self._recent) < 2 or self.snapshot is None or self.snapshot.stale:
            return None
        first, last = self._recent[0], self._recent[-1]
        passed_s = (last.captured_at_us - first.captured_at_us) / 1e6
        return (last.seq - first.seq) / passed_s if passed_s > 0 else None


def view(watched: Watched, *, with_events: bool = True) -> RenderableType:
    """All of it, for a terminal."""
    snapshot = watched.snapshot
    if snapshot is None:
        return Text(watched.trouble or f"waiting for poses from {watched.url}", style="yellow")
    shown: list[RenderableType] = [_headline(watched, snapshot), _parts(watched, snapshot)]
    if snapshot.assembly is not None:
        shown.append(_assembly(snapshot.assembly))
    if with_events:
        shown += [Text(_told(event), style="dim") for event in watched.events]
    if watched.trouble:
        shown.append(Text(watched.trouble, style="yellow"))
    return Group(*shown)


def line(watched: Watched) -> str:
    """The same in a line, for a pipe."""
    clock = time.strftime("%H:%M:%S")
    snapshot = watched.snapshot
    if snapshot is None or watched.trouble:
        return f"{clock} {watched.trouble or 'waiting for poses'}"
    parts = "; ".join(_in_words(part) for part in snapshot.parts)
    state = "" if snapshot.assembly is None else f"; state {snapshot.assembly.state}"
    return f"{clock} {_freshness(watched, snapshot)}; {parts}{state}"


def _headline(watched: Watched, snapshot: PoseSnapshot) -> Text:
    mark = ("\u25cf ", "red" if snapshot.stale else "green")
    name = (f"{snapshot.station}", "bold")
    asset = "" if snapshot.asset is None else f"  {snapshot.asset}"
    where = f"  {snapshot.convention} in {snapshot.frame}"
    return Text.assemble(mark, name, asset, (where, "dim"), f"  {_freshness(watched, snapshot)}")


def _freshness(watched: Watched, snapshot: PoseSnapshot) -> str:
    rate = "" if watched.rate_hz is None else f"{watched.rate_hz:.1f} frames/s, "
    fresh = "stale" if snapshot.stale else "fresh"
    age = f"{watched.age_s:.1f} s" if watched.age_s >= 1 else f"{1000 * watched.age_s:.0f} ms"
    return f"{fresh}, {rate}age {age}, seq {snapshot.seq} of {snapshot.boot_id}"


def _parts(watched: Watched, snapshot: PoseSnapshot) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim")
    table.add_column("part")
    table.add_column("status")
    table.add_column("confidence")
    table.add_column("position, mm", justify="right", no_wrap=True)
    table.add_column("rotation, deg", justify="right", no_wrap=True)
    table.add_column("mm/s", justify="right")
    table.add_column("deg/s", justify="right")
    table.add_column("seen", justify="right")
    table.add_column("on")
    now_us = snapshot.captured_at_us + watched.age_s * 1e6
    for part in snapshot.parts:
        style = "dim" if snapshot.stale else _STYLES[part.status]
        table.add_row(
            part.part,
            Text(part.status, style=style),
            Text.assemble((_bar(part.confidence), style), f" {part.confidence:.2f}"),
            _NONE if part.position is None else _numbers([1000 * x for x in part.position]),
            _NONE if part.orientation is None else _numbers(rotation_vector_deg(part.orientation)),
            _length(part.linear_velocity, 1000),
            _length(part.angular_velocity, math.degrees(1)),
            _ago(part.last_seen_at_us, now_us),
            part.linked_to or "",
        )
    return table


def _assembly(assembly: AssemblySummary) -> Text:
    text = Text.assemble(
        "state ", (assembly.state, "bold"), f" {assembly.confidence:.2f} by {assembly.decided_by}"
    )
    if assembly.finished_steps:
        text.append("  done ").append(", ".join(assembly.finished_steps), "green")
    if assembly.next_steps:
        text.append("  next ").append(", ".join(assembly.next_steps), "cyan")
    for wrong in assembly.misassemblies:
        kind = wrong.kind.replace("_", " ")
        text.append(f"  {wrong.part} on {wrong.parent}: {kind}", "bold red")
    return text


def _told(event: Event) -> str:
    header = set(StationEvent.model_fields)
    told = [
        f"{value:.3g}" if isinstance(value, float) else str(value)
        for name, value in event.model_dump(mode="json").items()
        if name not in header and value is not None
    ]
    at_us = event.at_us if isinstance(event, StationEvent) else time.time_ns() // 1000
    clock = time.strftime("%H:%M:%S", time.localtime(at_us / 1e6))
    return f"{clock} {event.event} {' '.join(told)}"


def _in_words(part: PartPose) -> str:
    where = "" if part.position is None else f" {_numbers([1000 * x for x in part.position])} mm"
    return f"{part.part} {part.status} {part.confidence:.2f}{where}"


def rotation_vector_deg(orientation: Sequence[float]) -> list[float]:
    """Axis times angle (3,), degrees, of a unit quaternion x, y, z, w."""
    x, y, z, w = orientation if orientation[3] >= 0 else [-each for each in orientation]
    sine = math.hypot(x, y, z)
    scale = math.degrees(2 * math.atan2(sine, w)) / sine if sine > 0 else 0.0
    return [scale * x, scale * y, scale * z]


def _bar(share: float) -> str:
    full = round(share * _BAR_CELLS)
    return "\u2588" * full + "\u2591" * (_BAR_CELLS - full)


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{value:7.1f}" for value in values)


def _length(vector: Sequence[float] | None, scale: float) -> str:
    return _NONE if vector is None else f"{scale * math.hypot(*vector):.0f}"


def _ago(at_us: int | None, now_us: float) -> str:
    return _NONE if at_us is None else f"{max(now_us - at_us, 0) / 1e6:.1f} s"
