"""Anchors: how a client's world lies against the station's camera."""

from __future__ import annotations

import hashlib
import math
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from http import HTTPStatus

from snapfit.server.alignment import Deviation, MeanPose, deviation
from snapfit.server.anchor_record import AnchorRecord, ViewRecord, anchor_record
from snapfit.server.anchor_shelf import AnchorShelf, Records
from snapfit.server.boards import Board
from snapfit.server.problems import ProblemError
from snapfit.server.rigid import Rigid

DRIFT_M = 0.01
DRIFT_RAD = math.radians(2)
_AGREES_AGAIN = 0.5
_MOST = 32


@dataclass
class CameraView:
    """A board as the station's camera sees it: the average of its latest poses."""

    poses: MeanPose = field(default_factory=MeanPose)
    error_px: float = 0.0
    seen_at_us: int = 0

    @staticmethod
    def of(record: ViewRecord | None) -> CameraView:
        """What is known of it; nothing, where the camera has not seen it."""
        if record is None:
            return CameraView()
        poses = MeanPose([Rigid(*pose) for pose in record.poses])
        return CameraView(poses, record.error_px, record.seen_at_us)


class Anchor:
    """A client's world.

    Attributes:
        record: what the client has put.
        worlds: the average of `world_from_marker`.
        view: of the camera.
        is_drifting: whether the two have moved against each other.
        drift: how far they are apart now; None before both have seen the board.
    """

    def __init__(self, record: AnchorRecord, view: ViewRecord | None) -> None:
        self.is_drifting = False
        self.drift: Deviation | None = None
        self._seen: ViewRecord | None = None
        self._know(record, view)

    def _know(self, record: AnchorRecord, view: ViewRecord | None) -> None:
        self.record = record
        self.worlds = MeanPose([Rigid(*pose) for pose in record.worlds])
        self._seen = view
        self.view = CameraView.of(view)
        world, camera = self.worlds.mean, self.view.poses.mean
        self._aligned = None if world is None or camera is None else world @ camera.inverse()

    @property
    def name(self) -> str:
        """In paths."""
        return self.record.anchor

    @property
    def revision(self) -> int:
        """Tells its pose from others, on all machines alike."""
        if self._aligned is None:
            return 0
        numbers = struct.pack("<7d", *self._aligned.position, *self._aligned.orientation)
        return int.from_bytes(hashlib.blake2b(numbers, digest_size=6).digest())

    def world_from_camera(self) -> Rigid | None:
        """From both averages; None before both have seen the board."""
        return self._aligned

    def learn(self, record: AnchorRecord, view: ViewRecord | None) -> bool:
        """Take in what is known now; whether it has just begun to drift."""
        if record is not self.record or view is not self._seen:
            if record.restarts != self.record.restarts:
                self.is_drifting = False
            self._know(record, view)
            return self._compare()
        return False

    def _compare(self) -> bool:
        """Compare what was seen last with the averages."""
        said, seen = self.worlds.latest, self.view.poses.latest
        if self._aligned is None or said is None or seen is None:
            return False
        # At the marker, where the parts are: an error of the camera's rotation acts over its way.
        self.drift = deviation(said, self._aligned @ seen)
        off = max(self.drift.translation_m / DRIFT_M, self.drift.rotation_rad / DRIFT_RAD)
        began = off > 1 and not self.is_drifting
        self.is_drifting = off > (_AGREES_AGAIN if self.is_drifting else 1)
        return began


