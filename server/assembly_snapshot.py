"""From the judge's estimate to the assembly in a snapshot; runs in the worker."""

from __future__ import annotations

import math
from typing import Any

from snapfit.tracking.assembly.estimate import AssemblyEstimate, Misassembly


class AssemblyWriter:
    """Writes one `AssemblySummary` after the other; counts what changes."""

    def __init__(self) -> None:
        self._told: dict[str, Any] | None = None
        self._since_us = 0
        self._revision = 0
        self._overridden: str | None = None
        self._decided_by = "tracking"

    def operator_says(self, state: str) -> None:
        """The next change to this state is an operator's."""
        self._overridden = state

    def write(self, estimate: AssemblyEstimate, captured_at_us: int) -> dict[str, Any]:
        """JSON of an `AssemblySummary`."""
        if self._told is None or estimate.state != self._told["state"]:
            self._since_us = captured_at_us
            is_override = estimate.state == self._overridden
            self._decided_by = "operator" if is_override else "tracking"
        self._overridden = None
        told = {
            "state": estimate.state,
            "finished_steps": list(estimate.finished_steps),
            "next_steps": list(estimate.next_steps),
            "misassemblies": [_misassembly(each) for each in estimate.misassemblies],
        }
        if told != self._told:
            self._told = told
            self._revision += 1
        confidence = estimate.confidence if math.isfinite(estimate.confidence) else 0.0
        return {
            **told,
            "confidence": round(min(max(confidence, 0.0), 1.0), 4),
            "decided_by": self._decided_by,
            "since_us": self._since_us,
            "revision": self._revision,
        }


def _misassembly(wrong: Misassembly) -> dict[str, Any]:
    return {
        "part": wrong.part,
        "parent": wrong.parent,
        "kind": str(wrong.kind),
        "translation_m": _number(wrong.translation_m),
        "rotation_rad": _number(wrong.rotation_rad),
    }


def _number(value: float) -> float | None:
    return round(value, 6) if math.isfinite(value) else None
