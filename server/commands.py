"""What the API orders from a worker, and what the worker replies."""

from __future__ import annotations

from enum import StrEnum

from pydantic import BaseModel, ConfigDict

from snapfit.server.boards import Board


class CommandKind(StrEnum):
    """What can be ordered."""

    RESET = "reset"
    REINITIALISE = "reinitialise"
    SET_STATE = "set_state"


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Command(_Message):
    """One order. Doing it twice does no more than doing it once.

    Attributes:
        number: grows by one with each order of a run of the server.
        kind: what to do.
        parts: to be looked for again; empty for all.
        state: that holds.
        begin_by_s: by the monotonic clock of the worker's machine: later it is not begun, because
            whoever ordered it may have given it up. None: at any time.
    """

    number: int
    kind: CommandKind
    parts: tuple[str, ...] = ()
    state: str = ""
    begin_by_s: float | None = None


class Outcome(_Message):
    """What became of an order.

    Attributes:
        number: the order's.
        problem: why nothing was done, for programs; None if it was.
        detail: why, for people.
        names: that there are, where one was given that is not.
        done: what was done, for people.
        state: the assembly state that holds now; None where nothing follows it.
    """

    number: int
    problem: str | None = None
    detail: str = ""
    names: tuple[str, ...] = ()
    done: tuple[str, ...] = ()
    state: str | None = None


class Orders(_Message):
    """All that the API wants at the moment.

    Attributes:
        run: names the run of the server: numbers begin again with the next one.
        commands: not known to be done, in order.
        boards: that the camera shall look for.
    """

    run: str
    commands: tuple[Command, ...] = ()
    boards: tuple[Board, ...] = ()


class Replies(_Message):
    """What became of the latest orders."""

    run: str
    outcomes: tuple[Outcome, ...] = ()
