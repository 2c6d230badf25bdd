"""The page in a real browser, without a screen; skipped where there is no Chromium."""

import os
import re
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
from harness import Server, running, wait_for

from snapfit.server.security.key_file import add_key
from snapfit.server.security.roles import Role

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium to look with")
PAGE_TIME_MS = 3000


def page_as_seen(server: Server, profile: Path, path: str = "") -> str:
    """The document as it stands after some seconds of the page's own time."""
    assert CHROMIUM is not None
    done = subprocess.run(
        [
            CHROMIUM,
            *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync"),
            *("--disable-background-networking", "--disable-component-update", "--disable-quic"),
            f"--user-data-dir={profile}",
            f"--virtual-time-budget={PAGE_TIME_MS}",
            "--dump-dom",
            f"http://127.0.0.1:{server.port}/{path}",
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return done.stdout


def test_it_shows_every_part_with_status_and_the_picture(server: Server, tmp_path: Path) -> None:
    poses = server.get("/v1/poses").json()
    page = page_as_seen(server, tmp_path)
    body = page[page.index('<tbody id="parts">') : page.index("</tbody>")]
    for part in poses["parts"]:
        assert f">{part['part']}<" in body
        assert part["status"] in body
    assert 'data-state="running"' in page
    assert re.search(r'<img id="picture"[^>]*src="[^"]+"', page)


def test_it_warns_when_the_worker_is_gone(tmp_path: Path) -> None:
    with running() as server:
        server.wait_ready()
        # Stopped, not ended: the supervisor has no reason yet to start another.
        os.kill(server.worker()["pid"], signal.SIGSTOP)
        page = page_as_seen(server, tmp_path)
    assert 'data-state="stale"' in page
    assert "Do not rely on them" in page


def test_it_asks_for_a_key_and_takes_one_from_the_address(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    key = add_key(tmp_path / "keys.json", "tablet", Role.READ)
    monkeypatch.setenv("SNAPFIT_SECURITY__KEYS", "on")
    monkeypatch.setenv("SNAPFIT_SECURITY__KEYS_FILE", str(tmp_path / "keys.json"))
    with running() as server:
        wait_for(server.answers)
        page = page_as_seen(server, tmp_path / "without")
        assert '<form id="key-form" class="key">' in page
        assert "A key is needed" in page
        headers = {"Authorization": f"Bearer {key}"}
        wait_for(lambda: server.get("/readyz", headers=headers).status_code == 200)
        page = page_as_seen(server, tmp_path / "with", f"?key={key}")
    assert '<form id="key-form" class="key" hidden="">' in page
    assert 'data-state="running"' in page
    assert key not in page


def test_the_documentation_needs_no_internet(server: Server, tmp_path: Path) -> None:
    page = page_as_seen(server, tmp_path, "docs")
    assert "//" not in re.sub(
        r"https?://127\.0\.0\.1", "", " ".join(re.findall(r'src="[^"]*"', page))
    )
    for path, operations in server.get("/openapi.json").json()["paths"].items():
        for method in operations:
            assert f"{method.upper()} {path}<" in page
    assert '<details id="PoseSnapshot">' in page


def test_it_shows_the_station_that_is_wished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SNAPFIT_STATIONS", '[{"name": "left"}, {"name": "right"}]')
    with running() as server:
        server.wait_ready()
        page = page_as_seen(server, tmp_path, "?station=right")
    assert 'data-state="running"' in page
    assert "right · scripted-asset" in page
    assert '<a href="?station=left">left</a>' in page
