"""Queries of the fast lane: understood once, however many clients send the same."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Protocol
from urllib.parse import parse_qsl

from pydantic import ValidationError

from snapfit.server.answers import Answer
from snapfit.server.routes.assembly_query import AssemblyQuery
from snapfit.server.routes.pose_query import LARGEST_INTEGER, PoseQuery, check_at_us
from snapfit.server.station import Station
from snapfit.server.view import CAMERA
from snapfit.server.waiting import Tell, Waiting

_RESOURCES = ("poses", "assembly")
_LONGEST = 300
_REMEMBERED = 512
_AT_US = re.compile(rb"(?:\A|&)at_us=([0-9]{1,16})(?=&|\Z)")


class QuickQuery(Protocol):
    """A query that can be answered ahead of the routes.

    Attributes:
        route: the resource, as the metrics name it.
    """

    route: str

    def tell_new(self, station: Station, tell: Tell) -> Waiting | None:
        """Have told when what is asked for is there; None where there is nothing to wait for."""

    def answer(self, station: Station) -> Answer:
        """What there is now.

        Raises:
            ProblemError: nothing, or not in that view, or not at that time.
        """


class QuickPoses:
    """Of all parts.

    Args:
        query: of the latest snapshot, whatever `at_us` says.
    """

    route = "/v1/poses"

    def __init__(self, query: PoseQuery) -> None:
        self._query = query

    def tell_new(self, station: Station, tell: Tell) -> Waiting | None:
        """As in `QuickQuery`."""
        return self._query.tell_new(station, tell)

    def answer(self, station: Station) -> Answer:
        """As in `QuickQuery`."""
        return station.poses(self._query.view(station))


class QuickPosesAt:
    """Of all parts at another time, which is another one in each request.

    Args:
        query: of the poses.
        at_us: the time, whatever the query says.
    """

    route = "/v1/poses"

    def __init__(self, query: PoseQuery, at_us: int) -> None:
        self._query = query
        self._at_us = at_us

    def tell_new(self, station: Station, tell: Tell) -> Waiting | None:
        """As in `QuickQuery`: it waits for nothing."""
        del station, tell
        return None

    def answer(self, station: Station) -> Answer:
        """As in `QuickQuery`."""
        check_at_us(self._at_us, station.now_us())
        return station.poses(self._query.view(station), self._at_us)


class QuickAssembly:
    """Of the assembly."""

    route = "/v1/assembly"

    def __init__(self, query: AssemblyQuery) -> None:
        self._query = query

    def tell_new(self, station: Station, tell: Tell) -> Waiting | None:
        """As in `QuickQuery`."""
        return self._query.tell_new(station, tell)

    def answer(self, station: Station) -> Answer:
        """As in `QuickQuery`."""
        return station.assembly()


def quick_query(what: str, query: bytes) -> QuickQuery | None:
    """What is asked for, in short; None for what the routes are to deal with.

    Args:
        what: the last part of the path.
        query: behind the question mark.
    """
    if what not in _RESOURCES or len(query) > _LONGEST:
        return None
    timed = _AT_US.search(query) if what == "poses" else None
    if timed is None:
        return _understood(what, query)
    at_us = int(timed[1])
    query = query[: timed.start()] + query[timed.end() :]
    poses = _poses_query(query)
    # To wait, and for another time: what that means is the routes' to tell.
    if poses is None or poses.after_seq is not None or at_us > LARGEST_INTEGER:
        return None
    return QuickPosesAt(poses, at_us)


@lru_cache(maxsize=_REMEMBERED)
def _understood(what: str, query: bytes) -> QuickQuery | None:
    if what == "assembly":
        given = _given(query)
        try:
            return None if given is None else QuickAssembly(AssemblyQuery.model_validate(given))
        except ValidationError:
            return None
    poses = _poses_query(query)
    if poses is None or (poses.after_seq is not None and poses.frame != CAMERA):
        return None  # the anchor may be gone after the wait, which is a problem to be told
    return QuickPoses(poses)


@lru_cache(maxsize=_REMEMBERED)
def _poses_query(query: bytes) -> PoseQuery | None:
    """Without `at_us`; None for one that is wrong, or that has another one in it."""
    given = _given(query)
    if given is None or "at_us" in given:
        return None
    try:
        return PoseQuery.model_validate(given)
    except ValidationError:
        return None


def _given(query: bytes) -> dict[str, str] | None:
    """Names and values; None where a name comes twice."""
    pairs = parse_qsl(query.decode("latin-1"), keep_blank_values=True)
    given = dict(pairs)
    return given if len(given) == len(pairs) else None
