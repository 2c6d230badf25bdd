"""The page in a real browser, without a screen; skipped where there is no Chromium."""

import os
import re
import shutil
import signal
import subprocess
from pathlib import Path

import pytest
from harness import Server, running

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium to look with")
PAGE_TIME_MS = 3000


def page_as_seen(server: Server, profile: Path) -> str:
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
            f"http://127.0.0.1:{server.port}/",
        ],
        capture_output=True,
        text=True,
        timeout=60,
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
