"""HTTPS, with a certificate made here."""

from __future__ import annotations

import shutil
import ssl
import subprocess
import sys
from pathlib import Path

import httpx
import pytest
from harness import running, wait_for

from snapfit.clients.python import CertificateError, Client

START_S = 60
SNAPFIT = str(Path(sys.executable).with_name("snapfit"))

pytestmark = pytest.mark.skipif(shutil.which("openssl") is None, reason="there is no openssl")


@pytest.fixture
def pair(tmp_path: Path) -> tuple[str, str]:
    """A certificate for 127.0.0.1 and its key."""
    cert, key = str(tmp_path / "cert.pem"), str(tmp_path / "key.pem")
    subprocess.run(
        [
            *("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1"),
            *("-subj", "/CN=snapfit", "-addext", "subjectAltName=IP:127.0.0.1"),
            *("-keyout", key, "-out", cert),
        ],
        check=True,
        capture_output=True,
    )
    return cert, key


def test_poses_over_https(pair: tuple[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    cert, key = pair
    monkeypatch.setenv("SNAPFIT_SECURITY__TLS_CERT", cert)
    monkeypatch.setenv("SNAPFIT_SECURITY__TLS_KEY", key)
    with running() as server:
        server.client.close()
        context = ssl.create_default_context(cafile=cert)
        server.client = httpx.Client(
            base_url=f"https://127.0.0.1:{server.port}", verify=context, timeout=60
        )
        wait_for(server.answers, START_S)
        assert wait_for(lambda: server.get("/v1/poses").status_code == 200, START_S)
        url = f"https://127.0.0.1:{server.port}"
        for verify in (cert, context, False):
            with Client(url, verify=verify) as client:
                before = client.poses()
                after = next(client.follow())
                assert (after.boot_id, after.seq >= before.seq) == (before.boot_id, True)
        with Client(url) as client:
            for ask in (client.poses, lambda: next(client.follow()), lambda: next(client.events())):
                with pytest.raises(CertificateError, match="verify="):
                    ask()


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--tls-cert", "cert.pem"], "TLS needs both files"),
        (["--tls-cert", "cert.pem", "--tls-key", "no.pem"], "no.pem: no such file"),
        (["--tls-cert", "key.pem", "--tls-key", "key.pem"], "are no certificate in PEM"),
    ],
)
def test_what_is_wrong_with_a_certificate_is_one_clear_line(
    pair: tuple[str, str], arguments: list[str], problem: str
) -> None:
    done = subprocess.run(
        [SNAPFIT, "demo", "--port", "18778", *arguments],
        cwd=Path(pair[0]).parent,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert problem in done.stderr
    assert "Traceback" not in done.stderr
