"""Anchors: how a client's world lies against the station's camera."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from http import HTTPStatus

from snapfit.server.alignment import Deviation, MeanPose, deviation
from snapfit.server.boards import Board
from snapfit.server.marker_message import MarkerMessage
from snapfit.server.problems import ProblemError
from snapfit.server.rigid import Rigid

DRIFT_M = 0.01
DRIFT_RAD = math.radians(2)
_AGREES_AGAIN = 0.5
_MOST = 32
_revisions = itertools.count(1)


@dataclass
class CameraView:
    """A board as the station's camera sees it: the average of its latest poses."""

    poses: MeanPose = field(default_factory=MeanPose)
    latest: Rigid | None = None
    error_px: float = 0.0
    seen_at_us: int = 0


@dataclass
class Anchor:
    """A client's world.

    Attributes:
        name: in paths.
        board: that the client and the camera both see.
        expires_at_us: unless the client speaks before.
        worlds: `world_from_marker`, as the client told it.
        view: of the camera.
        is_drifting: whether the two have moved against each other.
        drift: how far they are apart now; None before both have seen the board.
        revision: changes whenever the pose does.
    """

    name: str
    board: Board
    expires_at_us: int
    view: CameraView
    worlds: MeanPose = field(default_factory=MeanPose)
    latest: Rigid | None = None
    updated_at_us: int = 0
    is_drifting: bool = False
    drift: Deviation | None = None
    revision: int = 0

    def world_from_camera(self) -> Rigid | None:
        """From both averages; None before both have seen the board."""
        world, camera = self.worlds.mean(), self.view.poses.mean()
        return None if world is None or camera is None else world @ camera.inverse()

    def compare(self) -> bool:
        """Compare what was seen last with the averages; whether drifting has just begun."""
        self.revision = next(_revisions)
        aligned = self.world_from_camera()
        if aligned is None or self.latest is None or self.view.latest is None:
            return False
        # At the marker, where the parts are: an error of the camera's rotation acts over its way.
        self.drift = deviation(self.latest, aligned @ self.view.latest)
        off = max(self.drift.translation_m / DRIFT_M, self.drift.rotation_rad / DRIFT_RAD)
        began = off > 1 and not self.is_drifting
        self.is_drifting = off > (_AGREES_AGAIN if self.is_drifting else 1)
        return began


class Anchors:
    """The anchors of a station.

    Args:
        station: its name.
        now_us: the server's time.
        look_for: told which boards the camera shall look for.
        drifted: told of anchors that begin to drift.
    """

    def __init__(
        self,
        station: str,
        now_us: Callable[[], int],
        look_for: Callable[[list[Board]], None],
        drifted: Callable[[Anchor], None],
    ) -> None:
        self._station = station
        self._now_us = now_us
        self._look_for = look_for
        self._drifted = drifted
        self._anchors: dict[str, Anchor] = {}
        self._views: dict[Board, CameraView] = {}

    def all(self) -> list[Anchor]:
        """Those that have not expired."""
        self.expire()
        return list(self._anchors.values())

    def named(self, name: str) -> Anchor:
        """One of them.

        Raises:
            ProblemError: 404; lists those that there are.
        """
        self.expire()
        if name not in self._anchors:
            names = list(self._anchors)
            told = f"there is {', '.join(names)}" if names else "there is none"
            raise ProblemError(
                HTTPStatus.NOT_FOUND,
                "unknown-anchor",
                f"Station {self._station} has no anchor {name!r}, or it has expired; {told}.",
                anchors=names,
            )
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

    def put(
        self, name: str, board: Board, world: Rigid, *, ttl_s: float, restart: bool
    ) -> tuple[Anchor, bool]:
        """A client says where it sees a board; the anchor, and whether it is new.

        Raises:
            ProblemError: 409, there are too many anchors.
        """
        self.expire()
        anchor = self._anchors.get(name)
        is_new = anchor is None
        if anchor is None or anchor.board != board:
            if anchor is None and len(self._anchors) >= _MOST:
                detail = f"Station {self._station} has {_MOST} anchors: delete one."
                raise ProblemError(HTTPStatus.CONFLICT, "too-many-anchors", detail)
            view = self._views.setdefault(board, CameraView())
            anchor = self._anchors[name] = Anchor(name, board, 0, view)
            self._choose_boards()
        if restart:
            anchor.worlds.clear()
            anchor.is_drifting = False
        now_us = self._now_us()
        anchor.expires_at_us = now_us + round(ttl_s * 1e6)
        anchor.updated_at_us = now_us
        anchor.worlds.add(world)
        anchor.latest = world
        self._compare(anchor)
        return anchor, is_new

    def delete(self, name: str) -> None:
        """Forget an anchor.

        Raises:
            ProblemError: 404, there is none.
        """
        self.named(name)
        del self._anchors[name]
        self._choose_boards()

    def seen(self, message: MarkerMessage) -> None:
        """Take in what the camera sees."""
        for marker in message.seen:
            view = self._views.get(marker.board)
            if view is None:
                continue
            view.latest = Rigid(marker.position, marker.orientation)
            view.poses.add(view.latest)
            view.error_px, view.seen_at_us = marker.error_px, message.captured_at_us
            for anchor in self._anchors.values():
                if anchor.view is view:
                    self._compare(anchor)

    def expire(self) -> None:
        """Forget those that nobody spoke for."""
        now_us = self._now_us()
        expired = [name for name, it in self._anchors.items() if it.expires_at_us <= now_us]
        for name in expired:
            del self._anchors[name]
        if expired:
            self._choose_boards()

    def _compare(self, anchor: Anchor) -> None:
        if anchor.compare():
            self._drifted(anchor)

    def _choose_boards(self) -> None:
        wanted = {anchor.board for anchor in self._anchors.values()}
        self._views = {board: view for board, view in self._views.items() if board in wanted}
        self._look_for(list(self._views))
