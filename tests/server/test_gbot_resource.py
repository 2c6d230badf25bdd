"""/resource says what the GBOT authors' server says, by their formulas."""

from __future__ import annotations

import json
import subprocess
import sys
import urllib.error
import urllib.request
from typing import Any

import numpy as np
import pytest
from harness import HERE, Server, free_port, wait_for
from hypothesis import given
from hypothesis import strategies as st
from scripted_pipeline import LOST_PART, PART_NAMES

from snapfit.models.pose import Pose
from snapfit.server import quaternion
from snapfit.server.gbot_resource import gbot_parts, unity_euler_deg

angles = st.floats(-3.1, 3.1)


def about(axis: int, angle_rad: float) -> np.ndarray[Any, Any]:
    vector = np.zeros(6)
    vector[axis] = angle_rad
    return Pose.exp(vector).rotation


def gbot_rotation(qx: float, qy: float, qz: float) -> np.ndarray[Any, Any]:
    """world_from_body of what their server would have sent.

    It takes world2body apart as Rz(a) @ Rx(b) @ Ry(c) and sends qx = b, qy = -c, qz = a + 180.
    """
    a, b, c = np.radians([qz - 180, qx, -qy])
    return (about(2, a) @ about(0, b) @ about(1, c)).T


@given(st.lists(angles, min_size=3, max_size=3))
def test_the_angles_are_theirs(vector: list[float]) -> None:
    pose = Pose.exp([*vector, 0, 0, 0])
    orientation = quaternion.exp(vector)
    part = {"part": "jaw", "position": [0.1, 0.2, 0.7], "orientation": orientation}
    (told,) = gbot_parts({"parts": [part]})
    assert (told["x"], told["y"], told["z"]) == (0.1, -0.2, 0.7)
    np.testing.assert_allclose(
        gbot_rotation(told["qx"], told["qy"], told["qz"]), pose.rotation, atol=1e-6
    )


@pytest.mark.parametrize("x_deg", [90.0, -90.0])
def test_straight_up_and_down(x_deg: float) -> None:
    rotation = about(1, 0.5) @ about(0, np.radians(x_deg))
    q = Pose.from_rotation_translation(rotation, [0, 0, 0]).quaternion
    x, y, z = np.radians(unity_euler_deg(q))
    np.testing.assert_allclose(about(1, y) @ about(0, x) @ about(2, z), rotation, atol=1e-6)


@pytest.mark.parametrize("path", ["/resource"])
def test_only_parts_with_a_pose_are_told(server: Server, path: str) -> None:
    parts = server.get(path).json()
    assert [part["classId"] for part in parts] == [it for it in PART_NAMES if it != LOST_PART]
    assert set(parts[0]) == {"classId", "x", "y", "z", "qx", "qy", "qz"}


def test_their_port_serves_their_resource_and_nothing_else() -> None:
    gbot_port = free_port()
    server = Server(
        command=[sys.executable, str(HERE / "serve_scripted.py")], more=[str(gbot_port)]
    )
    try:
        server.wait_ready()
        url = f"http://127.0.0.1:{gbot_port}"
        with urllib.request.urlopen(f"{url}/resource", timeout=60) as answer:
            assert json.load(answer)[0]["classId"] == PART_NAMES[0]
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(f"{url}/v1/poses", timeout=60)
        assert refused.value.code == 404
        assert json.load(refused.value)["type"] == "urn:snapfit:problem:old-port"
        refused.value.close()
        assert server.get("/resource").status_code == 200
    finally:
        code, _, err = server.end()
    assert (code, err) == (0, "")


def test_a_port_that_is_taken_is_told() -> None:
    server = Server()
    try:
        wait_for(server.answers)
        command = [sys.executable, str(HERE / "serve_scripted.py"), str(free_port())]
        done = subprocess.run(
            [*command, str(server.port)],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
            env=server.environment,
        )
        assert done.returncode == 1
        assert f"port {server.port} on 127.0.0.1 is in use" in done.stderr
    finally:
        server.end()
