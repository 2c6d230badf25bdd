"""Requests made from the committed document alone: the server answers as it says, and never 5xx."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from harness import Server, running
from hypothesis import HealthCheck, Phase, settings

schemathesis = pytest.importorskip("schemathesis")

DOCUMENT = Path(__file__).parents[2] / "openapi" / "openapi.json"
# Streams never end.
SCHEMA = schemathesis.openapi.from_path(DOCUMENT).exclude(path_regex=r"(events|\.mjpeg)$")
REQUESTS = 2000
TRIES = 5
LATE = ("no-picture", "worker-unavailable", "not-ready")
# A quaternion's length, and markers that fit a board, are rules that JSON Schema cannot express.
RULES_BETWEEN_NUMBERS = "/anchors/{anchor}"
EASY = settings(
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)


@pytest.fixture(scope="module")
def target() -> Iterator[Server]:
    """One of its own: its state is changed at random."""
    with running("finds") as server:
        yield server.wait_ready()


def check(case: Any, target: Server) -> None:
    if case.query and float_or_none(case.query.get("timeout_s")) is not None:
        case.query["timeout_s"] = min(float(case.query["timeout_s"]), 0.05)
    # On loopback no key is needed, whatever is sent.
    excluded = [schemathesis.checks.ignored_auth]
    if case.path.endswith(RULES_BETWEEN_NUMBERS):
        excluded.append(schemathesis.checks.positive_data_acceptance)
    response = answer_of(case, target)
    case.validate_response(response, excluded_checks=excluded)
    if response.status_code >= 400:
        assert response.headers["content-type"] == ["application/problem+json"]


def answer_of(case: Any, target: Server) -> Any:
    """Once it is not late: on a busy machine it may say so, and ask to come again."""
    for last in (*[False] * (TRIES - 1), True):
        response = case.call(base_url=f"http://127.0.0.1:{target.port}", timeout=70)
        is_late = response.status_code == 503 and any(
            f"problem:{it}" in response.text for it in LATE
        )
        if last or not is_late:
            return response
        time.sleep(1)
    raise AssertionError("never reached: the last answer is returned")


def float_or_none(value: Any) -> float | None:
    try:
        return float(value)
    except (TypeError, ValueError):
        return None


@SCHEMA.parametrize()
@settings(EASY, max_examples=3)
def test_a_few_requests_to_every_operation(case: Any, target: Server) -> None:
    check(case, target)


@pytest.mark.slow
@SCHEMA.parametrize()
@settings(EASY, max_examples=-(-REQUESTS // 40))
def test_two_thousand_requests(case: Any, target: Server) -> None:
    check(case, target)


def test_every_operation_is_requested_often_enough() -> None:
    operations = sum(1 for _ in SCHEMA.get_all_operations())
    assert operations >= 40  # so that 50 requests each are 2,000
