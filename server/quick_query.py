"""Queries of the fast lane: understood once, however many clients send the same."""

from __future__ import annotations

from functools import lru_cache
from typing import Protocol
from urllib.parse import parse_qsl

from pydantic import ValidationError

from snapfit.server.answers import Answer
from snapfit.server.routes.assembly_query import AssemblyQuery
from snapfit.server.routes.pose_query import PoseQuery
from snapfit.server.station import Station
from snapfit.server.view import CAMERA

_RESOURCES = ("poses", "assembly")
_LONGEST = 300
_REMEMBERED = 512


class QuickQuery(Protocol):
    """A query that can be answered ahead of the routes.

    Attributes:
        route: the resource, as the metrics name it.
    """

    route: str

    async def is_new(self, station: Station) -> bool:
        """Wait for what is asked for; False if it did not come in time."""

    def answer(self, station: Station) -> Answer:
        """What there is now.

        Raises:
            ProblemError: nothing, or not in that view.
        """


class QuickPoses:
    """Of all parts."""

    route = "/v1/poses"

    def __init__(self, query: PoseQuery) -> None:
        self._query = query

    async def is_new(self, station: Station) -> bool:
        """As in `QuickQuery`."""
        return await self._query.is_new(station)

    def answer(self, station: Station) -> Answer:
        """As in `QuickQuery`."""
        return station.poses(self._query.view(station))


class QuickAssembly:
    """Of the assembly."""

    route = "/v1/assembly"

    def __init__(self, query: AssemblyQuery) -> None:
        self._query = query

    async def is_new(self, station: Station) -> bool:
        """As in `QuickQuery`."""
        return await self._query.is_new(station)

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
    return _understood(what, query)


@lru_cache(maxsize=_REMEMBERED)
def _understood(what: str, query: bytes) -> QuickQuery | None:
    pairs = parse_qsl(query.decode("latin-1"), keep_blank_values=True)
    given = dict(pairs)
    if len(given) != len(pairs):
        return None
    try:
        if what == "assembly":
            return QuickAssembly(AssemblyQuery.model_validate(given))
        return _quick_poses(PoseQuery.model_validate(given))
    except ValidationError:
        return None


def _quick_poses(query: PoseQuery) -> QuickPoses | None:
    if query.at_us is not None:
        return None  # another time in each request: there is nothing ready-made
    if query.after_seq is not None and query.frame != CAMERA:
        return None  # the anchor may be gone after the wait, which is a problem to be told
    return QuickPoses(query)
