"""Logs: one line an event, request ids, and no secrets."""

from __future__ import annotations

import io
import json
import logging
import os
import signal
from pathlib import Path
from typing import Any

import pytest
from harness import Server, running, wait_for

from snapfit.server.logs.context import id_for_request, request_id
from snapfit.server.logs.formats import JsonFormatter, TextFormatter
from snapfit.server.logs.secrets import without_secrets
from snapfit.server.security.key_file import add_key
from snapfit.server.security.key_hash import id_of, new_key
from snapfit.server.security.roles import Role


def logged(formatter: logging.Formatter, **extra: Any) -> str:
    stream = io.StringIO()
    handler = logging.StreamHandler(stream)
    handler.setFormatter(formatter)
    logger = logging.Logger("snapfit.test")
    logger.addHandler(handler)
    try:
        int("two\nlines")
    except ValueError:
        logger.exception("it %s", "failed", extra=extra)
    return stream.getvalue()


def test_an_event_is_one_line_of_json() -> None:
    token = request_id.set("abc")
    try:
        text = logged(JsonFormatter(), station="bench-1", path=Path("x"))
    finally:
        request_id.reset(token)
    assert text.count("\n") == 1
    event = json.loads(text)
    assert (event["level"], event["message"], event["request_id"]) == ("error", "it failed", "abc")
    assert (event["station"], event["path"]) == ("bench-1", "x")
    assert "ValueError: invalid" in event["exception"]
    assert event["at"].endswith("+00:00")


def test_text_is_for_people() -> None:
    text = logged(TextFormatter(), station="bench-1")
    assert "ERROR it failed [station=bench-1]" in text
    assert "ValueError: invalid" in text


@pytest.mark.parametrize(
    ("text", "hidden"),
    [
        pytest.param(f"key {new_key()}", "_***", id="key"),
        ("Authorization: Bearer abcdefgh12345", "Bearer ***"),
        ("Cookie: snapfit_session=12345678.99.abcdef", "snapfit_session= ***"),
        ("cannot reach redis://user:hunter22@10.0.0.1:6379/0", "redis://user:***@10.0.0.1:6379/0"),
    ],
)
def test_secrets_are_taken_out(text: str, hidden: str) -> None:
    told = without_secrets(text)
    assert hidden in told
    assert "hunter22" not in told
    key = text.rpartition(" ")[2]
    assert id_of(key) is None or (key not in told and (id_of(key) or "") in told)


@pytest.mark.parametrize("given", ["a" * 65, "", "a b", "a\nb", "<x>", "\xe4", None])
def test_a_strange_id_is_replaced(given: str | None) -> None:
    assert id_for_request(given) != given
    assert id_for_request("trace-1.2_3") == "trace-1.2_3"


def events(err: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in err.splitlines()]


def worker_of(server: Server, headers: dict[str, str]) -> dict[str, Any]:
    worker: dict[str, Any] = server.get("/v1/stations/bench-1", headers=headers).json()["worker"]
    return worker


def test_the_server_and_its_worker_log_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    key = add_key(tmp_path / "keys.json", "foreman", Role.OPERATE)
    for name, value in {
        "LOG_FORMAT": "json",
        "LOG_LEVEL": "info",
        "SECURITY__KEYS": "on",
        "SECURITY__KEYS_FILE": str(tmp_path / "keys.json"),
    }.items():
        monkeypatch.setenv(f"SNAPFIT_{name}", value)
    headers = {"Authorization": f"Bearer {key}"}
    with running() as server:
        wait_for(server.answers)
        wait_for(lambda: server.get("/readyz", headers=headers).status_code == 200)
        own = server.client.post("/v1/poses", headers={**headers, "X-Request-Id": "try-7"})
        assert own.headers["x-request-id"] == "try-7"
        given = [server.get("/v1/poses", params={"key": key}).headers["x-request-id"] for _ in "ab"]
        assert len(set(given)) == 2
        server.get("/v1/poses", headers={"Authorization": f"Bearer {new_key()}"})
        worker = worker_of(server, headers)
        os.kill(worker["pid"], signal.SIGKILL)
        wait_for(lambda: worker_of(server, headers)["restarts"] >= 1)
        _, _, err = server.end()
    assert key not in err
    assert key.split("_")[2] not in err
    told = events(err)
    (acted,) = [event for event in told if event.get("request_id") == "try-7"]
    assert (acted["message"], acted["status"], acted["key"]) == ("POST /v1/poses", 405, "foreman")
    assert acted["ms"] > 0
    assert any(event.get("status") == 401 for event in told)
    assert any("starting it again" in event["message"] for event in told)
    tracking = next(event for event in told if "tracking 8 parts" in event["message"])
    assert (tracking["station"], tracking["boot_id"]) == ("bench-1", worker["boot_id"])
    assert tracking["process"] == worker["pid"]


def test_a_crash_of_a_worker_is_one_event(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SNAPFIT_LOG_FORMAT", "json")
    with running("crash") as server:
        wait_for(server.answers)
        wait_for(lambda: server.worker()["restarts"] >= 1)
        _, _, err = server.end()
    crash = next(event for event in events(err) if event["level"] == "critical")
    assert "RuntimeError: a bug in a source" in crash["exception"]
