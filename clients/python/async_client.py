"""The client for asyncio: `Client`'s methods, to be awaited. `Client` has their descriptions."""

from __future__ import annotations

import asyncio
import contextlib
import weakref
from collections.abc import AsyncGenerator, Sequence
from types import TracebackType
from typing import Any, Self

from snapfit.clients.python import calls
from snapfit.clients.python.anchor import AnchorInfo, Board, CharucoBoard, anchor_request
from snapfit.clients.python.assembly import AssemblyStatus, CommandResult, StepAnswer, StepList
from snapfit.clients.python.asset import AssetEntry, AssetInfo
from snapfit.clients.python.backoff import Backoff, OnWait
from snapfit.clients.python.calls import CAMERA, Axes, StationCalls
from snapfit.clients.python.choice import asset_of, station_of
from snapfit.clients.python.clock import Stopwatch, TimeOffset, best_of
from snapfit.clients.python.connection import DEFAULT_URL, Connection, Verify
from snapfit.clients.python.events import Event
from snapfit.clients.python.mailbox import Latest, fill
from snapfit.clients.python.picture import Picture
from snapfit.clients.python.snapshot import PartSnapshot, PoseSnapshot
from snapfit.clients.python.station import Health, StationInfo
from snapfit.clients.python.streams import OnOpen, Streams, Way
from snapfit.clients.python.transport import AsyncTransport


