"""A real browser that looks at the page: Debian's Chromium, driven by Playwright.

Debian's own, because what Playwright would download is not wanted here; drawn by SwiftShader,
because no graphics card is needed then.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from patience import within

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, LocatorAssertions, Page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
NODE_MODULES = Path(__file__).parents[2] / "clients" / "web" / "node_modules"
LIMIT_MS = 60_000
_ARGUMENTS = [
    *("--no-sandbox", "--disable-quic", "--disable-background-networking"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
]

# What the page's own sockets tell is kept beside, the newest of it: `window.told`, by exposure.
_LISTEN = """
window.told = new Map();
window.WebSocket = class extends WebSocket {
  constructor(...given) {
    super(...given);
    this.addEventListener("message", ({ data }) => {
      const snapshot = JSON.parse(data);
      window.told.set(snapshot.captured_at_us, snapshot);
      if (window.told.size > 200) window.told.delete(window.told.keys().next().value);
    });
  }
};
"""

needs_browser = pytest.mark.skipif(
    CHROMIUM is None or find_spec("playwright") is None,
    reason="there is no chromium to look with, or no playwright: snapfit[test]",
)


def expect(locator: Locator) -> LocatorAssertions:
    """Playwright's assertions, which wait; unlike `wait_for_function` they need no eval."""
    from playwright.sync_api import expect as playwrights

    playwrights.set_options(timeout=within(LIMIT_MS))
    return playwrights(locator)


def node_module(path: str) -> str:
    """A script from the page's development dependencies; skips the test where it is missing."""
    file = NODE_MODULES / path
    if not file.is_file():
        pytest.skip(f"{path} is not there: run `npm ci` in clients/web")
    return file.read_text(encoding="utf-8")


@contextmanager
def chromium() -> Iterator[Browser]:
    """One browser."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=_ARGUMENTS, timeout=within(LIMIT_MS)
        )
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def looking(
    browser: Browser,
    port: int,
    path: str = "",
    *,
    size: tuple[int, int] = (1280, 800),
    before: str | None = None,
    live: bool = True,
) -> Iterator[Page]:
    """The page of a server, once it shows live poses; errors of its scripts are the test's.

    Args:
        browser: a running one.
        port: of the server, on loopback.
        path: of the page, with its query.
        size: of the window, px.
        before: a script to run before the page's own.
        live: whether to wait for live poses.
    """
    context = browser.new_context(viewport={"width": size[0], "height": size[1]})
    page = context.new_page()
    page.set_default_timeout(within(LIMIT_MS))
    errors: list[Any] = []
    page.on("pageerror", lambda error: errors.append(error))
    page.add_init_script(_LISTEN)
    if before is not None:
        page.add_init_script(before)
    try:
        page.goto(f"http://127.0.0.1:{port}/{path}")
        if live:
            page.wait_for_selector('#state[data-state="running"]')
            page.wait_for_selector("#step:not([hidden])")
        yield page
        assert errors == []
    finally:
        context.close()
