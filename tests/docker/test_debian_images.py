"""Both images, made in roots of Debian and started there as Compose would: opt-in, for it takes
many minutes, gigabytes, and root.

`SNAPFIT_DEBOOTSTRAP=1` asks for it. A missing system package shows here, as does a place that has
to be written and must not be.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from compose_file import DOCKER, services
from debian_root import Builder, Image, make_base, megabytes, start
from fleet import redis_server, working
from harness import free_port, wait_for

LARGEST_API_MB = 200
# The kernels are compiled and the demo is rendered.
FIRST_POSES_LIMIT_S = 1800
# As `stop_grace_period`.
END_LIMIT_S = 30
USER = 10001
PACKAGES = "opt/snapfit/lib/python3.11/site-packages"
TRACKING_STACK = ("numba", "open3d", "onnxruntime", "cv2", "scipy", "trimesh", "manifold3d")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        "SNAPFIT_DEBOOTSTRAP" not in os.environ or os.geteuid() != 0,
        reason="SNAPFIT_DEBOOTSTRAP=1 and root are needed",
    ),
]


@pytest.fixture(scope="module")
def builder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Builder]:
    if not shutil.which("debootstrap"):
        pytest.skip("there is no debootstrap: apt-get install debootstrap")
    folder = tmp_path_factory.mktemp("images")
    yield Builder(make_base(folder), folder, {})
    shutil.rmtree(folder)


class Container:
    """A service of compose.yaml in its image's root, on loopback."""

    def __init__(self, image: Image, name: str, folder: Path, more: dict[str, str]) -> None:
        service = services()[name]
        self.image, self.port, self._folder = image, free_port(), folder
        self.environment = {
            **{it: value for it, value in service["environment"].items() if it not in more},
            "SNAPFIT_HOST": "127.0.0.1",
            "SNAPFIT_PORT": str(self.port),
            "SNAPFIT_SECURITY__KEYS": "on",
            **more,
        }
        self.mounts = {place: self._source(mount) for place, mount in self._mounts(service)}
        command = ["snapfit", *service["command"]]
        with (folder / "log").open("w") as log:
            self.process = start(image, command, self.environment, self.mounts, log)

    def _mounts(self, service: dict[str, Any]) -> list[tuple[str, str]]:
        places = [(place, "tmpfs") for place in service["tmpfs"]]
        for mount in service["volumes"]:
            source, place, *how = mount.split(":")
            # The replicas' keys are made by the service `keys`; here they make their own.
            read_only = how == ["ro"] and place != "/keys"
            places.append((place, source + (":ro" if read_only else "")))
        return places

    def _source(self, mount: str) -> str:
        """A folder in place of a volume."""
        if mount == "tmpfs":
            return mount
        source, _, how = mount.partition(":")
        folder = DOCKER / source if source.startswith(".") else self._folder / source
        if not folder.exists():
            folder.mkdir()
            os.chown(folder, USER, USER)
        return f"{folder.resolve()}:{how}" if how else str(folder)

    def log(self) -> str:
        return (self._folder / "log").read_text("utf-8")

    def run(self, *command: str) -> tuple[int, str]:
        """What `docker compose exec` would run."""
        process = start(self.image, list(command), self.environment, self.mounts)
        out, _ = process.communicate(timeout=60)
        return process.returncode, out

    def is_healthy(self) -> bool:
        assert self.process.poll() is None, self.log()
        return self.run("python", "-m", "snapfit.server.health")[0] == 0

    def get(self, path: str) -> httpx.Response:
        key = re.findall(r"key   (sf_\S+)", self.log())[0]
        headers = {"Authorization": f"Bearer {key}"}
        return httpx.get(f"http://127.0.0.1:{self.port}{path}", headers=headers, timeout=20)

    def is_fresh(self) -> bool:
        assert self.process.poll() is None, self.log()
        answer = self.get("/v1/stations/bench-1/poses")
        return answer.status_code == 200 and not answer.json()["stale"]

    def end(self) -> int:
        """Exit code."""
        self.process.terminate()
        return self.process.wait(END_LIMIT_S)


def test_the_api_image_serves_what_a_worker_tracks(builder: Builder, tmp_path: Path) -> None:
    image = builder.build("api")
    packages = image.root / PACKAGES
    sys.stderr.write(f"api: {megabytes(packages):.0f} MB of packages\n")
    assert megabytes(packages) < LARGEST_API_MB
    assert [name for name in TRACKING_STACK if (packages / name).exists()] == []
    with redis_server() as redis:
        replica = Container(image, "api-1", tmp_path, {"SNAPFIT_STORE": redis.url})
        try:
            wait_for(replica.is_healthy, 90)
            assert replica.get("/readyz").status_code == 503
            with working(tmp_path, redis.url):
                wait_for(replica.is_fresh, 60)
            for path in ("/v1/stations", "/metrics", "/openapi.json", "/"):
                assert replica.get(path).status_code == 200, path
        finally:
            code = replica.end()
    assert code == 0
    assert "Traceback" not in replica.log()


def test_the_worker_image_finds_tracks_and_serves(builder: Builder, tmp_path: Path) -> None:
    begin_s = time.monotonic()
    image = builder.build("worker")
    built_s = time.monotonic() - begin_s
    packages = megabytes(image.root / PACKAGES)
    sys.stderr.write(f"worker: {built_s:.0f} s to build, {packages:.0f} MB of packages\n")
    single = Container(image, "snapfit", tmp_path, {})
    try:
        wait_for(single.is_healthy, 120)
        wait_for(single.is_fresh, FIRST_POSES_LIMIT_S)
        worker = single.get("/v1/stations/bench-1").json()["worker"]
        assert worker["phase"] == "running"
        assert single.get("/v1/overlay.jpg").content.startswith(b"\xff\xd8")
        code, out = single.run("snapfit", "key", "add", "headset-1")
        assert code == 0, out
        # What finds parts, cameras and recordings need of the system.
        for module in ("open3d", "onnxruntime", "cv2", "mcap", "numba", "isal"):
            code, out = single.run("python", "-c", f"import {module}")
            assert code == 0, out
        code, out = single.run("touch", "/opt/snapfit/x")
        assert (code, "Read-only file system" in out) == (1, True)
    finally:
        code = single.end()
    assert code == 0
    assert "Traceback" not in single.log()
    assert json.loads((tmp_path / "keys/keys.json").read_text())["keys"][1]["name"] == "headset-1"
    assert (tmp_path / "keys/keys.json").stat().st_uid == USER
    assert {"kernels", "demo"} <= {path.name for path in (tmp_path / "cache").iterdir()}
    # Python's own tracker of shared memory ends a moment after whom it looks after.
    wait_for(lambda: not processes_of(USER), 5)


def processes_of(user: int) -> str:
    """Numbers of a user's processes, a line each."""
    asked = ["pgrep", "-u", str(user)]
    return subprocess.run(asked, capture_output=True, text=True, check=False).stdout
