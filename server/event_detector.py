"""What happened between two snapshots."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from snapfit.server.events import EventKind

Happening = tuple[EventKind, dict[str, Any]]


class EventDetector:
    """Compares each snapshot with the one before; whatever lies between leaves its net effect.

    It goes by what the snapshots say and not by their numbers, so that nothing is missed when
    some are skipped, or when the worker starts again.
    """

    def __init__(self) -> None:
        self._posed: set[str] = set()
        self._assembly: dict[str, Any] | None = None
        self._stale = False

    def happened(self, snapshot: dict[str, Any], *, stale: bool) -> Iterator[Happening]:
        """What is new in a snapshot.

        Args:
            snapshot: JSON of a `PoseSnapshot`.
            stale: whether it is by now.
        """
        if stale != self._stale:
            self._stale = stale
            yield (EventKind.STALE if stale else EventKind.RECOVERED), {}
        yield from self._parts(snapshot["parts"])
        assembly = snapshot.get("assembly")
        if assembly is not None:
            yield from self._changes(self._assembly or _NOTHING, assembly)
            self._assembly = assembly

    def _parts(self, parts: list[dict[str, Any]]) -> Iterator[Happening]:
        posed = {part["part"] for part in parts if part["position"] is not None}
        for part in parts:
            name = part["part"]
            if (name in posed) != (name in self._posed):
                kind = EventKind.PART_FOUND if name in posed else EventKind.PART_LOST
                yield kind, {"part": name, "status": part["status"]}
        self._posed = posed

    @staticmethod
    def _changes(before: dict[str, Any], now: dict[str, Any]) -> Iterator[Happening]:
        by = {"decided_by": now["decided_by"]}
        if before["state"] not in (None, now["state"]):
            change = {"from_state": before["state"], "to_state": now["state"]}
            yield EventKind.STATE_CHANGED, {**change, **by, "confidence": now["confidence"]}
        for step in now["finished_steps"]:
            if step not in before["finished_steps"] and before["state"] is not None:
                yield EventKind.STEP_FINISHED, {"step": step, **by}
        for step in reversed(before["finished_steps"]):
            if step not in now["finished_steps"]:
                yield EventKind.STEP_UNDONE, {"step": step, **by}
        known = {_identity(each) for each in before["misassemblies"]}
        for each in now["misassemblies"]:
            if _identity(each) not in known:
                yield EventKind.MISASSEMBLED, each


_NOTHING: dict[str, Any] = {"state": None, "finished_steps": [], "misassemblies": []}


def _identity(misassembly: dict[str, Any]) -> tuple[str, str, str]:
    return misassembly["part"], misassembly["parent"], misassembly["kind"]
