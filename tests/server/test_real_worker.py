"""The real tracker in the real worker, through the command line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from harness import Server, free_port, wait_for

from snapfit.server.open_pipeline import open_pipeline
from snapfit.server.worker_spec import WorkerSpec
from snapfit.tracking.errors import SourceError

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))
FIRST_START_LIMIT_S = 180


def test_the_simulated_bench_needs_an_asset() -> None:
    spec = WorkerSpec(
        station="bench",
        source="demo",
        asset=None,
        method="icg",
        boot_id="",
        wall_minus_monotonic_ns=0,
        poses_segment="",
        pictures_segment="",
    )
    with pytest.raises(SourceError, match=r"set station\.asset"):
        open_pipeline(spec, lambda _text, _share: None)


@pytest.mark.parametrize(
    ("station", "problem"),
    [
        ('source = "nowhere"', "nowhere: no such folder"),
        ('source = "."', "neither sequence.json"),
        ('source = "demo"\nasset = "nothing"', "nothing"),
    ],
)
def test_what_a_station_cannot_run_is_told_on_the_command_line(
    tmp_path: Path, station: str, problem: str
) -> None:
    port = free_port()
    (tmp_path / "snapfit.toml").write_text(f"port = {port}\n[station]\n{station}\n")
    done = subprocess.run(
        [SNAPFIT, "serve"], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 2
    assert problem in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_the_demo_tracks_the_clamp() -> None:
    demo = Server(command=[SNAPFIT, "demo", "--port"])
    try:
        wait_for(demo.answers)
        wait_for(lambda: demo.get("/readyz").status_code == 200, FIRST_START_LIMIT_S)
        snapshot = demo.get("/v1/poses").json()
        assert snapshot["asset"] == "hobby-corner-clamp"
        assert {part["part"]: part["status"] for part in snapshot["parts"]} == {
            "base": "tracked",
            "jaw": "tracked",
            "bolt": "tracked",
        }
        assert demo.get("/v1/overlay.jpg").content.startswith(b"\xff\xd8")
    finally:
        code, _, err = demo.end()
    assert (code, err) == (0, "")
