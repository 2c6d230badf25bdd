"""The query of poses: convention, frame, time, and how long to wait for another snapshot."""

from __future__ import annotations

from http import HTTPStatus
from typing import Annotated

from fastapi import Depends, Query
from pydantic import BaseModel, ConfigDict, Field

from snapfit.server.conventions import Convention
from snapfit.server.problems import ProblemError
from snapfit.server.station import Station
from snapfit.server.view import CAMERA, View
from snapfit.server.waiting import Tell, Waiting

LONGEST_WAIT_S = 60.0
_FARTHEST_US = 10_000_000
LARGEST_INTEGER = 2**53
"""Beyond, a JavaScript number is no integer."""


ANCHOR_NAME = r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}"
_ANCHOR = "anchor:"


class ConventionQuery(BaseModel):
    """Along which axes an answer is to be given."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    convention: Convention = Field(
        default=Convention.OPENCV,
        description="Axes and handedness: opencv and ros_optical x right, y down, z forward; "
        "openxr x right, y up, z backward; unity x right, y up, z forward, left-handed; ros "
        "x forward, y left, z up.",
    )


class ViewQuery(ConventionQuery):
    """How poses are to be given."""

    frame: str = Field(
        default=CAMERA,
        pattern=rf"^({CAMERA}|{_ANCHOR}{ANCHOR_NAME})$",
        description="The frame that poses are given in: `camera`, or `anchor:ID`, the world of "
        "the client that has put this anchor.",
    )

    def view(self, station: Station) -> View:
        """As the answers understand it.

        Raises:
            ProblemError: 404, there is no such anchor; 409, it is not aligned yet.
        """
        if self.frame == CAMERA:
            return View(self.convention)
        name = self.frame.removeprefix(_ANCHOR)
        pose, revision = station.news.anchors.frame_from_camera(name)
        return View(self.convention, self.frame, pose, revision)


class PoseQuery(ViewQuery):
    """How poses are to be given, for when, and after which snapshot."""

    at_us: Annotated[int, Field(ge=0, le=LARGEST_INTEGER)] | None = Field(
        default=None,
        description="Unix time by the server's clock, microseconds: poses are extrapolated to it, "
        "at most 100 ms from the exposure. Beyond that they are given for the nearest time within, "
        "and `at_clamped` is true. More than 10 s from now is refused.",
    )
    after_seq: Annotated[int, Field(ge=0, le=LARGEST_INTEGER)] | None = Field(
        default=None,
        description="Wait for a snapshot after this one of `boot_id`, or until `stale` changes: "
        "204 if there is none within `timeout_s`.",
    )
    boot_id: str | None = Field(
        default=None,
        max_length=64,
        description="Of the snapshot that `after_seq` counts from. Without it, any snapshot with "
        "another `seq` is waited for.",
    )
    timeout_s: float = Field(
        default=20.0, ge=0, le=LONGEST_WAIT_S, description="How long to wait, seconds."
    )

    async def is_new(self, station: Station) -> bool:
        """Wait for the snapshot that is asked for; False if there is none in time."""
        if self.after_seq is None:
            return True
        return await station.watch.snapshot_after(self.boot_id, self.after_seq, self.timeout_s)

    def tell_new(self, station: Station, tell: Tell) -> Waiting | None:
        """The same without a task; None where there is nothing to wait for."""
        if self.after_seq is None:
            return None
        return station.watch.tell_snapshot_after(self.boot_id, self.after_seq, self.timeout_s, tell)


def check_at_us(at_us: int, now_us: int) -> None:
    """Whether poses can be wanted for this time, both Unix time by the server's clock.

    Raises:
        ProblemError: 409, it is so far off that the client's clock must be wrong.
    """
    if abs(at_us - now_us) > _FARTHEST_US:
        raise ProblemError(
            HTTPStatus.CONFLICT,
            "at-out-of-range",
            f"at_us is {(at_us - now_us) / 1e6:.1f} s from now by the server's clock: "
            "synchronise with GET /v1/time.",
            now_us=now_us,
        )


async def _convention_query(query: Annotated[ConventionQuery, Query()]) -> ConventionQuery:
    return query


async def _view_query(query: Annotated[ViewQuery, Query()]) -> ViewQuery:
    return query


async def _pose_query(query: Annotated[PoseQuery, Query()]) -> PoseQuery:
    return query


WantedConvention = Annotated[ConventionQuery, Depends(_convention_query)]
WantedView = Annotated[ViewQuery, Depends(_view_query)]
WantedPoses = Annotated[PoseQuery, Depends(_pose_query)]
