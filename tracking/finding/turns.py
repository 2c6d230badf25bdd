"""Several finders that look in turn: each finds what the others do not.

Shape alone is sure of parts that lie free, and asks for no network; a network tells joined parts
and parts in a hand apart. One looks at a time: they share the cores that the tracker leaves.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence

from snapfit.models.pose import Pose
from snapfit.tracking.finding.account import LookAccount
from snapfit.tracking.finding.lookout import Found, Lookout
from snapfit.tracking.frame import Frame


class LookoutsInTurn:
    """Lookouts that look one after the other; see `Lookout`.

    Attributes:
        names: of the parts that any of them can look for.
    """

    def __init__(self, lookouts: Sequence[Lookout]) -> None:
        """Puts them in a row.

        Args:
            lookouts: the one that looks first comes first; at least one.
        """
        self._lookouts = tuple(lookouts)
        self.names = tuple(dict.fromkeys(name for each in lookouts for name in each.names))
        self._turn = 0
        self._is_waiting = False

    @property
    def account(self) -> LookAccount:
        """All of theirs together; the look that took longest counts as the last."""
        accounts = [each.account for each in self._lookouts]
        rejected: Counter[str] = Counter()
        for each in accounts:
            rejected.update(each.rejected)
        problems = [each.last_problem for each in accounts if each.last_problem is not None]
        return LookAccount(
            looks=sum(each.looks for each in accounts),
            failed=sum(each.failed for each in accounts),
            last_problem=problems[-1] if problems else None,
            found=sum(each.found for each in accounts),
            rejected=dict(rejected),
            look_ms=max(
                (each.look_ms for each in accounts if each.look_ms is not None), default=None
            ),
        )

    def offer(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> bool:
        """As in `Lookout`; one that knows none of the parts is passed over."""
        if self._is_waiting:
            return False
        for _ in self._lookouts:
            lookout = self._lookouts[self._turn]
            findable = [name for name in wanted if name in lookout.names]
            if findable and lookout.offer(frame, findable, known):
                self._is_waiting = True
                return True
            self._next()
        return False

    def take(self) -> Found | None:
        """As in `Lookout`, from the one whose turn it is; then it is the next one's."""
        if not self._is_waiting:
            return None
        found = self._lookouts[self._turn].take()
        if found is not None:
            self._is_waiting = False
            self._next()
        return found

    def close(self) -> None:
        """As in `Lookout`."""
        for each in self._lookouts:
            each.close()

    def _next(self) -> None:
        self._turn = (self._turn + 1) % len(self._lookouts)


def in_turn(lookouts: Sequence[Lookout]) -> Lookout:
    """One lookout as it is, several in turn."""
    return lookouts[0] if len(lookouts) == 1 else LookoutsInTurn(lookouts)
