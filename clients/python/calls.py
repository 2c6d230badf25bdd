"""Every call of the API as data: what to send, and what the answer is read as."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Literal, TypeVar
from urllib.parse import quote

import httpx

from snapfit.clients.python.anchor import AnchorInfo, AnchorList, AnchorRequest
from snapfit.clients.python.answer import ModelT, parsed
from snapfit.clients.python.assembly import AssemblyStatus, CommandResult, StepAnswer, StepList
from snapfit.clients.python.asset import AssetInfo, AssetList
from snapfit.clients.python.picture import Picture
from snapfit.clients.python.schema import Convention
from snapfit.clients.python.snapshot import PartSnapshot, PoseSnapshot
from snapfit.clients.python.station import Health, ServerTime, StationList

T = TypeVar("T")
Axes = Convention | Literal["opencv", "openxr", "unity", "ros", "ros_optical"]
Query = Mapping[str, str | int | float]
CAMERA = "camera"


@dataclass(frozen=True)
class Call(Generic[T]):
    """One request and how to read its answer.

    Attributes:
        extra_s: how long the server may take by itself, beside the usual time.
        is_tagged: whether the answer's ETag is kept, and sent the next time.
    """

    method: str
    path: str
    read: Callable[[httpx.Response], T]
    query: Query
    body: Any = None
    extra_s: float = 0.0
    is_tagged: bool = False


def view_query(convention: Axes, frame: str = CAMERA, at_us: int | None = None) -> Query:
    """The query, without what is the server's default anyhow."""
    query: dict[str, str | int | float] = {}
    if convention != Convention.OPENCV:
        query["convention"] = str(convention)
    if frame != CAMERA:
        query["frame"] = frame
    if at_us is not None:
        query["at_us"] = at_us
    return query


def stations() -> Call[StationList]:
    """GET /v1/stations."""
    return _get("/v1/stations", StationList)


def assets() -> Call[AssetList]:
    """GET /v1/assets."""
    return _get("/v1/assets", AssetList)


def asset(name: str, convention: Axes) -> Call[AssetInfo]:
    """GET /v1/assets/{asset}."""
    return _get(f"/v1/assets/{_name(name)}", AssetInfo, view_query(convention))


def part_model(asset_name: str, part: str) -> Call[bytes]:
    """GET /v1/assets/{asset}/parts/{part}.glb."""
    return _bytes(f"/v1/assets/{_name(asset_name)}/parts/{_name(part)}.glb")


def media(path: str) -> Call[bytes]:
    """GET /v1/assets/{asset}/media/{name}.

    Raises:
        ValueError: another server's address, which must not be told the key.
    """
    if not path.startswith("/v1/assets/"):
        raise ValueError(f"{path!r} is not on this server: fetch it without the server's key")
    return _bytes(path)


def server_time(client_sent_at_us: int) -> Call[ServerTime]:
    """GET /v1/time."""
    return _get("/v1/time", ServerTime, {"client_sent_at_us": client_sent_at_us})


def health() -> Call[Health]:
    """GET /healthz."""
    return _get("/healthz", Health)


def ready() -> Call[Health]:
    """GET /readyz."""
    return _get("/readyz", Health)


