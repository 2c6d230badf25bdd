"""What is answered ahead of the routes is what the routes answer."""

from __future__ import annotations

from typing import Any

import httpx
import pytest
from harness import Server, wait_for

from snapfit.server.quick_query import QuickPosesAt, quick_query

NOT_COMPARED = {"date", "x-request-id", "content-length"}
QUERIES = {
    "/v1/poses": ["", "?convention=unity", "?frame=camera&convention=ros", "?timeout_s=3"],
    "/v1/stations/bench-1/poses": ["?convention=openxr", "?after_seq=1&timeout_s=1"],
    "/v1/assembly": ["", "?after_revision=0", "?after_revision=1000000&timeout_s=0"],
    "/v1/stations/bench-1/assembly": [""],
}
CASES = [(path, query) for path, queries in QUERIES.items() for query in queries]


def both_ways(server: Server, path: str, **headers: str) -> tuple[httpx.Response, httpx.Response]:
    """Ahead of the routes, and by them: there go pages that say where they are from."""
    origin = f"http://127.0.0.1:{server.port}"
    fast = server.get(path, headers=headers)
    return fast, server.get(path, headers={**headers, "Origin": origin})


def without_age(response: httpx.Response) -> dict[str, Any] | None:
    if not response.content:
        return None
    body: dict[str, Any] = response.json()
    age_us = body.pop("age_us")
    assert 0 <= age_us < 5_000_000
    return body


def headers_of(response: httpx.Response) -> dict[str, str]:
    return {name: value for name, value in response.headers.items() if name not in NOT_COMPARED}


@pytest.mark.parametrize(("path", "query"), CASES)
def test_both_ways_give_the_same(server: Server, path: str, query: str) -> None:
    def same_snapshot() -> tuple[httpx.Response, httpx.Response] | None:
        fast, slow = both_ways(server, path + query)
        return (fast, slow) if without_age(fast) == without_age(slow) else None

    fast, slow = wait_for(same_snapshot)
    assert fast.status_code == slow.status_code
    assert headers_of(fast) == headers_of(slow)
    assert fast.headers["x-request-id"] != slow.headers["x-request-id"]


@pytest.mark.parametrize("path", list(QUERIES))
def test_what_the_client_has_is_not_sent_again_either_way(server: Server, path: str) -> None:
    fast, slow = both_ways(server, path, **{"If-None-Match": "*"})
    assert fast.status_code == slow.status_code == 304
    assert headers_of(fast).keys() == headers_of(slow).keys()


def test_another_time_is_answered_the_same_both_ways(server: Server) -> None:
    def same_snapshot() -> tuple[httpx.Response, httpx.Response] | None:
        at_us = server.get("/v1/time").json()["sent_at_us"]
        fast, slow = both_ways(server, f"/v1/poses?convention=unity&at_us={at_us}&frame=camera")
        return (fast, slow) if without_age(fast) == without_age(slow) else None

    fast, slow = wait_for(same_snapshot)
    assert fast.status_code == slow.status_code == 200
    assert headers_of(fast) == headers_of(slow)
    assert fast.json()["at_us"] - fast.json()["captured_at_us"] <= 100_000


def test_a_time_far_off_is_told_by_the_routes(server: Server) -> None:
    fast, slow = both_ways(server, "/v1/poses?at_us=5")
    assert fast.status_code == slow.status_code == 409
    assert fast.json()["type"] == slow.json()["type"] == "urn:snapfit:problem:at-out-of-range"


@pytest.mark.parametrize(
    "query",
    ["?convention=unreal", "?convention=", "?speed=1", "?frame=anchor:nowhere", "?after_seq=-1"],
)
def test_what_is_wrong_is_told_by_the_routes(server: Server, query: str) -> None:
    fast, slow = both_ways(server, f"/v1/poses{query}")
    assert fast.status_code == slow.status_code
    assert fast.status_code in (404, 422)
    assert fast.headers["content-type"] == "application/problem+json"
    assert fast.json() == slow.json()


def test_a_time_is_found_wherever_it_stands() -> None:
    for query in (b"at_us=5", b"at_us=5&convention=ros", b"convention=ros&at_us=5"):
        assert isinstance(quick_query("poses", query), QuickPosesAt)


def test_the_same_query_is_understood_once() -> None:
    query = quick_query("poses", b"convention=unity&after_seq=7")
    assert query is not None
    assert quick_query("poses", b"convention=unity&after_seq=7") is query
    assert quick_query("poses", b"convention=unity&after_seq=8") is not query


@pytest.mark.parametrize(
    ("what", "query"),
    [
        ("poses", b"at_us=5&at_us=6"),
        ("poses", b"at_us=5&after_seq=1"),
        ("poses", b"at_us=99999999999999999"),
        ("poses", b"at_us=9999999999999999"),
        ("poses", b"at_us=-1"),
        ("poses", b"at_us="),
        ("poses", b"at_us=+5"),
        ("poses", b"hat_us=5"),
        ("assembly", b"at_us=5"),
        ("poses", b"convention=unity&convention=ros"),
        ("poses", b"frame=anchor:desk&after_seq=1"),
        ("poses", b"frame=%63amera&key=sf_00000000"),
        ("poses", b"boot_id=" + 300 * b"x"),
        ("poses", b"\xff"),
        ("assembly", b"convention=unity"),
        ("assembly", b"after_revision=one"),
        ("steps", b""),
        ("", b""),
    ],
)
def test_all_else_is_for_the_routes(what: str, query: bytes) -> None:
    assert quick_query(what, query) is None
