"""The C# client against real servers: requests, streams, restarts, proxies, keys, a headset."""

from __future__ import annotations

import os
import re
import signal
import subprocess
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import IO, cast

import pytest
from compiler import LIVE
from harness import Server, running, wait_for
from relay import relayed

from snapfit.server.security.key_file import add_key
from snapfit.server.security.roles import Role

LIMIT_S = 600
NOTHING: Mapping[str, Callable[[], object]] = {}


def play(
    folder: Path,
    scenario: str,
    port: int,
    *more: str,
    do: Mapping[str, Callable[[], object]] = NOTHING,
) -> str:
    """Run a scenario; do what it asks for. What it said."""
    command = ["mono", str(folder / LIVE), scenario, f"http://127.0.0.1:{port}", *more]
    said = []
    with subprocess.Popen(
        ["timeout", str(LIMIT_S), *command],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as program:
        told = cast("IO[str]", program.stdin)
        for line in cast("IO[str]", program.stdout):
            said.append(line)
            action = do.get(line.strip())
            if action is not None:
                action()
                told.write("done\n")
                told.flush()
    output = "".join(said)
    assert program.returncode == 0, output
    assert said[-1] == "passed\n", output
    return output


def test_requests_have_their_answers(compiled: Path, unity_server: Server) -> None:
    play(compiled, "requests", unity_server.port)


def test_what_is_refused_says_why(compiled: Path, unity_server: Server) -> None:
    play(compiled, "refusals", unity_server.port)


def test_every_transport_brings_poses_in_time(compiled: Path, unity_server: Server) -> None:
    said = play(compiled, "stream", unity_server.port)
    assert len(re.findall(r"shown within [\d.]+ mm", said)) == 4


def test_without_websockets_long_poll_takes_over(compiled: Path, unity_server: Server) -> None:
    with relayed(unity_server.port, refuses_websockets=True) as relay:
        play(compiled, "fallback", relay.port)


def test_a_dead_connection_is_noticed(compiled: Path, unity_server: Server) -> None:
    with relayed(unity_server.port) as relay:
        play(compiled, "frozen", relay.port, do={"freeze": relay.freeze})


def test_it_comes_back_after_worker_and_server(compiled: Path) -> None:
    with ExitStack() as stack:
        servers = [stack.enter_context(running()).wait_ready()]
        port = servers[0].port

        def start() -> None:
            server = Server(port=port)
            stack.callback(server.end)
            servers.append(server)

        play(
            compiled,
            "restart",
            port,
            do={
                "kill the worker": lambda: os.kill(
                    wait_for(lambda: servers[-1].worker()["pid"]), signal.SIGKILL
                ),
                "stop the server": lambda: servers[-1].end(),
                "start the server": start,
            },
        )
    assert len(servers) == 2


def test_commands_and_what_steps_and_ghosts_make_of_them(compiled: Path) -> None:
    with running("finds") as server:
        server.wait_ready()
        play(compiled, "commands", server.port)
        play(compiled, "guide", server.port)


def test_events_come_without_gaps(compiled: Path) -> None:
    with running("assembles") as server, relayed(server.wait_ready().port) as relay:
        play(compiled, "events", relay.port, do={"cut the connections": relay.cut})


def test_a_headset_sees_parts_in_its_own_world(compiled: Path) -> None:
    with running("marker") as server:
        play(compiled, "world", server.wait_ready().port)


def test_keys(compiled: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    key = add_key(tmp_path / "keys.json", "headset-1", Role.READ)
    monkeypatch.setenv("SNAPFIT_SECURITY__KEYS", "on")
    monkeypatch.setenv("SNAPFIT_SECURITY__KEYS_FILE", str(tmp_path / "keys.json"))
    with running() as server:
        wait_for(server.answers, 60)
        headers = {"Authorization": f"Bearer {key}"}
        wait_for(lambda: server.get("/readyz", headers=headers).status_code == 200, 60)
        play(compiled, "keys", server.port, key)
