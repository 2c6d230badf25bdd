"""The page in a real browser, without a screen; skipped where there is no Chromium.

One server with swaying parts for all tests that do it no harm, one browser for all.
"""

from __future__ import annotations

import itertools
import os
import re
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from browser import chromium, expect, looking, needs_browser, node_module
from drawn_parts import centroid, collect, outside
from harness import START_LIMIT_S, Server, running, wait_for
from scripted_pipeline import CAMERA, PART_NAMES, _triangle

from snapfit.server.security.key_file import add_key
from snapfit.server.security.roles import Role

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = needs_browser

_FEW_PX = 1.5


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as it:
        yield it


@pytest.fixture(scope="module")
def bench() -> Iterator[Server]:
    with running("sways") as server:
        yield server.wait_ready()


@pytest.fixture(scope="module")
def page(browser: Browser, bench: Server) -> Iterator[Page]:
    with looking(browser, bench.port) as it:
        yield it


def test_it_shows_every_part_with_its_status(page: Page, bench: Server) -> None:
    for part in bench.get("/v1/poses").json()["parts"]:
        row = page.locator(f'#parts tr[data-part="{part["part"]}"]')
        assert row.get_attribute("data-status") == part["status"]
        assert f"{round(part['confidence'] * 100)} %" in row.inner_text()
    assert page.locator("#transport").inner_text() == "websocket"
    assert "cap is not seen any more" in page.locator('[data-banner="lost"]').inner_text()


def test_what_is_drawn_coincides_with_the_picture(page: Page) -> None:
    page.uncheck("#hints")  # the ghost is no part of it
    shots = collect(page, 3, apart_us=300_000)
    page.check("#hints")
    meshes = dict.fromkeys(PART_NAMES, _triangle())
    middles = []
    for shot in shots:
        assert shot.picture_at_us == shot.snapshot["captured_at_us"]
        expected = shot.expected(CAMERA.color, meshes)
        # Edges are drawn as lines, which reach a pixel beyond.
        assert outside(shot.drawn, expected, 2) < 0.005
        assert outside(expected, shot.drawn, 1) < 0.005
        middles.append((centroid(shot.drawn), centroid(expected)))
        assert np.linalg.norm(middles[-1][0] - middles[-1][1]) < _FEW_PX
    # They sway: what is drawn goes with the poses.
    ways = [(drawn - middles[0][0], true - middles[0][1]) for drawn, true in middles[1:]]
    assert max(np.linalg.norm(true) for _, true in ways) > 2 * _FEW_PX
    assert all(np.linalg.norm(drawn - true) < _FEW_PX for drawn, true in ways)


def test_without_the_picture_parts_move_smoothly(page: Page) -> None:
    page.check('input[value="parts"]', force=True)
    moments = page.evaluate(
        """() => new Promise((resolve) => {
            const moments = [];
            document.getElementById("overlay").addEventListener("drawn", ({ detail }) => {
                moments.push(detail.atUs);
                if (moments.length === 8) resolve(moments);
            });
        })"""
    )
    page.check('input[value="both"]', force=True)
    assert all(earlier < later for earlier, later in itertools.pairwise(moments))


def test_the_hints_are_where_their_parts_are(page: Page) -> None:
    texts = page.locator("#step-hints li").all_text_contents()
    assert texts == ["This side up (jaw)"]
    where = page.evaluate(
        """() => new Promise((resolve) => {
            document.getElementById("overlay").addEventListener("drawn", ({ detail }) => {
                const box = document.querySelector(".point").getBoundingClientRect();
                const stage = document.getElementById("stage").getBoundingClientRect();
                const x = (box.x + box.width / 2 - stage.x) / stage.width;
                const y = (box.y + box.height / 2 - stage.y) / stage.height;
                resolve({ x, y });
            }, { once: true });
        })"""
    )
    # (0.1, 0.2, 0.3) in the jaw's frame: in view, right of the middle or near it, and low.
    assert 0.3 < where["x"] < 1
    assert 0.5 < where["y"] < 1


def test_an_operator_goes_on_and_back_by_keyboard_alone(page: Page, bench: Server) -> None:
    title = page.locator("#step-title")
    assert title.inner_text() == "Mount the jaw"
    assert page.locator("#step-count").inner_text() == "Step 1 of 2"
    reached = []
    page.focus(".skip")
    for _ in range(20):
        reached.append(page.evaluate("document.activeElement.id || document.activeElement.name"))
        style = "getComputedStyle(document.activeElement).outlineStyle"
        if reached[-1] not in {"view", ""}:  # a radio button's focus is drawn on its label
            assert page.evaluate(style) != "none", reached[-1]
        if reached[-1] == "next":
            break
        page.keyboard.press("Tab")
    assert {"view", "hints", "zoom", "full", "back", "next"} <= set(reached)
    page.keyboard.press("Enter")
    expect(title).to_have_text("Screw in the bolt")
    assert bench.get("/v1/assembly").json()["decided_by"] == "operator"
    expect(page.locator("#announcer")).to_have_text("Step 2 of 2: Screw in the bolt")
    page.keyboard.press("Alt+PageUp")
    expect(title).to_have_text("Mount the jaw")
    assert bench.get("/v1/assembly").json()["state"] == "free"


@pytest.mark.parametrize("size", [(360, 740), (768, 1024), (1920, 1080)], ids=str)
def test_it_fits_and_everybody_can_use_it(
    browser: Browser, bench: Server, size: tuple[int, int]
) -> None:
    axe = node_module("axe-core/axe.min.js")
    with looking(browser, bench.port, size=size) as it:
        assert it.evaluate("document.documentElement.scrollWidth") <= size[0]
        wide = "[...document.querySelectorAll('button, input, a, section, .banner')]"
        edges = it.evaluate(f"{wide}.map((each) => each.getBoundingClientRect().right)")
        assert max(edges) <= size[0]
        assert _violations(it, axe) == []


