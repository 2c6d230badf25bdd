"""A guarded server, from outside: who gets in, who does not, and what every answer carries."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from harness import Server, once_there, running, wait_for
from patience import within

from snapfit.clients.python import Client, KeyNeededError, RoleNeededError, WrongKeyError
from snapfit.server.schemas_base import Problem
from snapfit.server.security.key_file import add_key, remove_key
from snapfit.server.security.key_hash import new_key
from snapfit.server.security.roles import Role


class Guarded:
    """A server that needs keys, and two of them."""

    def __init__(self, server: Server, path: Path, reader: str, operator: str) -> None:
        self.server = server
        self.path = path
        self.reader = {"Authorization": f"Bearer {reader}"}
        self.operator = {"Authorization": f"Bearer {operator}"}
        self.key = reader

    def anew(self) -> httpx.Client:
        """A client without cookies."""
        return httpx.Client(base_url=self.server.client.base_url, timeout=60)


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guarded]:
    path = tmp_path_factory.mktemp("keys") / "keys.json"
    reader = add_key(path, "headset", Role.READ)
    operator = add_key(path, "foreman", Role.OPERATE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SNAPFIT_SECURITY__KEYS", "on")
        patch.setenv("SNAPFIT_SECURITY__KEYS_FILE", str(path))
        patch.setenv("SNAPFIT_SECURITY__CORS_ORIGINS", "https://dash.example")
        with running() as server:
            it = Guarded(server, path, reader, operator)
            wait_for(server.answers)
            wait_for(lambda: server.get("/readyz", headers=it.reader).status_code == 200)
            yield it


def assert_problem(answer: httpx.Response, status: int, kind: str) -> Problem:
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    problem = Problem.model_validate_json(answer.content)
    assert problem.type == f"urn:snapfit:problem:{kind}"
    return problem


@pytest.mark.parametrize(
    "path", ["/v1/poses", "/v1/stations", "/v1/frame.jpg", "/readyz", "/v1/time", "/nothing"]
)
def test_nothing_is_told_without_a_key(guarded: Guarded, path: str) -> None:
    answer = guarded.server.get(path)
    assert_problem(answer, 401, "key-needed")
    assert answer.headers["www-authenticate"].startswith("Bearer")
    assert "bench-1" not in answer.text


@pytest.mark.parametrize(
    "path", ["/", "/page.js", "/docs", "/docs.js", "/openapi.json", "/healthz"]
)
def test_what_holds_no_secret_is_open(guarded: Guarded, path: str) -> None:
    assert guarded.server.get(path).status_code == 200


def test_a_key_opens(guarded: Guarded) -> None:
    for path in ("/v1/poses", "/v1/poses/jaw", "/v1/frame.jpg"):
        answer = once_there(lambda path=path: guarded.server.get(path, headers=guarded.reader))
        assert answer.status_code == 200


def test_who_reads_does_not_operate(guarded: Guarded) -> None:
    for method in ("POST", "PUT", "DELETE", "PATCH"):
        ask = guarded.server.client.request
        assert_problem(ask(method, "/v1/poses", headers=guarded.reader), 403, "role-needed")
        assert ask(method, "/v1/poses", headers=guarded.operator).status_code == 405


def test_the_python_client_sends_its_key_everywhere(
    guarded: Guarded, monkeypatch: pytest.MonkeyPatch
) -> None:
    url = str(guarded.server.client.base_url)
    monkeypatch.delenv("SNAPFIT_KEY", raising=False)
    with Client(url) as client:
        for ask in (client.poses, lambda: next(client.follow()), lambda: next(client.events())):
            with pytest.raises(KeyNeededError, match="SNAPFIT_KEY"):
                ask()
    with Client(url, key=new_key()) as client, pytest.raises(WrongKeyError):
        next(client.follow(way="poll"))
    monkeypatch.setenv("SNAPFIT_KEY", guarded.key)
    for address in (url, f"{url}/?key={guarded.key}"):
        with Client(address) as client:
            assert next(client.follow()).station == client.info().station == "bench-1"
            assert guarded.key not in repr(client._transport.connection)
            with pytest.raises(RoleNeededError):
                client.reset()


def test_a_browser_gets_a_session_for_its_key(guarded: Guarded) -> None:
    with guarded.anew() as browser:
        answer = browser.post("/v1/session", json={"key": guarded.key})
        assert (answer.status_code, answer.json()["role"]) == (200, "read")
        cookie = answer.headers["set-cookie"]
        assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(cookie.split("; "))
        assert guarded.key not in cookie
        assert once_there(lambda: browser.get("/v1/frame.jpg")).status_code == 200
        assert_problem(browser.post("/v1/poses"), 403, "role-needed")
        assert browser.delete("/v1/session").status_code == 204
        assert_problem(browser.get("/v1/poses"), 401, "key-needed")


def test_a_key_in_the_address_becomes_a_session_and_leaves_it(guarded: Guarded) -> None:
    with guarded.anew() as browser:
        answer = browser.get("/", params={"a": "b c", "key": guarded.key})
        assert (answer.status_code, answer.headers["location"]) == (303, "/?a=b+c")
        assert answer.headers["cache-control"] == "no-store"
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert browser.get("/v1/poses").status_code == 200
        elsewhere = browser.get(f"{browser.base_url}//evil.example/x?key={guarded.key}")
        assert elsewhere.headers["location"] == "/evil.example/x"


def test_a_wrong_session_is_refused(guarded: Guarded) -> None:
    for token in ("x", "12345678.99999999999.0", "a.b.c"):
        answer = guarded.server.get("/v1/poses", headers={"Cookie": f"snapfit_session={token}"})
        assert_problem(answer, 401, "wrong-key")


def test_foreign_pages_do_not_act_through_a_browser(guarded: Guarded) -> None:
    for origin in ("https://evil.example", "null", "http://127.0.0.1:1"):
        headers = {**guarded.operator, "Origin": origin}
        answer = guarded.server.client.post("/v1/poses", headers=headers)
        assert_problem(answer, 403, "foreign-origin")
    own = {**guarded.operator, "Origin": str(guarded.server.client.base_url).rstrip("/")}
    assert guarded.server.client.post("/v1/poses", headers=own).status_code == 405


def test_listed_origins_are_let_in(guarded: Guarded) -> None:
    ours = {"Origin": "https://dash.example"}
    asked = {
        "Access-Control-Request-Method": "GET",
        "Access-Control-Request-Headers": "authorization",
    }
    flight = guarded.server.client.options("/v1/poses", headers={**ours, **asked})
    assert flight.status_code == 200
    answer = guarded.server.get("/v1/poses", headers={**ours, **guarded.reader})
    for each in (flight, answer, guarded.server.get("/v1/poses", headers=ours)):
        assert each.headers["access-control-allow-origin"] == ours["Origin"]
    other = guarded.server.get("/v1/poses", headers={"Origin": "https://evil.example"})
    assert "access-control-allow-origin" not in other.headers


def test_a_key_that_is_removed_is_refused_within_seconds(guarded: Guarded) -> None:
    key = add_key(guarded.path, "guest", Role.READ)
    headers = {"Authorization": f"Bearer {key}"}
    wait_for(lambda: guarded.server.get("/v1/poses", headers=headers).status_code == 200, 5)
    remove_key(guarded.path, "guest")
    wait_for(lambda: guarded.server.get("/v1/poses", headers=headers).status_code == 401, 5)


def test_who_guesses_has_to_wait_and_others_have_not(guarded: Guarded) -> None:
    def guess() -> httpx.Response:
        headers = {"Authorization": f"Bearer {new_key()}"}
        return guarded.server.get("/v1/poses", headers=headers)

    answers = [guess() for _ in range(15)]
    assert {answer.status_code for answer in answers} == {401, 429}
    assert_problem(answers[-1], 429, "too-many-requests")
    assert int(answers[-1].headers["retry-after"]) >= 1
    assert guarded.server.get("/v1/poses", headers=guarded.reader).status_code == 200


def test_a_polling_headset_is_not_slowed_by_its_key(guarded: Guarded) -> None:
    with guarded.anew() as client:
        durations_s = []
        for _ in range(400):
            begin_s = time.perf_counter()
            assert client.get("/v1/poses", headers=guarded.reader).status_code == 200
            durations_s.append(time.perf_counter() - begin_s)
        assert statistics.median(durations_s) < within(0.02)  # hashing would take 40 ms in each
