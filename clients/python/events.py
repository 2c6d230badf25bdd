"""What happens at a station: one class for each kind of server-sent event."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from pydantic import TypeAdapter, ValidationError

from snapfit.clients.python.assembly import DecidedBy, MisassemblyKind
from snapfit.clients.python.errors import UnexpectedAnswerError
from snapfit.clients.python.schema import Schema
from snapfit.clients.python.snapshot import Status


class Event(Schema):
    """Base of all events.

    Attributes:
        event: what the server calls this kind.
        id: for `last_event_id`; empty where the event has none.
    """

    event: ClassVar[str] = ""

    id: str = ""


class Missed(Event):
    """Events after `last_event_id` are no longer kept: ask for the state anew."""

    event = "missed"


class StationEvent(Event):
    """What all others carry: when it was noted, and the snapshot that showed it."""

    station: str
    at_us: int
    boot_id: str
    seq: int
    captured_at_us: int


class StateChanged(StationEvent):
    """The assembly is in another state."""

    event = "state_changed"

    from_state: str
    to_state: str
    decided_by: DecidedBy
    confidence: float


class StepFinished(StationEvent):
    """A step was taken."""

    event = "step_finished"

    step: str
    decided_by: DecidedBy


class StepUndone(StationEvent):
    """A step was taken back."""

    event = "step_undone"

    step: str
    decided_by: DecidedBy


class Misassembled(StationEvent):
    """A part sits wrong."""

    event = "misassembled"

    part: str
    parent: str
    kind: MisassemblyKind
    translation_m: float | None
    rotation_rad: float | None


class PartFound(StationEvent):
    """A part has a pose now."""

    event = "part_found"

    part: str
    status: Status


class PartLost(StationEvent):
    """A part has no pose any more."""

    event = "part_lost"

    part: str
    status: Status


class Stale(StationEvent):
    """No fresh snapshots come."""

    event = "stale"


class Recovered(StationEvent):
    """Fresh snapshots come again."""

    event = "recovered"


class AnchorDrift(StationEvent):
    """An anchor has moved against its average."""

    event = "anchor_drift"

    anchor: str
    translation_m: float
    rotation_rad: float


class OtherEvent(Event):
    """A kind that this client does not know yet."""

    name: str
    data: dict[str, Any]


_CLASSES: dict[str, type[Event]] = {
    each.event: each
    for each in (
        Missed,
        StateChanged,
        StepFinished,
        StepUndone,
        Misassembled,
        PartFound,
        PartLost,
        Stale,
        Recovered,
        AnchorDrift,
    )
}
_OBJECT = TypeAdapter(dict[str, Any])


def event_of(name: str, id_: str, data: str) -> Event:
    """The event that came as these fields.

    Raises:
        UnexpectedAnswerError: the data is not what this kind carries.
    """
    try:
        members = _OBJECT.validate_json(data)
        kind = _CLASSES.get(name)
        if kind is None:
            return OtherEvent(id=id_, name=name, data=members)
        return kind.model_validate({**members, "id": id_})
    except ValidationError as error:
        raise UnexpectedAnswerError(f"the event {name}: {error}") from error


class EventReader:
    """Puts events together from `text/event-stream` (WHATWG HTML, section 9.2).

    Args:
        last_id: of the last event that is known, in case none comes.

    Attributes:
        last_id: what to go on after when the connection is lost.
    """

    def __init__(self, last_id: str = "") -> None:
        self.last_id = last_id
        self.begin()

    def begin(self) -> None:
        """A connection begins: what was not complete in the one before is forgotten."""
        self._rest = b""
        self._name = ""
        self._id = ""
        self._data: list[str] = []

    def feed(self, chunk: bytes) -> Iterator[Event]:
        """The events that these bytes complete."""
        # Not str.splitlines: U+2028 and the like end no line here.
        *lines, self._rest = (self._rest + chunk).split(b"\n")
        for line in lines:
            yield from self._read(line.removesuffix(b"\r").decode())

    def _read(self, line: str) -> Iterator[Event]:
        if not line:
            name, id_, data = self._name, self._id, self._data
            self._name, self._id, self._data = "", "", []
            self.last_id = id_ or self.last_id  # an id alone is no event, but counts
            if name and data:
                yield event_of(name, id_, "\n".join(data))
            return
        field, _, value = line.partition(":")
        value = value.removeprefix(" ")
        if field == "event":
            self._name = value
        elif field == "id":
            self._id = value
        elif field == "data":
            self._data.append(value)