class StationCalls:
    """The calls of one station; the short paths where it has no name.

    Args:
        station: its name; None for the only one of the server.
    """

    def __init__(self, station: str | None) -> None:
        self.base = "/v1" if station is None else f"/v1/stations/{_name(station)}"

    def poses(
        self, convention: Axes, frame: str, at_us: int | None, is_tagged: bool = True
    ) -> Call[PoseSnapshot]:
        """GET .../poses."""
        query = view_query(convention, frame, at_us)
        return _get(f"{self.base}/poses", PoseSnapshot, query, is_tagged and at_us is None)

    def pose(
        self, part: str, convention: Axes, frame: str, at_us: int | None
    ) -> Call[PartSnapshot]:
        """GET .../poses/{part}."""
        query = view_query(convention, frame, at_us)
        return _get(f"{self.base}/poses/{_name(part)}", PartSnapshot, query, at_us is None)

    def next_poses(
        self, boot_id: str, seq: int, convention: Axes, frame: str, timeout_s: float
    ) -> Call[PoseSnapshot | None]:
        """GET .../poses, by long poll; None when it timed out."""
        after: Query = {"after_seq": seq, "boot_id": boot_id, "timeout_s": timeout_s}
        query: Query = {**view_query(convention, frame), **after}
        return _wait(f"{self.base}/poses", PoseSnapshot, query, timeout_s)

    def assembly(self) -> Call[AssemblyStatus]:
        """GET .../assembly."""
        return _get(f"{self.base}/assembly", AssemblyStatus)

    def next_assembly(
        self, boot_id: str, revision: int, timeout_s: float
    ) -> Call[AssemblyStatus | None]:
        """GET .../assembly, by long poll; None when it timed out."""
        query: Query = {"after_revision": revision, "boot_id": boot_id, "timeout_s": timeout_s}
        return _wait(f"{self.base}/assembly", AssemblyStatus, query, timeout_s)

    def steps(self, convention: Axes, frame: str) -> Call[StepList]:
        """GET .../steps."""
        return _get(f"{self.base}/steps", StepList, view_query(convention, frame))

    def step(self, step: str, convention: Axes, frame: str) -> Call[StepAnswer]:
        """GET .../steps/{step}, or /steps/current."""
        return _get(f"{self.base}/steps/{_name(step)}", StepAnswer, view_query(convention, frame))

    def reset(self) -> Call[CommandResult]:
        """POST .../reset."""
        return _send("POST", f"{self.base}/reset", CommandResult, None)

    def reinitialise(self, parts: Sequence[str]) -> Call[CommandResult]:
        """POST .../reinitialise."""
        body = {"parts": list(parts)}
        return _send("POST", f"{self.base}/reinitialise", CommandResult, body)

    def set_state(self, state: str) -> Call[CommandResult]:
        """PUT .../assembly/state."""
        return _send("PUT", f"{self.base}/assembly/state", CommandResult, {"state": state})

    def anchors(self, convention: Axes) -> Call[AnchorList]:
        """GET .../anchors."""
        return _get(f"{self.base}/anchors", AnchorList, view_query(convention))

    def anchor(self, name: str, convention: Axes) -> Call[AnchorInfo]:
        """GET .../anchors/{anchor}."""
        return _get(f"{self.base}/anchors/{_name(name)}", AnchorInfo, view_query(convention))

    def put_anchor(self, name: str, request: AnchorRequest) -> Call[AnchorInfo]:
        """PUT .../anchors/{anchor}."""
        body = request.model_dump(mode="json")
        return _send("PUT", f"{self.base}/anchors/{_name(name)}", AnchorInfo, body)

    def delete_anchor(self, name: str) -> Call[None]:
        """DELETE .../anchors/{anchor}."""
        path = f"{self.base}/anchors/{_name(name)}"
        return Call("DELETE", path, _nothing, {})

    def picture(self, kind: Literal["frame", "overlay"]) -> Call[Picture]:
        """GET .../frame.jpg or .../overlay.jpg."""
        return Call("GET", f"{self.base}/{kind}.jpg", Picture.of, {})


def _get(
    path: str,
    model: type[ModelT],
    query: Query | None = None,
    is_tagged: bool = False,
) -> Call[ModelT]:
    def read(response: httpx.Response) -> ModelT:
        return parsed(model, response.content, path)

    return Call("GET", path, read, query or {}, is_tagged=is_tagged)


def _wait(path: str, model: type[ModelT], query: Query, timeout_s: float) -> Call[ModelT | None]:
    def read(response: httpx.Response) -> ModelT | None:
        return None if response.status_code == 204 else parsed(model, response.content, path)

    return Call("GET", path, read, query, extra_s=timeout_s)


def _send(method: str, path: str, model: type[ModelT], body: Any) -> Call[ModelT]:
    def read(response: httpx.Response) -> ModelT:
        return parsed(model, response.content, path)

    return Call(method, path, read, {}, body)


def _nothing(_response: httpx.Response) -> None:
    """An answer that says nothing."""


def _bytes(path: str) -> Call[bytes]:
    return Call("GET", path, lambda response: response.content, {})


def _name(name: str) -> str:
    """A name as one segment of a path."""
    return quote(name, safe="")