class AsyncClient:
    """One station of a server. Use it in an `async with`, or `aclose` it. See `Client`."""

    def __init__(
        self,
        url: str = DEFAULT_URL,
        *,
        station: str | None = None,
        key: str | None = None,
        verify: Verify = True,
        timeout_s: float = 10.0,
    ) -> None:
        self._open(AsyncTransport(Connection.to(url, key, verify, timeout_s)), station)

    def _open(self, transport: AsyncTransport, station: str | None) -> None:
        self._transport = transport
        self._station = station
        self._calls = StationCalls(station)
        self._readers: weakref.WeakSet[asyncio.Task[None]] = weakref.WeakSet()

    def at(self, station: str) -> AsyncClient:
        """Another station of the same server, over the same connections; close this one only."""
        other = object.__new__(AsyncClient)
        other._open(self._transport, station)
        other._readers = self._readers
        return other

    async def aclose(self) -> None:
        """End all streams and connections."""
        readers = list(self._readers)
        for reader in readers:
            reader.cancel()
        await asyncio.gather(*readers, return_exceptions=True)
        await self._transport.aclose()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.aclose()

    async def health(self) -> Health:
        """Whether the server lives."""
        return await self._transport.do(calls.health())

    async def ready(self) -> Health:
        """Whether all its stations have fresh poses."""
        return await self._transport.do(calls.ready())

    async def stations(self) -> tuple[StationInfo, ...]:
        """All stations of the server."""
        return (await self._transport.do(calls.stations())).stations

    async def info(self) -> StationInfo:
        """This station."""
        return station_of(await self._transport.do(calls.stations()), self._station)

    async def poses(
        self, *, convention: Axes = "opencv", frame: str = CAMERA, at_us: int | None = None
    ) -> PoseSnapshot:
        """The latest poses."""
        return await self._transport.do(self._calls.poses(convention, frame, at_us))

    async def pose(
        self,
        part: str,
        *,
        convention: Axes = "opencv",
        frame: str = CAMERA,
        at_us: int | None = None,
    ) -> PartSnapshot:
        """The latest pose of one part."""
        return await self._transport.do(self._calls.pose(part, convention, frame, at_us))

    async def next_poses(
        self,
        after: PoseSnapshot,
        *,
        convention: Axes = "opencv",
        frame: str = CAMERA,
        timeout_s: float = 20.0,
    ) -> PoseSnapshot | None:
        """Wait for a later snapshot; None if none came."""
        call = self._calls.next_poses(*after.identity, convention, frame, timeout_s)
        return await self._transport.do(call)

    async def follow(
        self,
        *,
        convention: Axes = "opencv",
        frame: str = CAMERA,
        way: Way = "auto",
        stale_after_s: float = 1.0,
        give_up_after_s: float | None = None,
        on_wait: OnWait | None = None,
    ) -> AsyncGenerator[PoseSnapshot, None]:
        """Every snapshot as it comes; the latest wins. A task reads until the loop is left."""
        backoff = Backoff(give_up_after_s, on_wait)
        streams = Streams(self._transport, self._calls)
        latest, change = Latest(stale_after_s), asyncio.Event()
        latest.wake = change.set
        stream = streams.snapshots(convention, frame, way, backoff)
        reader = asyncio.create_task(fill(latest, stream))
        self._readers.add(reader)
        try:
            while True:
                change.clear()
                snapshot = latest.take()
                if snapshot is not None:
                    yield snapshot
                elif latest.has_ended:
                    latest.raise_error()
                    return
                else:
                    with contextlib.suppress(TimeoutError):
                        async with asyncio.timeout(latest.due_in_s):
                            await change.wait()
        finally:
            reader.cancel()
            await asyncio.gather(reader, return_exceptions=True)

    def events(
        self,
        *,
        last_event_id: str = "",
        give_up_after_s: float | None = None,
        on_wait: OnWait | None = None,
        on_open: OnOpen | None = None,
    ) -> AsyncGenerator[Event, None]:
        """What happens, from now on or after `last_event_id`; `on_open` as in `Client`."""
        streams = Streams(self._transport, self._calls)
        return streams.events(last_event_id, Backoff(give_up_after_s, on_wait), on_open)

    async def assembly(self) -> AssemblyStatus:
        """State, confidence, finished and next steps, what sits wrong."""
        return await self._transport.do(self._calls.assembly())

    async def next_assembly(
        self, after: AssemblyStatus, *, timeout_s: float = 20.0
    ) -> AssemblyStatus | None:
        """Wait for a change of the assembly; None if none came."""
        call = self._calls.next_assembly(after.boot_id, after.revision, timeout_s)
        return await self._transport.do(call)

    async def steps(self, *, convention: Axes = "opencv", frame: str = CAMERA) -> StepList:
        """All steps, and where each stands."""
        return await self._transport.do(self._calls.steps(convention, frame))

    async def step(
        self, step: str = "current", *, convention: Axes = "opencv", frame: str = CAMERA
    ) -> StepAnswer:
        """One step, or the one that can be taken now."""
        return await self._transport.do(self._calls.step(step, convention, frame))

    async def reset(self) -> CommandResult:
        """Begin anew."""
        return await self._transport.do(self._calls.reset())

    async def reinitialise(self, *parts: str) -> CommandResult:
        """Look for these parts again, or for all."""
        return await self._transport.do(self._calls.reinitialise(parts))

    async def set_state(self, state: str) -> CommandResult:
        """Say which assembly state holds."""
        return await self._transport.do(self._calls.set_state(state))

    async def anchors(self, *, convention: Axes = "opencv") -> tuple[AnchorInfo, ...]:
        """All anchors of the station."""
        return (await self._transport.do(self._calls.anchors(convention))).anchors

    async def anchor(self, name: str, *, convention: Axes = "opencv") -> AnchorInfo:
        """One anchor."""
        return await self._transport.do(self._calls.anchor(name, convention))

    async def put_anchor(
        self,
        name: str,
        position: Sequence[float],
        orientation: Sequence[float],
        *,
        board: Board = CharucoBoard(),  # noqa: B008 - frozen
        **more: Any,
    ) -> AnchorInfo:
        """Say where a board is in the client's own world; `more` as `Client.put_anchor` has it."""
        request = anchor_request(position, orientation, board=board, **more)
        return await self._transport.do(self._calls.put_anchor(name, request))

    async def delete_anchor(self, name: str) -> None:
        """Forget an anchor."""
        await self._transport.do(self._calls.delete_anchor(name))

    async def frame_jpeg(self) -> Picture:
        """What the camera sees."""
        return await self._transport.do(self._calls.picture("frame"))

    async def overlay_jpeg(self) -> Picture:
        """What the camera sees, with the parts drawn in."""
        return await self._transport.do(self._calls.picture("overlay"))

    async def assets(self) -> tuple[AssetEntry, ...]:
        """The assets that the server's stations assemble."""
        return (await self._transport.do(calls.assets())).assets

    async def asset(self, name: str | None = None, *, convention: Axes = "opencv") -> AssetInfo:
        """Parts, states and steps of an asset, or of the station's own."""
        name = name or asset_of(await self.info())
        return await self._transport.do(calls.asset(name, convention))

    async def part_model(self, part: str, *, asset: str | None = None) -> bytes:
        """A part's mesh as binary glTF."""
        asset = asset or asset_of(await self.info())
        return await self._transport.do(calls.part_model(asset, part))

    async def media(self, path: str) -> bytes:
        """A picture or film that a step's `media` names by its path on this server."""
        return await self._transport.do(calls.media(path))

    async def time_offset(self, samples: int = 8) -> TimeOffset:
        """How the server's clock lies against `time.time_ns`."""
        return best_of([await self._time_offset() for _ in range(samples)])

    async def _time_offset(self) -> TimeOffset:
        watch = Stopwatch()
        return watch.offset(await self._transport.do(calls.server_time(watch.sent_at_us)))