class Anchors:
    """The anchors of a station.

    Args:
        station: its name.
        now_us: the server's time.
        shelf: where they are kept.
        look_for: told which boards the camera shall look for.
        drifted: told of anchors that begin to drift.
    """

    def __init__(
        self,
        station: str,
        now_us: Callable[[], int],
        shelf: AnchorShelf,
        look_for: Callable[[list[Board]], None],
        drifted: Callable[[Anchor], None],
    ) -> None:
        self._station = station
        self._now_us = now_us
        self._shelf = shelf
        self._look_for = look_for
        self._drifted = drifted
        self._anchors: dict[str, Anchor] = {}
        self._boards: frozenset[Board] = frozenset()
        self._known: tuple[Records, Mapping[Board, ViewRecord]] | None = None

    def all(self) -> list[Anchor]:
        """Those that have not expired."""
        self.update()
        return list(self._anchors.values())

    def named(self, name: str) -> Anchor:
        """One of them.

        Raises:
            ProblemError: 404; lists those that there are.
        """
        self.update()
        if name not in self._anchors:
            raise self._unknown(name, list(self._anchors))
        return self._anchors[name]

    def frame_from_camera(self, name: str) -> tuple[Rigid, int]:
        """`world_from_camera` of an anchor, and its revision.

        Raises:
            ProblemError: 404, there is none; 409, the camera has not seen its board yet.
        """
        anchor = self.named(name)
        pose = anchor.world_from_camera()
        if pose is None:
            detail = f"The camera of station {self._station} has not seen the board of {name} yet."
            raise ProblemError(HTTPStatus.CONFLICT, "anchor-not-aligned", detail)
        return pose, anchor.revision

    async def put(
        self, name: str, board: Board, world: Rigid, *, ttl_s: float, restart: bool
    ) -> tuple[Anchor, bool]:
        """A client says where it sees a board; the anchor, and whether it is new.

        Raises:
            ProblemError: 409, there are too many anchors; 503, they cannot be kept now.
        """
        is_new = False

        def change(records: Records) -> Records:
            nonlocal is_new
            now_us = self._now_us()
            alive = _alive(records, now_us)
            before = alive.get(name)
            is_new = before is None
            if before is not None:
                put = before.with_world(board, world, now_us=now_us, ttl_s=ttl_s, restart=restart)
            elif len(alive) < _MOST:
                put = anchor_record(name, board, world, now_us=now_us, ttl_s=ttl_s)
            else:
                detail = f"Station {self._station} has {_MOST} anchors: delete one."
                raise ProblemError(HTTPStatus.CONFLICT, "too-many-anchors", detail)
            return {**alive, name: put}

        await self._shelf.change(change)
        return self.named(name), is_new

    async def delete(self, name: str) -> None:
        """Forget an anchor.

        Raises:
            ProblemError: 404, there is none; 503, it cannot be deleted now.
        """

        def change(records: Records) -> Records:
            alive = _alive(records, self._now_us())
            if name not in alive:
                raise self._unknown(name, list(alive))
            return {other: record for other, record in alive.items() if other != name}

        await self._shelf.change(change)
        self.update()

    def update(self) -> None:
        """Take in what the shelf has now, and forget those that nobody spoke for."""
        known = self._shelf.records, self._shelf.views
        alive = _alive(known[0], self._now_us())
        is_same = self._known is not None and all(
            a is b for a, b in zip(known, self._known, strict=True)
        )
        if is_same and len(alive) == len(self._anchors):
            return
        self._known = known
        self._anchors = {it: self._anchors[it] for it in self._anchors if it in alive}
        for name, record in alive.items():
            self._learn(name, record, known[1].get(record.board))
        boards = frozenset(record.board for record in alive.values())
        if boards != self._boards:
            self._boards = boards
            wanted = list(dict.fromkeys(record.board for record in alive.values()))
            self._shelf.keep(wanted)
            self._look_for(wanted)

    def _learn(self, name: str, record: AnchorRecord, view: ViewRecord | None) -> None:
        anchor = self._anchors.get(name)
        if anchor is None or anchor.record.board != record.board:
            self._anchors[name] = Anchor(record, None)
            anchor = self._anchors[name]
        if anchor.learn(record, view):
            self._drifted(anchor)

    def _unknown(self, name: str, names: list[str]) -> ProblemError:
        told = f"there is {', '.join(names)}" if names else "there is none"
        return ProblemError(
            HTTPStatus.NOT_FOUND,
            "unknown-anchor",
            f"Station {self._station} has no anchor {name!r}, or it has expired; {told}.",
            anchors=names,
        )


def _alive(records: Records, now_us: int) -> dict[str, AnchorRecord]:
    return {name: record for name, record in records.items() if record.expires_at_us > now_us}
