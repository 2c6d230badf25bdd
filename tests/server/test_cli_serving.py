"""The commands that serve, and the ones about the server."""

from __future__ import annotations

import socket
import subprocess
import sys
from pathlib import Path

import orjson
from harness import left_behind, wait_for

from snapfit.server.app import create_app
from snapfit.server.settings import Settings

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))
ROOT = Path(__file__).parents[2]


def snapfit(*arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [SNAPFIT, *arguments], capture_output=True, text=True, timeout=120, cwd=cwd, check=False
    )


def test_version() -> None:
    done = snapfit("--version")
    assert done.returncode == 0
    assert done.stdout.startswith("snapfit 0.")


def test_help_names_every_command() -> None:
    done = snapfit("--help")
    assert done.returncode == 0
    for command in ("demo", "serve", "track", "worker", "asset", "key", "openapi"):
        assert command in done.stdout


def test_a_port_in_use_is_one_clear_line(tmp_path: Path) -> None:
    before = left_behind()
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        (tmp_path / "snapfit.toml").write_text(f"port = {port}")
        for done in (snapfit("demo", "--port", str(port)), snapfit("serve", cwd=tmp_path)):
            assert done.returncode == 2
            assert done.stdout == ""
            assert done.stderr.count("\n") == 1
            assert f"port {port} on 127.0.0.1 is in use" in done.stderr
            assert "--port" in done.stderr
    wait_for(lambda: left_behind() <= before)


def test_a_host_that_is_not_here_is_one_clear_line() -> None:
    for host in ("192.0.2.1", "no.such.host.invalid"):
        done = snapfit("demo", "--host", host)
        assert done.returncode == 2
        assert done.stderr.count("\n") == 1
        assert "--host" in done.stderr


def test_a_wrong_detector_or_provider_is_one_clear_line(tmp_path: Path) -> None:
    (tmp_path / "snapfit.toml").write_text("port = 18999")
    for command in ("demo", "serve"):
        for option, wrong in (("--detector", "magic"), ("--provider", "abacus")):
            done = snapfit(command, option, wrong, cwd=tmp_path)
            assert (done.returncode, done.stdout) == (2, "")
            assert done.stderr.count("\n") == 1
            assert "the command line: " in done.stderr
            assert f"this is '{wrong}'" in done.stderr


def test_wrong_settings_are_clear_lines(tmp_path: Path) -> None:
    (tmp_path / "snapfit.toml").write_text("prot = 1")
    done = snapfit("serve", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "snapfit.toml: prot: unknown key" in done.stderr
    assert "Traceback" not in done.stderr


def test_the_committed_document_is_the_generated_one(tmp_path: Path) -> None:
    out = tmp_path / "new" / "openapi.json"
    assert snapfit("openapi", "--out", str(out)).returncode == 0
    assert out.read_text() == (ROOT / "openapi" / "openapi.json").read_text(), "run `make openapi`"
    assert orjson.loads(snapfit("openapi").stdout) == orjson.loads(out.read_text())


def test_every_operation_is_described_and_fails_as_a_problem() -> None:
    document = create_app(Settings()).openapi()
    operations = [one for path in document["paths"].values() for one in path.values()]
    assert len(operations) == 51
    for operation in operations:
        assert operation["description"]
        for status, response in operation["responses"].items():
            if int(status) >= 400:
                assert set(response["content"]) == {"application/problem+json"}
    names = [operation["operationId"] for operation in operations]
    assert len(set(names)) == len(names)
