"""The client for programs that wait for each answer."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from types import TracebackType
from typing import Self, TypeVar

from snapfit.clients.python import calls
from snapfit.clients.python.anchor import AnchorInfo, Board, CharucoBoard, anchor_request
from snapfit.clients.python.assembly import AssemblyStatus, CommandResult, StepAnswer, StepList
from snapfit.clients.python.asset import AssetEntry, AssetInfo
from snapfit.clients.python.background import Background, OpenStream, Readers, taken
from snapfit.clients.python.backoff import Backoff, OnWait
from snapfit.clients.python.calls import CAMERA, Axes, StationCalls
from snapfit.clients.python.choice import asset_of, station_of
from snapfit.clients.python.clock import Stopwatch, TimeOffset, best_of
from snapfit.clients.python.connection import DEFAULT_URL, Connection, Verify
from snapfit.clients.python.events import Event
from snapfit.clients.python.mailbox import InOrder, Latest, Mailbox
from snapfit.clients.python.picture import Picture
from snapfit.clients.python.snapshot import PartSnapshot, PoseSnapshot
from snapfit.clients.python.station import Health, StationInfo
from snapfit.clients.python.streams import OnOpen, Way
from snapfit.clients.python.transport import Transport

T = TypeVar("T")


class Client:
    """One station of a server. Use it in a `with`, or close it.

    Every method raises a `ClientError` that says why there is no answer: `NotReachableError`,
    `NotAllowedError`, `UnknownStationError`, ...

    Args:
        url: the server's address; one with `?key=` is good too.
        station: its name; may be left out where the server has one station.
        key: API key; else that of the address, else the environment's `SNAPFIT_KEY`.
        verify: of an HTTPS server: True (the system's authorities), the file of an authority or
            certificate (PEM), an `ssl.SSLContext`, or False, which lets anybody be the server.
        timeout_s: how long an answer may take.
    """

    def __init__(
        self,
        url: str = DEFAULT_URL,
        *,
        station: str | None = None,
        key: str | None = None,
        verify: Verify = True,
        timeout_s: float = 10.0,
    ) -> None:
        self._open(Transport(Connection.to(url, key, verify, timeout_s)), station)

    def _open(self, transport: Transport, station: str | None) -> None:
        self._transport = transport
        self._station = station
        self._calls = StationCalls(station)
        self._readers = Readers()

    def at(self, station: str) -> Client:
        """Another station of the same server, over the same connections; close this one only."""
        other = object.__new__(Client)
        other._open(self._transport, station)
        other._readers = self._readers
        return other

    def close(self) -> None:
        """End all streams and connections; none can be opened any more."""
        self._readers.close()
        self._transport.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def health(self) -> Health:
        """Whether the server lives."""
        return self._transport.do(calls.health())

    def ready(self) -> Health:
        """Whether all its stations have fresh poses; `NotReadyError` says which has not."""
        return self._transport.do(calls.ready())

    def stations(self) -> tuple[StationInfo, ...]:
        """All stations of the server."""
        return self._transport.do(calls.stations()).stations

    def info(self) -> StationInfo:
        """This station: cameras, frame rate, parts, how its worker is."""
        return station_of(self._transport.do(calls.stations()), self._station)

    def poses(
        self, *, convention: Axes = "opencv", frame: str = CAMERA, at_us: int | None = None
    ) -> PoseSnapshot:
        """The latest poses; those that the client has already are not sent again.

        Args:
            convention: the axes that everything is given in.
            frame: `camera`, or `anchor:ID`.
            at_us: Unix time by the server's clock that poses are extrapolated to, microseconds.
        """
        return self._transport.do(self._calls.poses(convention, frame, at_us))

    def pose(
        self,
        part: str,
        *,
        convention: Axes = "opencv",
        frame: str = CAMERA,
        at_us: int | None = None,
    ) -> PartSnapshot:
        """The latest pose of one part; arguments as of `poses`."""
        return self._transport.do(self._calls.pose(part, convention, frame, at_us))

    def next_poses(
        self,
        after: PoseSnapshot,
        *,
        convention: Axes = "opencv",
        frame: str = CAMERA,
        timeout_s: float = 20.0,
    ) -> PoseSnapshot | None:
        """Wait for a later snapshot, at most 60 s; None if none came."""
        call = self._calls.next_poses(*after.identity, convention, frame, timeout_s)
        return self._transport.do(call)

    def follow(
        self,
        *,
        convention: Axes = "opencv",
        frame: str = CAMERA,
        way: Way = "auto",
        stale_after_s: float = 1.0,
        give_up_after_s: float | None = None,
        on_wait: OnWait | None = None,
    ) -> Generator[PoseSnapshot, None, None]:
        """Every snapshot as it comes; the latest wins: who is slow gets fewer, not older ones.

        Connections that are lost are opened again, with a growing wait. In silence the last
        snapshot comes once more, with `stale` true. A thread reads until the loop is left.

        Args:
            convention: the axes that everything is given in.
            frame: `camera`, or `anchor:ID`.
            way: `websocket`, `poll`, or `auto`: the first that works.
            stale_after_s: of silence.
            give_up_after_s: of failures in a row; None: never.
            on_wait: told each failure and the seconds until the next try; else it is logged.
        """
        backoff = Backoff(give_up_after_s, on_wait)
        latest = Latest(stale_after_s)
        return self._taken(
            lambda streams: streams.snapshots(convention, frame, way, backoff), latest
        )

    def events(
        self,
        *,
        last_event_id: str = "",
        give_up_after_s: float | None = None,
        on_wait: OnWait | None = None,
        on_open: OnOpen | None = None,
    ) -> Generator[Event, None, None]:
        """What happens, from now on or after `last_event_id`; opened again as in `follow`.

        `on_open` is called, in another thread, each time the server begins to tell: whoever asks
        for the state after that misses no change of it.
        """
        backoff = Backoff(give_up_after_s, on_wait)
        return self._taken(
            lambda streams: streams.events(last_event_id, backoff, on_open), InOrder()
        )

    def assembly(self) -> AssemblyStatus:
        """State, confidence, finished and next steps, what sits wrong."""
        return self._transport.do(self._calls.assembly())

    def next_assembly(
        self, after: AssemblyStatus, *, timeout_s: float = 20.0
    ) -> AssemblyStatus | None:
        """Wait for a change of the assembly, at most 60 s; None if none came."""
        call = self._calls.next_assembly(after.boot_id, after.revision, timeout_s)
        return self._transport.do(call)

    def steps(self, *, convention: Axes = "opencv", frame: str = CAMERA) -> StepList:
        """All steps, and where each stands."""
        return self._transport.do(self._calls.steps(convention, frame))

    def step(
        self, step: str = "current", *, convention: Axes = "opencv", frame: str = CAMERA
    ) -> StepAnswer:
        """One step, or the one that can be taken now; `AssemblyFinishedError` where none can."""
        return self._transport.do(self._calls.step(step, convention, frame))

    def reset(self) -> CommandResult:
        """Begin anew: the first assembly state, and all parts are looked for again."""
        return self._transport.do(self._calls.reset())

    def reinitialise(self, *parts: str) -> CommandResult:
        """Look for these parts again, or for all."""
        return self._transport.do(self._calls.reinitialise(parts))

    def set_state(self, state: str) -> CommandResult:
        """Say which assembly state holds."""
        return self._transport.do(self._calls.set_state(state))

    def anchors(self, *, convention: Axes = "opencv") -> tuple[AnchorInfo, ...]:
        """All anchors of the station."""
        return self._transport.do(self._calls.anchors(convention)).anchors

    def anchor(self, name: str, *, convention: Axes = "opencv") -> AnchorInfo:
        """One anchor."""
        return self._transport.do(self._calls.anchor(name, convention))

    def put_anchor(
        self,
        name: str,
        position: Sequence[float],
        orientation: Sequence[float],
        *,
        convention: Axes = "opencv",
        board: Board = CharucoBoard(),  # noqa: B008 - frozen
        ttl_s: float = 3600.0,
        restart: bool = False,
    ) -> AnchorInfo:
        """Say where a board is in the client's own world: `world_from_marker`.

        Args:
            name: the client's choice.
            position: x, y, z, metres.
            orientation: unit quaternion x, y, z, w.
            convention: of both.
            board: what client and camera see.
            ttl_s: the anchor expires when it is not put again for so long.
            restart: forget what was put before.
        """
        request = anchor_request(
            position, orientation, convention=convention, board=board, ttl_s=ttl_s, restart=restart
        )
        return self._transport.do(self._calls.put_anchor(name, request))

    def delete_anchor(self, name: str) -> None:
        """Forget an anchor."""
        self._transport.do(self._calls.delete_anchor(name))

    def frame_jpeg(self) -> Picture:
        """What the camera sees."""
        return self._transport.do(self._calls.picture("frame"))

    def overlay_jpeg(self) -> Picture:
        """What the camera sees, with the parts drawn in."""
        return self._transport.do(self._calls.picture("overlay"))

    def assets(self) -> tuple[AssetEntry, ...]:
        """The assets that the server's stations assemble."""
        return self._transport.do(calls.assets()).assets

    def asset(self, name: str | None = None, *, convention: Axes = "opencv") -> AssetInfo:
        """Parts, states and steps of an asset, or of the station's own."""
        return self._transport.do(calls.asset(name or asset_of(self.info()), convention))

    def part_model(self, part: str, *, asset: str | None = None) -> bytes:
        """A part's mesh as binary glTF: metres, glTF's own axes."""
        return self._transport.do(calls.part_model(asset or asset_of(self.info()), part))

    def media(self, path: str) -> bytes:
        """A picture or film that a step's `media` names by its path on this server."""
        return self._transport.do(calls.media(path))

    def time_offset(self, samples: int = 8) -> TimeOffset:
        """How the server's clock lies against `time.time_ns`; the quickest of some answers."""
        return best_of([self._time_offset() for _ in range(samples)])

    def _time_offset(self) -> TimeOffset:
        watch = Stopwatch()
        return watch.offset(self._transport.do(calls.server_time(watch.sent_at_us)))

    def _taken(self, open_stream: OpenStream[T], mailbox: Mailbox[T]) -> Generator[T, None, None]:
        def start(filled: Mailbox[T]) -> Background:
            connection = self._transport.connection
            return self._readers.start(
                lambda: Background(connection, self._calls, open_stream, filled)
            )

        return taken(start, mailbox)
