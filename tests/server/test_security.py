"""A server that needs no key: what it refuses all the same, and what every answer carries."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator

import httpx
import pytest
from harness import Server, once_there, running, wait_for

from snapfit.server.schemas_base import Problem


def assert_problem(answer: httpx.Response, status: int, kind: str) -> None:
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    assert Problem.model_validate_json(answer.content).type == f"urn:snapfit:problem:{kind}"


@pytest.mark.parametrize("path", ["/", "/v1/poses", "/v1/frame.jpg", "/nothing", "/docs"])
def test_every_answer_carries_the_headers(server: Server, path: str) -> None:
    headers = server.get(path).headers
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    policy = headers["content-security-policy"]
    assert "default-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy
    assert "server" not in headers


def test_what_is_no_http_is_answered_with_the_headers_too(server: Server) -> None:
    with socket.create_connection(("127.0.0.1", server.port), timeout=60) as client:
        client.sendall(b"cheese\r\n\r\n")
        answer = client.recv(65536)
    assert answer.startswith(b"HTTP/1.1 400 ")
    assert b"x-content-type-options: nosniff" in answer


@pytest.mark.parametrize("path", ["/", "/v1/poses", "/v1/poses/jaw", "/v1/frame.jpg", "/nothing"])
def test_head_is_get_without_the_body(server: Server, path: str) -> None:
    get = once_there(lambda: server.get(path))
    head = once_there(lambda: server.client.head(path))
    assert head.status_code == get.status_code
    assert head.content == b""
    assert head.headers["content-type"] == get.headers["content-type"]
    assert int(head.headers["content-length"]) > 0


def test_a_body_that_is_too_long_is_not_read(server: Server) -> None:
    def pieces() -> Iterator[bytes]:
        for _ in range(40):
            yield b" " * 65536

    whole = server.client.post("/v1/session", content=b" " * 2**21)
    assert_problem(whole, 413, "body-too-long")
    in_pieces = server.client.post("/v1/session", content=pieces())
    assert in_pieces.status_code == 413
    assert in_pieces.json()["title"] == "Content Too Large"
    assert server.get("/v1/poses").status_code == 200


@pytest.mark.parametrize(
    "path",
    [
        "/../../../etc/passwd",
        "/..%2f..%2fetc%2fpasswd",
        "/%2e%2e/pyproject.toml",
        "/v1/stations/..%2f..%2fetc%2fpasswd/poses",
        "/v1/poses/..%2f..%2f..%2fetc%2fpasswd",
        "/page.js/../../server/app.py",
        "/page.js%00.png",
        "//etc/passwd",
    ],
)
def test_no_path_leads_to_the_file_system(server: Server, path: str) -> None:
    # Sent as it stands: httpx would tidy it up.
    import http.client

    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=60)
    connection.request("GET", path)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    assert answer.status == 404
    assert b"root:" not in body
    assert answer.headers["content-type"] == "application/problem+json"


def test_a_name_that_a_stranger_may_own_is_refused_while_no_key_is_needed(server: Server) -> None:
    answer = server.get("/v1/poses", headers={"Host": f"evil.example:{server.port}"})
    assert_problem(answer, 403, "foreign-host")
    for host in ("localhost", "bench-pc:8000", "bench.local", "192.168.1.5", "[::1]:8000"):
        assert server.get("/v1/poses", headers={"Host": host}).status_code == 200
    foreign = {"Origin": "http://evil.example"}
    assert_problem(server.client.post("/v1/session", headers=foreign), 403, "foreign-origin")


def test_where_no_key_is_needed_a_key_does_no_harm(server: Server) -> None:
    answer = server.get("/v1/poses", params={"key": "anything"})
    assert (answer.status_code, answer.headers["location"]) == (303, "/v1/poses")
    assert "set-cookie" not in answer.headers
    assert server.client.post("/v1/session", json={"key": "x"}).json()["role"] == "operate"
    assert server.get("/v1/poses", headers={"Authorization": "Bearer x"}).status_code == 200


def test_too_many_requests_are_a_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    # So few that even who is held up between requests is too fast.
    monkeypatch.setenv("SNAPFIT_SECURITY__REQUESTS_PER_S", "1")
    monkeypatch.setenv("SNAPFIT_SECURITY__BURST", "10")
    with running() as server:
        wait_for(server.answers)
        refused = wait_for(lambda: (it := server.get("/healthz")).status_code == 429 and it)
        assert_problem(refused, 429, "too-many-requests")
        time.sleep(int(refused.headers["retry-after"]))
        assert server.get("/healthz").status_code == 200