def test_everybody_can_read_the_documentation(browser: Browser, bench: Server) -> None:
    axe = node_module("axe-core/axe.min.js")
    with looking(browser, bench.port, "docs", size=(360, 740), live=False) as it:
        it.wait_for_selector("#PoseSnapshot", state="attached")
        assert it.evaluate("document.documentElement.scrollWidth") <= 360
        assert _violations(it, axe) == []
        sources = it.evaluate(
            "[...document.querySelectorAll('[src], link')].map((e) => e.src || e.href)"
        )
        assert all(source.startswith(f"http://127.0.0.1:{bench.port}/") for source in sources)
        text = it.evaluate("document.body.textContent")
    for path, operations in bench.get("/openapi.json").json()["paths"].items():
        for method in operations:
            assert f"{method.upper()} {path}" in text


def _violations(page: Page, axe: str) -> list[str]:
    page.evaluate(axe)
    found = page.evaluate("axe.run().then((result) => result.violations)")
    bad = [one for one in found if one["impact"] in {"serious", "critical"}]
    return [f"{one['id']}: {[node['html'][:120] for node in one['nodes']]}" for one in bad]


def test_it_gets_by_without_websockets_streams_and_webgl(browser: Browser, bench: Server) -> None:
    poor = """
        window.WebSocket = class {
            constructor() { setTimeout(() => this.onclose(), 5); }
            close() {}
        };
        const getContext = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
            return kind.startsWith("webgl") ? null : getContext.call(this, kind, ...more);
        };
    """
    with looking(browser, bench.port, live=False) as it:
        it.add_init_script(poor)
        it.route("**/overlay.mjpeg", lambda route: route.abort())
        # The first one may be too late for a worker that is held up.
        with it.expect_response(
            lambda answer: "/overlay.jpg" in answer.url and answer.status == 200
        ):
            it.reload()
        it.wait_for_selector('#state[data-state="running"]')
        expect(it.locator("#transport")).to_have_text("long-poll")
        assert it.locator("#stage").get_attribute("data-webgl") == "false"
        expect(it.locator("#rate")).to_have_text(re.compile(r"^[1-9]"))


def test_it_says_when_worker_or_server_is_gone(browser: Browser) -> None:
    with running() as server:
        server.wait_ready()
        with looking(browser, server.port) as it:
            # Stopped, not ended: the supervisor has no reason yet to start another.
            pid = server.worker()["pid"]
            os.kill(pid, signal.SIGSTOP)
            it.wait_for_selector('[data-banner="stale"][role="alert"]')
            expect(it.locator('[data-banner="stale"]')).to_contain_text("Do not rely")
            assert it.locator("body").get_attribute("data-stale") == "true"
            with suppress(ProcessLookupError):  # by now it may have
                os.kill(pid, signal.SIGKILL)
            it.wait_for_selector('[data-banner="stale"]', state="detached")
            server.process.send_signal(signal.SIGKILL)
            it.wait_for_selector('[data-banner="unreachable"][role="alert"]')
            expect(it.locator("#state")).to_have_text("unreachable")


def test_it_says_what_is_wrong_and_advances_with_the_assembly(browser: Browser) -> None:
    with running("assembles") as server:
        server.wait_ready()
        with looking(browser, server.port) as it:
            # Each state lasts a third of a second: too short to wait for one after the other.
            told = it.evaluate(
                """() => new Promise((resolve) => {
                    const told = new Set();
                    const title = document.getElementById("step-title");
                    const look = () => {
                        told.add(title.textContent);
                        const wrong = '[data-banner="misassembled"][role="alert"]';
                        for (const banner of document.querySelectorAll(wrong)) {
                            told.add(banner.querySelector("p").textContent);
                        }
                        if (told.size === 4) resolve([...told].sort());
                    };
                    const watch = { childList: true, subtree: true, characterData: true };
                    new MutationObserver(look).observe(document.body, watch);
                })"""
            )
    wrong = "Put together wrongly pin on base is in the wrong place, 12 mm off."
    assert told == ["All done", "Mount the jaw", wrong, "Screw in the bolt"]


def test_it_asks_for_a_key_and_takes_one(
    browser: Browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    key = add_key(tmp_path / "keys.json", "tablet", Role.READ)
    monkeypatch.setenv("SNAPFIT_SECURITY__KEYS", "on")
    monkeypatch.setenv("SNAPFIT_SECURITY__KEYS_FILE", str(tmp_path / "keys.json"))
    with running() as server:
        wait_for(server.answers, START_LIMIT_S)
        with looking(browser, server.port, live=False) as it:
            it.wait_for_selector("#key-form:not([hidden])")
            it.fill("#key", "sf_wrong")
            it.press("#key", "Enter")
            expect(it.locator("#key-problem")).not_to_be_empty()
            it.fill("#key", key)
            it.press("#key", "Enter")
            it.wait_for_selector('#state[data-state="running"]')
            assert it.locator("#key-form").is_hidden()
            it.click("#next")
            expect(it.locator("#command")).to_contain_text("operator's key")
        with looking(browser, server.port, f"?key={key}") as it:
            assert key not in it.url
            assert key not in it.content()


def test_it_shows_the_station_that_is_wished(
    browser: Browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SNAPFIT_STATIONS", '[{"name": "left"}, {"name": "right"}]')
    with running() as server:
        server.wait_ready()
        with looking(browser, server.port, "?station=right") as it:
            expect(it.locator("#station")).to_have_text("right · Scripted")
            assert it.locator("#stations [aria-current]").inner_text() == "right"
            it.click("#stations >> text=left")
            expect(it.locator("#station")).to_have_text("left · Scripted")
