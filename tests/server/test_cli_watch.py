"""`snapfit watch`: what it shows in a terminal, in a pipe, once, and as JSON."""

from __future__ import annotations

import contextlib
import io
import itertools
import json
import math
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from harness import Server, running, wait_for
from patience import within
from rich.console import Console
from scripted_pipeline import LOST_PART, PART_NAMES
from typer.testing import CliRunner

from snapfit.clients.python import Client, NotReachableError, PoseSnapshot, StateChanged
from snapfit.models.pose import Pose
from snapfit.server.cli.main import app
from snapfit.server.cli.watch_view import Watched, line, rotation_vector_deg, view

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))


@pytest.fixture
def snapshot(server: Server) -> PoseSnapshot:
    with Client(address(server)) as client:
        return wait_for_velocity(client)


def wait_for_velocity(client: Client) -> PoseSnapshot:
    found: PoseSnapshot = wait_for(lambda: (it := client.poses()).seq > 1 and it)
    return found


def address(server: Server) -> str:
    return f"http://127.0.0.1:{server.port}"


def watch(*arguments: str) -> tuple[int, str]:
    done = CliRunner().invoke(app, ["watch", *arguments], env={"COLUMNS": "120"})
    return done.exit_code, done.output


def shown(watched: Watched) -> str:
    console = Console(file=io.StringIO(), width=120)
    console.print(view(watched))
    text: str = console.file.getvalue()  # type: ignore[attr-defined]
    return text


def test_a_terminal_shows_every_part_and_the_assembly(snapshot: PoseSnapshot) -> None:
    watched = Watched("http://bench")
    assert "waiting for poses from http://bench" in shown(watched)
    watched.take(snapshot)
    text = shown(watched)
    for part in PART_NAMES:
        (row,) = (row for row in text.splitlines() if row.startswith(f"{part} "))
        assert ("lost" if part == LOST_PART else "tracked") in row
    jaw = snapshot.part("jaw")
    assert jaw.position is not None
    (row,) = (row for row in text.splitlines() if row.startswith("jaw "))
    assert f"{1000 * jaw.position[0]:.1f}" in row
    assert row.split()[-1] == "base"
    assert " 100 " in row  # mm/s
    assert "state free 0.90 by tracking  next mount-jaw" in text
    assert "fresh" in text
    assert f"seq {snapshot.seq} of {snapshot.boot_id}" in text


def test_it_counts_frames_and_forgets_them_with_the_worker(snapshot: PoseSnapshot) -> None:
    watched = Watched("")
    for number in range(31):
        at_us = snapshot.captured_at_us + number * 33_333
        later = {"seq": snapshot.seq + number, "captured_at_us": at_us}
        watched.take(snapshot.model_copy(update=later))
    assert watched.rate_hz == pytest.approx(30, rel=1e-3)
    assert "30.0 frames/s" in line(watched)
    watched.take(snapshot.model_copy(update={"boot_id": "another"}))
    assert watched.rate_hz is None


def test_trouble_is_shown_until_fresh_poses_come(snapshot: PoseSnapshot) -> None:
    watched = Watched("")
    watched.take(snapshot)
    watched.fail(NotReachableError("it is away."), 1.25)
    watched.take(snapshot.model_copy(update={"stale": True}))
    for text in (shown(watched), line(watched)):
        assert "it is away. Trying again in 1.2 s." in text
    assert "stale" in shown(watched)
    watched.take(snapshot)
    assert "away" not in shown(watched)


def test_events_scroll(snapshot: PoseSnapshot) -> None:
    watched = Watched("")
    watched.take(snapshot)
    for number in range(20):
        watched.happened(
            StateChanged(
                station="bench-1",
                at_us=snapshot.captured_at_us,
                boot_id="b",
                seq=1,
                captured_at_us=1,
                from_state=f"s{number}",
                to_state=f"s{number + 1}",
                decided_by="operator",
                confidence=0.987,
            )
        )
    told = [row for row in shown(watched).splitlines() if "state_changed" in row]
    assert len(told) == 6
    assert told[-1].endswith("state_changed s19 s20 operator 0.987")


