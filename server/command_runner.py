"""Does what the API orders, between two frames; runs in the worker."""

from __future__ import annotations

import time
from collections import deque

from snapfit.server.commands import Command, CommandKind, Orders, Outcome, Replies
from snapfit.server.pipeline import Controls, Pipeline
from snapfit.server.pose_store import PoseStore
from snapfit.server.snapshot import SnapshotWriter
from snapfit.tracking.result import Status, TrackingResult

_KEPT = 32


class CommandRunner:
    """Reads orders from the store, does them, and replies.

    Args:
        store: where orders come from and replies go.
        pipeline: what they act on.
        snapshots: told that an operator has decided.
    """

    def __init__(self, store: PoseStore, pipeline: Pipeline, snapshots: SnapshotWriter) -> None:
        self._store = store
        self._pipeline = pipeline
        self._snapshots = snapshots
        asset = pipeline.source.asset
        self._states = () if asset is None else tuple(state.name for state in asset.states)
        self._parts = tuple(part.name for part in pipeline.source.parts if part.tracked)
        self._last: TrackingResult | None = None
        self._seen = 0
        self._number = 0
        self._outcomes: deque[Outcome] = deque(maxlen=_KEPT)
        self._is_due = False
        self.orders = Orders(run="")

    def tracked(self, result: TrackingResult) -> None:
        """The latest result."""
        self._last = result

    def run(self, *, ended: bool = False) -> None:
        """Do what was ordered since the last time; `reply` tells of it.

        Args:
            ended: the source has: nothing can be done any more.
        """
        if self._store.orders.latest == self._seen:
            return
        message = self._store.orders.read()
        if message is None:
            return
        self._seen = message.generation
        orders = Orders.model_validate_json(message.payload)
        if orders.run != self.orders.run:
            self._number = 0
            self._outcomes.clear()
        self.orders = orders
        for command in orders.commands:
            if command.number > self._number:
                self._number = command.number
                if command.begin_by_s is not None and time.monotonic() > command.begin_by_s:
                    continue
                self._outcomes.append(_ended(command) if ended else self._do(command))
                self._is_due = True

    def reply(self) -> None:
        """Tell what became of orders; after the snapshot that shows it, where there is one."""
        if self._is_due:
            self._is_due = False
            replies = Replies(run=self.orders.run, outcomes=tuple(self._outcomes))
            self._store.replies.write(replies.model_dump_json().encode())

    def _do(self, command: Command) -> Outcome:
        controls = self._pipeline.controls
        if controls is None:
            detail = f"{self._pipeline.method} sees every frame by itself: it keeps nothing."
            return _refused(command, "nothing-to-command", detail)
        match command.kind:
            case CommandKind.SET_STATE:
                return self._set_state(command, controls)
            case CommandKind.REINITIALISE:
                return self._reinitialise(command, controls)
            case CommandKind.RESET:
                return self._reset(command, controls)

    def _set_state(self, command: Command, controls: Controls) -> Outcome:
        state = self._state()
        if state is None:
            detail = f"{self._pipeline.method} follows no assembly graph here."
            return _refused(command, "no-assembly", detail)
        if command.state not in self._states:
            detail = f"there is no state {command.state!r}; there is {', '.join(self._states)}."
            return _refused(command, "unknown-state", detail, self._states)
        return self._done(command, self._put(command.state, controls), command.state)

    def _reinitialise(self, command: Command, controls: Controls) -> Outcome:
        unknown = [part for part in command.parts if part not in self._parts]
        if unknown:
            detail = f"there is no tracked part {unknown[0]!r}; there is {', '.join(self._parts)}."
            return _refused(command, "unknown-part", detail, self._parts)
        if self._pipeline.finding is None:
            return _refused(command, "no-detector", _NO_DETECTOR)
        done = self._search(command.parts or self._parts, controls)
        return self._done(command, done, self._state())

    def _reset(self, command: Command, controls: Controls) -> Outcome:
        follows = self._state() is not None and bool(self._states)
        if self._pipeline.finding is None and not follows:
            return _refused(command, "no-detector", _NO_DETECTOR)
        done = self._put(self._states[0], controls) if follows else []
        if self._pipeline.finding is not None:
            done += self._search(self._parts, controls)
        return self._done(command, done, self._states[0] if follows else None)

    def _state(self) -> str | None:
        return None if self._last is None or self._last.assembly is None else self._last.state

    def _put(self, state: str, controls: Controls) -> list[str]:
        """Sets the state; what was done, which is nothing if it holds already."""
        if state == self._state():
            return []
        controls.set_state(state)
        self._snapshots.assembly.operator_says(state)
        return [f"state set to {state}"]

    def _search(self, parts: tuple[str, ...], controls: Controls) -> list[str]:
        estimates = () if self._last is None else self._last.parts
        known = [each.part for each in estimates if each.status is not Status.SEARCHING]
        wanted = [part for part in parts if part in known]
        for part in wanted:
            controls.search(part)
        return [f"{part} is looked for again" for part in wanted]

    def _done(self, command: Command, done: list[str], state: str | None) -> Outcome:
        return Outcome(number=command.number, done=tuple(done), state=state)


_NO_DETECTOR = (
    "No detector finds parts at this station: they would stay lost. Set station.detector."
)


def _refused(command: Command, problem: str, detail: str, names: tuple[str, ...] = ()) -> Outcome:
    return Outcome(number=command.number, problem=problem, detail=detail, names=names)


def _ended(command: Command) -> Outcome:
    return _refused(command, "source-ended", "The source has ended: no frame will come any more.")
