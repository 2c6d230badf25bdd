"""A container's health check tells who is well."""

from __future__ import annotations

import shutil
import socket
import ssl
import subprocess
import sys
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest
from fleet import needs_redis, redis_server
from harness import Server, free_port, wait_for

from snapfit.server.fleet.keys import StationKeys
from snapfit.server.fleet.link import connect
from snapfit.server.health import api_problem, main, worker_problem


class _Answers(BaseHTTPRequestHandler):
    status = 200

    def do_GET(self) -> None:
        self.send_response(self.status if self.path == "/healthz" else 404)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Says nothing."""


def test_a_server_that_runs_is_well(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SNAPFIT_PORT", str(server.port))
    monkeypatch.setattr(sys, "argv", ["health"])
    wait_for(lambda: main() == 0)  # it gives a server that is held up three seconds


def test_a_server_that_is_not_there_is_not(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    port = free_port()
    monkeypatch.setenv("SNAPFIT_PORT", str(port))
    monkeypatch.setattr(sys, "argv", ["health"])
    assert main() == 1
    assert capsys.readouterr().err.startswith(f"port {port}: ")


@pytest.mark.parametrize("status", [200, 500])
def test_a_server_with_a_certificate_is_asked_by_https(
    status: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if shutil.which("openssl") is None:
        pytest.skip("there is no openssl")
    cert, key = tmp_path / "cert.pem", tmp_path / "key.pem"
    subject = ("-nodes", "-days", "1", "-subj", "/CN=elsewhere", "-keyout", str(key))
    command = ["openssl", "req", "-x509", "-newkey", "rsa:2048", *subject, "-out", str(cert)]
    subprocess.run(command, check=True, capture_output=True)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(cert, key)
    monkeypatch.setattr(_Answers, "status", status)
    with HTTPServer(("127.0.0.1", 0), _Answers) as https:
        https.socket = context.wrap_socket(
            https.socket, server_side=True, do_handshake_on_connect=False
        )
        https.handle_error = lambda *_: None  # type: ignore[method-assign]  # plain HTTP comes first
        threading.Thread(target=https.serve_forever, daemon=True).start()
        monkeypatch.setenv("SNAPFIT_PORT", str(https.server_port))
        # It waits three seconds for an answer that may be held up.
        wait_for(lambda: (api_problem() == "") is (status == 200))
        https.shutdown()


def test_it_imports_little() -> None:
    code = "import sys, snapfit.server.health; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert {"numpy", "fastapi", "pydantic", "redis"}.isdisjoint(done.stdout.split())


@needs_redis
def test_a_worker_is_well_while_its_machine_holds_the_station(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with redis_server() as redis, connect(redis.url) as client:
        monkeypatch.setenv("SNAPFIT_STORE", redis.url)
        wait_for(lambda: "nobody publishes it" in worker_problem("bench-1"))
        client.set(StationKeys("bench-1").lease, f"{socket.gethostname()}:7:abcd")
        wait_for(lambda: worker_problem("bench-1") == "")
        client.set(StationKeys("bench-1").lease, "elsewhere:7:abcd")
        wait_for(lambda: "published by elsewhere" in worker_problem("bench-1"))
    assert worker_problem("bench-1").startswith("store redis://127.0.0.1:")