def test_rotation_is_axis_times_angle() -> None:
    for vector in ([0.3, -1.2, 0.5], [0.0, 0.0, 0.0], [0.0, math.pi - 1e-3, 0.0]):
        quaternion = Pose.exp([*vector, 0, 0, 0]).quaternion.tolist()
        wanted = [math.degrees(each) for each in vector]
        assert rotation_vector_deg(quaternion) == pytest.approx(wanted, abs=1e-6)
        assert rotation_vector_deg([-each for each in quaternion]) == pytest.approx(
            wanted, abs=1e-6
        )


def test_once_is_for_scripts(server: Server) -> None:
    code, told = watch(address(server), "--once")
    assert code == 0
    assert "jaw " in told
    code, told = watch(address(server), "--once", "--json", "--convention", "unity")
    assert code == 0
    snapshot = PoseSnapshot.model_validate_json(told)
    assert (snapshot.convention, snapshot.station) == ("unity", "bench-1")


def test_once_without_poses_or_server_fails() -> None:
    with running("slow-start") as server:
        wait_for(server.answers, 60)
        code, told = watch(address(server), "--once")
        assert code == 1
        assert "has tracked no frame yet" in told
    for url, problem in (("http://127.0.0.1:9", "does not answer"), ("bench", "is no address")):
        code, told = watch(url, "--once")
        assert code == 2
        assert problem in told
        assert told.startswith("error: ")


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--station", "bench-9"], "there is bench-1"),
        (["--frame", "anchor:nobody"], "nobody"),
        (["--ca", "no.pem"], "no.pem: no such file"),
    ],
)
def test_what_waiting_does_not_mend_ends_it(
    server: Server, arguments: list[str], problem: str
) -> None:
    code, told = watch(address(server), *arguments)
    assert code == 2
    assert problem in told
    assert "Traceback" not in told


def test_a_pipe_gets_a_line_a_second_and_may_be_closed(server: Server) -> None:
    for arguments, is_line in (
        ([], lambda told: "jaw tracked" in told),
        (["--json"], lambda told: json.loads(told)["station"] == "bench-1"),
    ):
        process = subprocess.Popen(
            [SNAPFIT, "watch", address(server), *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        assert process.stderr is not None
        lines = (process.stdout.readline() for _ in range(60))
        # The first ones may say that it waits.
        assert len(list(itertools.islice(filter(is_line, lines), 2))) == 2
        process.stdout.close()
        assert process.wait(within(30)) == 0
        assert process.stderr.read() == ""
        process.stderr.close()


def test_a_real_terminal_is_drawn_again_and_again_until_ctrl_c(server: Server) -> None:
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        [SNAPFIT, "watch", address(server)],
        stdout=theirs,
        stderr=subprocess.PIPE,
        env={**os.environ, "COLUMNS": "120", "LINES": "40", "TERM": "xterm-256color"},
        # What a shell starts in the background ignores Ctrl-C, and so do its children.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    os.close(theirs)
    text = b""
    give_up_at_s = time.monotonic() + within(30)
    while text.count(b"bench-1") < 5 and time.monotonic() < give_up_at_s:
        text += os.read(ours, 65536)
    process.send_signal(signal.SIGINT)
    drain(ours)
    assert process.wait(within(30)) == 0
    assert process.stderr is not None
    assert process.stderr.read() == b""
    process.stderr.close()
    assert text.count(b"bench-1") >= 5
    assert b"\x1b[" in text
    assert "\u2588".encode() in text


def drain(terminal: int) -> None:
    """Read until the other side is closed."""
    with contextlib.suppress(OSError):
        while os.read(terminal, 65536):
            pass
    os.close(terminal)
