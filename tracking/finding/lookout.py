"""Looks for parts beside the tracker, which never waits for it."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Protocol

from snapfit.models.errors import SnapfitError
from snapfit.models.pose import Pose
from snapfit.tracking.finding.account import LookAccount
from snapfit.tracking.finding.finder import CountsRejections, Finder, Hypothesis
from snapfit.tracking.frame import Frame
from snapfit.tracking.threads import started_pair

_LOG = logging.getLogger(__name__)
_PROBLEMS_REMEMBERED = 100


@dataclass(frozen=True, eq=False)
class Found:
    """What a finder saw in one frame.

    Attributes:
        frame: its name.
        hypotheses: where parts may be; none where it failed.
        duration_ms: how long it took.
        problem: why it failed; None where it did not.
        rejected: candidates that gave no hypothesis since the finder was made, by reason.
    """

    frame: str
    hypotheses: tuple[Hypothesis, ...]
    duration_ms: float
    problem: str | None = None
    rejected: Mapping[str, int] = field(default_factory=dict)


class Lookout(Protocol):
    """Takes a frame when it has time, and has an answer later."""

    names: tuple[str, ...]
    """Of the parts that it can look for."""

    @property
    def account(self) -> LookAccount:
        """What has become of it so far."""

    def offer(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> bool:
        """Look into a frame for parts; False, and nothing is done, while it is busy.

        Args:
            frame: the newest one.
            wanted: names of the parts.
            known: where other parts are in this frame.
        """

    def take(self) -> Found | None:
        """The answer, once; None while there is none. To be asked once a frame."""

    def close(self) -> None:
        """Look no more."""


def look(
    finder: Finder,
    frame: Frame,
    wanted: Collection[str],
    known: Mapping[str, Pose] | None = None,
) -> Found:
    """One look; what a finder cannot do is told and never stops a tracker."""
    begin = time.perf_counter()
    try:
        hypotheses, problem = tuple(finder.find(frame, wanted, known)), None
    except SnapfitError as error:
        hypotheses, problem = (), str(error)
    duration_ms = 1e3 * (time.perf_counter() - begin)
    rejected = dict(finder.rejected) if isinstance(finder, CountsRejections) else {}
    _LOG.debug("frame %s: %d finds, rejected so far: %s", frame.name, len(hypotheses), rejected)
    return Found(frame.name, hypotheses, duration_ms, problem, rejected)


def _entered(account: LookAccount, found: Found) -> LookAccount:
    """The account with one look more."""
    account = replace(
        account,
        looks=account.looks + 1,
        found=account.found + len(found.hypotheses),
        rejected=found.rejected,
        look_ms=found.duration_ms,
    )
    if found.problem is None:
        return account
    return replace(account, failed=account.failed + 1, last_problem=found.problem)


class DelayedLookout:
    """Looks at once, and tells after a number of frames: the same answers in each run.

    Args:
        finder: that looks.
        delay_frames: how many frames later `take` has the answer, 1: at the next frame; or how
            that follows from the number of parts that are looked for.
    """

    def __init__(self, finder: Finder, delay_frames: int | Callable[[int], int]) -> None:
        self.names, self.account = finder.names, LookAccount()
        self._finder, self._delay_frames = finder, delay_frames
        self._found: Found | None = None
        self._left = 0

    def offer(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> bool:
        """As in `Lookout`."""
        if self._found is not None:
            return False
        delay = self._delay_frames
        self._left = delay if isinstance(delay, int) else delay(len(set(wanted)))
        self._found = look(self._finder, frame, wanted, known)
        self.account = _entered(self.account, self._found)
        return True

    def take(self) -> Found | None:
        """As in `Lookout`."""
        self._left -= 1
        if self._found is None or self._left > 0:
            return None
        found, self._found = self._found, None
        return found

    def close(self) -> None:
        """Nothing runs."""


class _Task(NamedTuple):
    """What is to be looked for."""

    frame: Frame
    wanted: tuple[str, ...]
    known: Mapping[str, Pose]


class LookoutThread:
    """Looks in a thread of its own; the newest frame is offered when it is free again.

    While parts are tracked, looking leaves the cores to the tracker. Where all parts are wanted
    there is nothing to disturb, and on a busy machine a thread that stays behind might never look:
    a second one, of usual priority, does it then. They never look at the same time.

    Args:
        finder: used in these threads alone.
    """

    def __init__(self, finder: Finder) -> None:
        self.names, self.account = finder.names, LookAccount()
        self._finder = finder
        self._changed = threading.Condition()
        self._task: _Task | None = None
        self._found: Found | None = None
        self._is_busy = self._is_closed = False
        self._problems: set[str] = set()
        self._threads = started_pair(self._run, "lookout")

    def offer(
        self, frame: Frame, wanted: Collection[str], known: Mapping[str, Pose] | None = None
    ) -> bool:
        """As in `Lookout`."""
        with self._changed:
            if self._is_busy or self._is_closed or self._found is not None:
                return False
            self._task = _Task(frame, tuple(wanted), dict(known or {}))
            self._is_busy = True
            self._changed.notify_all()
        return True

    def take(self) -> Found | None:
        """As in `Lookout`."""
        with self._changed:
            found, self._found = self._found, None
        return found

    def close(self) -> None:
        """As in `Lookout`; waits for a look that is under way."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
        for thread in self._threads:
            thread.join()

    def _is_for(self, is_urgent: bool) -> bool:
        """Whether there is a task of this kind."""
        return self._task is not None and (set(self._task.wanted) >= set(self.names)) == is_urgent

    def _run(self, is_urgent: bool) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._is_closed or self._is_for(is_urgent))
                if self._is_closed or self._task is None:
                    return
                task, self._task = self._task, None
            found = self._look(task)
            self.account = _entered(self.account, found)
            with self._changed:
                self._found, self._is_busy = found, False

    def _look(self, task: _Task) -> Found:
        """One look; whatever goes wrong is told once, and the thread goes on."""
        try:
            found = look(self._finder, task.frame, task.wanted, task.known)
        except Exception as error:  # noqa: BLE001  # tracking never stops for it
            problem = f"{type(error).__name__}: {error}"
            if self._is_new(problem):
                _LOG.exception("looking for parts failed: a bug (further ones are only counted)")
            return Found(task.frame.name, (), 0.0, problem)
        if found.problem is not None and self._is_new(found.problem):
            _LOG.warning(
                "looking for parts failed: %s (further ones are only counted)", found.problem
            )
        return found

    def _is_new(self, problem: str) -> bool:
        if problem in self._problems or len(self._problems) >= _PROBLEMS_REMEMBERED:
            return False
        self._problems.add(problem)
        return True
