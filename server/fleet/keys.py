"""The names of a station's keys and of its channel, and how values are packed.

| key | value | lives |
| --- | --- | --- |
| `snapfit:STATION:lease` | who may publish | `LEASE_S`, renewed each second |
| `snapfit:STATION:status` | JSON of a `ToldStatus` | as the lease |
| `snapfit:STATION:snapshot`, `:report` | generation, then the message | a day |
| `snapfit:STATION:frame`, `:overlay` | the same, of a picture | a day |
| `snapfit:STATION:anchors` | hash: an `AnchorRecord` a name, and how often it was changed | a day |
| `snapfit:STATION:views` | hash: a `ViewRecord` a board | a day |
| `snapfit:asset:NAME-DIGEST` | hash: an asset's files in pieces, and their list | a day |

The channel `snapfit:STATION` tells of each new message and status: its name, a line feed, and, but
for pictures, the value itself; in the same form of what became of orders (`replies`), of boards
that the camera sees (`view`), and of anchors (`anchors`, an `AnchorsChange`). The channel
`snapfit:STATION:to-worker` goes the other way: `want`, and which pictures; `orders`, and all that
a replica wants done at the moment.
"""

from __future__ import annotations

import dataclasses
import struct
from dataclasses import dataclass

import orjson

from snapfit.server.mailbox import Mailbox, Message
from snapfit.server.pose_store import PoseStore
from snapfit.server.supervisor import SupervisorStatus

LEASE_S = 3.0
"""A worker that is not heard of for so long has lost its station, seconds."""

KEPT_S = 86_400
"""How long the last message is kept when its worker is gone, seconds."""

WANTED_S = 2.0
"""For how long one wish brings pictures, seconds."""

SNAPSHOT, REPORT, STATUS, WANT = "snapshot", "report", "status", "want"
ORDERS, REPLIES, VIEW, ANCHORS = "orders", "replies", "view", "anchors"
_GENERATION = struct.Struct("<Q")


@dataclass(frozen=True)
class StationKeys:
    """The keys of one station."""

    station: str

    @property
    def channel(self) -> str:
        """Where new messages are told."""
        return f"snapfit:{self.station}"

    @property
    def to_worker(self) -> str:
        """Where replicas tell what they want."""
        return f"snapfit:{self.station}:to-worker"

    @property
    def lease(self) -> str:
        """Who may publish."""
        return f"snapfit:{self.station}:lease"

    @property
    def status(self) -> str:
        """How the worker does, as its supervisor knows."""
        return f"snapfit:{self.station}:status"

    @property
    def anchors(self) -> str:
        """What clients have put."""
        return f"snapfit:{self.station}:anchors"

    @property
    def views(self) -> str:
        """How the camera sees their boards."""
        return f"snapfit:{self.station}:views"

    def message(self, name: str) -> str:
        """The latest message of a mailbox."""
        return f"snapfit:{self.station}:{name}"


@dataclass(frozen=True)
class ToldStatus:
    """What a worker's machine says of its worker.

    Attributes:
        status: of the supervisor.
        sent_at_us: by that machine's clock, Unix time, microseconds.
    """

    status: SupervisorStatus
    sent_at_us: int

    def dump(self) -> bytes:
        """JSON."""
        return orjson.dumps(dataclasses.asdict(self))

    @staticmethod
    def load(value: bytes) -> ToldStatus:
        """The inverse of `dump`.

        Raises:
            ValueError: the value was made by another version of snapfit.
        """
        told = orjson.loads(value)
        try:
            return ToldStatus(SupervisorStatus(**told["status"]), told["sent_at_us"])
        except (TypeError, KeyError) as error:
            raise ValueError(f"a status of another version of snapfit: {error}") from error


def published(store: PoseStore) -> dict[str, Mailbox]:
    """The mailboxes of a store that go from the worker to the API, by name."""
    pictures = {kind.value: mailbox for kind, mailbox in store.pictures.items()}
    return {SNAPSHOT: store.snapshots, REPORT: store.reports, **pictures}


def tell(name: str, value: bytes) -> bytes:
    """What goes over a channel."""
    return name.encode() + b"\n" + value


def heard(told: bytes) -> tuple[str, bytes]:
    """The inverse of `tell`."""
    name, _, value = told.partition(b"\n")
    return name.decode(errors="replace"), value


def pack(message: Message) -> bytes:
    """A message with its generation."""
    return _GENERATION.pack(message.generation) + message.payload


def unpack(value: bytes) -> Message:
    """The inverse of `pack`.

    Raises:
        ValueError: the value was not made by `pack`.
    """
    if len(value) < _GENERATION.size:
        raise ValueError(f"a message of {len(value)} bytes")
    (generation,) = _GENERATION.unpack_from(value)
    return Message(generation, value[_GENERATION.size :])
