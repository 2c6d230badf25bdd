"""The page of a real `snapfit demo`, from its first picture until its server is stopped.

The tests go in this order: each leaves the demo as the next one needs it, the last two end it.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from browser import chromium, expect, looking, needs_browser
from drawn_parts import best_shift, collect, outside
from harness import Server, wait_for
from patience import within

from snapfit.models.asset import find_asset
from snapfit.models.camera import PinholeCamera

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = [needs_browser, pytest.mark.slow]

SNAPFIT = str(Path(sys.executable).with_name("snapfit"))
FIRST_START_LIMIT_S = 300
# Some rounds of the assembly, half a minute each: on a busy machine a part is lost in some.
ASSEMBLY_LIMIT_MS = 90_000


@pytest.fixture(scope="module")
def demo() -> Iterator[Server]:
    # From the recording's own first poses: how parts are found is other tests' business.
    server = Server(command=[SNAPFIT, "demo", "--detector", "none", "--port"])
    try:
        wait_for(server.answers, 60)
        wait_for(lambda: server.get("/readyz").status_code == 200, FIRST_START_LIMIT_S)
        yield server
    finally:
        server.end()


@pytest.fixture(scope="module")
def page(demo: Server) -> Iterator[Page]:
    with chromium() as browser, looking(browser, demo.port) as it:
        yield it


def test_the_card_advances_when_a_step_completes_by_itself(page: Page, demo: Server) -> None:
    limit_ms = within(ASSEMBLY_LIMIT_MS)
    expect(page.locator("#step-count")).to_have_text("Step 1 of 2", timeout=limit_ms)
    expect(page.locator("#step-count")).to_have_text("Step 2 of 2", timeout=limit_ms)
    expect(page.locator("#step-title")).to_have_text("Screw in the bolt")
    expect(page.locator("#announcer")).to_have_text("Step 2 of 2: Screw in the bolt")
    assert page.locator("#step-list [data-progress=finished]").count() == 1
    assert demo.get("/v1/assembly").json()["decided_by"] == "tracking"


def test_what_is_drawn_coincides_with_the_picture(page: Page, demo: Server) -> None:
    page.uncheck("#hints")
    shots = collect(page, 3, apart_us=1_000_000)
    page.check("#hints")
    cameras = demo.get("/v1/stations/bench-1").json()["facts"]["cameras"]
    names = [field.name for field in fields(PinholeCamera)]
    camera = PinholeCamera(**{name: cameras[0][name] for name in names})
    asset = find_asset("hobby-corner-clamp")
    meshes = {part.name: part.mesh for part in asset.parts}
    for shot in shots:
        assert shot.picture_at_us == shot.snapshot["captured_at_us"]
        expected = shot.expected(camera, meshes)
        assert outside(shot.drawn, expected, 2) < 0.01
        assert outside(expected, shot.drawn, 2) < 0.01
        assert best_shift(shot.drawn, expected) == (0, 0)


def test_a_killed_worker_is_told_until_another_one_works(page: Page, demo: Server) -> None:
    pid = demo.worker()["pid"]
    os.kill(pid, signal.SIGKILL)
    page.wait_for_selector('[data-banner="stale"][role="alert"]')
    page.wait_for_selector('[data-banner="stale"]', state="detached")
    assert demo.worker()["pid"] != pid


def test_a_stopped_server_is_told(page: Page, demo: Server) -> None:
    demo.process.send_signal(signal.SIGTERM)
    page.wait_for_selector('[data-banner="unreachable"][role="alert"]')
    assert page.locator("body").get_attribute("data-stale") == "true"
