"""What has become of looking for parts so far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class LookAccount:
    """Counted since the lookout was made.

    Attributes:
        looks: frames that were looked into.
        failed: looks in which the finder could not work; tracking went on.
        last_problem: why, the last time; None if it always could.
        found: hypotheses that it reported.
        rejected: candidates that it did not report, by reason.
        look_ms: how long the last look took; None before the first.
    """

    looks: int = 0
    failed: int = 0
    last_problem: str | None = None
    found: int = 0
    rejected: Mapping[str, int] = field(default_factory=dict)
    look_ms: float | None = None


@dataclass(frozen=True)
class FindingAccount:
    """Looking, and what came of it.

    Attributes:
        look: of the finder.
        started: how often a part was started where it was found.
        dropped: how often one of them did not stand its trial.
    """

    look: LookAccount
    started: int
    dropped: int
