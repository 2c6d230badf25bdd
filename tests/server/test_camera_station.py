"""A station whose source is a live camera, by the stand-in of its driver in a real worker."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from harness import Server, once_there, wait_for
from patience import within

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))
STAND_INS = Path(__file__).parents[1] / "tracking" / "stand_ins"


@pytest.fixture(autouse=True)
def _stand_ins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Workers find the stand-ins where the drivers would be."""
    paths = [str(STAND_INS), os.environ.get("PYTHONPATH")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, paths)))


def serve(folder: Path, station: str) -> Server:
    (folder / "snapfit.toml").write_text(f"[station]\n{station}\n")
    config = str(folder / "snapfit.toml")
    return Server(command=[SNAPFIT, "serve", "--config", config, "--port"])


def fresh_poses(server: Server) -> dict[str, Any] | None:
    """Of a frame that was taken within the last second; None if it was held up."""
    poses: dict[str, Any] = server.get("/v1/poses").json()
    now_us = time.time_ns() // 1000
    assert poses["captured_at_us"] <= now_us
    return poses if poses["captured_at_us"] > now_us - 1_000_000 else None


def test_a_camera_is_tracked_at_its_own_pace(tmp_path: Path) -> None:
    source = 'source = "realsense:0815?width=640&height=360"'
    server = serve(tmp_path, f'{source}\nasset = "hobby-corner-clamp"\ndetector = "geometric"')
    try:
        wait_for(server.answers)
        wait_for(lambda: server.get("/readyz").status_code == 200, 120)
        wait_for(lambda: server.worker()["frames"] > 50, 20)
        poses = wait_for(lambda: fresh_poses(server))
        assert {part["status"] for part in poses["parts"]} <= {"searching", "lost", "tracked"}
        assert poses["published_at_us"] >= poses["captured_at_us"]
        facts = server.get("/v1/stations/bench-1").json()["facts"]
        assert facts["source"] == "realsense:0815?width=640&height=360"
        color, depth = facts["cameras"]
        assert (color["width"], color["fx"], color["distortion"]) == (640, 60.0, [])
        assert depth["color_from_camera"][0] == [0.0, -1.0, 0.0, 0.015]
        picture = once_there(lambda: server.get("/v1/frame.jpg"))
        assert picture.content.startswith(b"\xff\xd8")
    finally:
        code, _, err = server.end()
    # Who is held up for half a second misses a frame, which is told of.
    told = [line for line in err.splitlines() if "the camera is slow" not in line]
    assert (code, told) == (0, [])


@pytest.mark.parametrize(
    ("station", "problem"),
    [
        ('source = "realsense"', "a camera knows no parts: set station.asset"),
        ('source = "realsense:9"\nasset = "hobby-corner-clamp"', "no RealSense 9 that can do this"),
        ('source = "kodak:1"', "no kind of camera 'kodak'"),
        ('source = "uvc:0"\nasset = "hobby-corner-clamp"', "snapfit calibrate"),
    ],
)
def test_a_camera_that_cannot_be_used_ends_the_server_with_one_line(
    tmp_path: Path, station: str, problem: str
) -> None:
    server = serve(tmp_path, station)
    try:
        server.process.wait(within(60))
    finally:
        code, _, err = server.end()
    assert code == 2
    assert problem in err
    assert "Traceback" not in err
