"""The real tracker in the real worker, through the command line."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest
from found_scene import (
    FOUND,
    POSES,
    UNKNOWN_TO_THE_NETWORK,
    write_bundle,
    write_network_that_breaks,
    write_recording,
)
from harness import Server, free_port, wait_for

from snapfit.server.open_pipeline import open_pipeline
from snapfit.server.worker_spec import WorkerSpec
from snapfit.tracking.errors import SourceError

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))
FIRST_START_LIMIT_S = 180

needs_onnx = pytest.mark.skipif(find_spec("onnx") is None, reason="onnx: snapfit[test]")


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
        [SNAPFIT, "serve"], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 2
    assert problem in done.stderr
    assert "Traceback" not in done.stderr


def statuses(server: Server) -> dict[str, str]:
    parts = server.get("/v1/poses").json().get("parts", [])
    return {part["part"]: part["status"] for part in parts}


@contextmanager
def serving(folder: Path, bundle: Path, **station: str) -> Iterator[Server]:
    """A station whose source brings no poses, with the network of a bundle."""
    write_recording(folder / "recording")
    lines = {"source": "recording", "asset": str(bundle), "detector": "network", **station}
    text = "\n".join(f"{key} = {json.dumps(value)}" for key, value in lines.items())
    (folder / "snapfit.toml").write_text(f"[station]\n{text}\n")
    config = str(folder / "snapfit.toml")
    server = Server(command=[SNAPFIT, "serve", "--config", config, "--port"])
    try:
        wait_for(server.answers)
        yield server
    finally:
        server.end()


@needs_onnx
def test_parts_are_searched_then_tracked(tmp_path: Path) -> None:
    bundle = write_bundle(tmp_path / "hobby-corner-clamp")
    with serving(tmp_path, bundle) as server:
        first = wait_for(lambda: statuses(server), FIRST_START_LIMIT_S)
        assert set(first.values()) <= {"searching", "tracked"}  # some may be found by now
        tracked = dict.fromkeys(FOUND, "tracked")
        wanted = {**tracked, UNKNOWN_TO_THE_NETWORK: "searching"}
        wait_for(lambda: statuses(server) == wanted, FIRST_START_LIMIT_S)
        for part in server.get("/v1/poses").json()["parts"]:
            if part["part"] in POSES:
                true = POSES[part["part"]].translation
                assert math.dist(part["position"], true) < 0.003
                assert part["confidence"] > 0.9
            else:
                assert part["position"] is None
                assert part["orientation"] is None
        facts = server.get("/v1/stations/bench-1").json()["facts"]
        assert (facts["method"], facts["detector"], facts["provider"]) == ("gbot", "network", "cpu")
        finding = wait_for(lambda: (it := server.worker()["finding"]) and it["started"] and it)
        assert (finding["failed"], finding["last_problem"]) == (0, None)
        assert finding["started"] >= len(FOUND)
        assert finding["found"] >= len(FOUND)


@needs_onnx
def test_a_network_that_breaks_is_counted_and_never_stops_the_station(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Without Open3D no shape stands in for the network.
    (tmp_path / "path").mkdir()
    (tmp_path / "path" / "open3d.py").write_text("raise ImportError('not on this machine')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "path"), prepend=os.pathsep)
    bundle = write_bundle(tmp_path / "hobby-corner-clamp")
    write_network_that_breaks(bundle)
    with serving(tmp_path, bundle, method="icg") as server:
        wait_for(lambda: server.get("/readyz").status_code == 200, FIRST_START_LIMIT_S)
        finding = wait_for(
            lambda: (it := server.worker()["finding"]) and it["failed"] >= 3 and it, 30
        )
        assert "does not run" in finding["last_problem"]
        assert finding["started"] == 0
        seq = server.get("/v1/poses").json()["seq"]
        wait_for(lambda: server.get("/v1/poses").json()["seq"] > seq + 5)
        assert set(statuses(server).values()) == {"searching"}
        assert server.worker()["restarts"] == 0
        code, _, err = server.end()
    assert code == 0
    assert err.count("looking for parts failed") == 1


@needs_onnx
def test_a_network_that_is_none_ends_the_server_with_its_path(tmp_path: Path) -> None:
    bundle = write_bundle(tmp_path / "hobby-corner-clamp")
    (bundle / "detector.onnx").write_bytes(b"cheese")
    with serving(tmp_path, bundle, method="icg") as server:
        server.process.wait(timeout=FIRST_START_LIMIT_S)
        code, _, err = server.end()
    assert code == 2
    assert f"{bundle / 'detector.onnx'}: is no ONNX file that runs" in err
    assert "Traceback" not in err


@pytest.mark.slow
def test_the_demo_tracks_the_clamp() -> None:
    demo = Server(command=[SNAPFIT, "demo", "--port"])
    try:
        wait_for(demo.answers)
        wait_for(lambda: demo.get("/readyz").status_code == 200, FIRST_START_LIMIT_S)
        assert demo.get("/v1/poses").json()["asset"] == "hobby-corner-clamp"
        tracked = dict.fromkeys(("base", "jaw", "bolt"), "tracked")
        wait_for(lambda: statuses(demo) == tracked, FIRST_START_LIMIT_S)
        assert demo.get("/v1/overlay.jpg").content.startswith(b"\xff\xd8")
    finally:
        code, _, err = demo.end()
    assert (code, err) == (0, "")
