"""How quickly the page draws: python tests/bench/page_speed.py ADDRESS [--gpu].

ADDRESS is that of a running server, such as one that `snapfit demo --asset nano-chuck --detector
none` tells (eight parts). A phone's processor is taken to be four times slower than this one. Three
things are told of each view, and they are not the same:

- `drawn_a_second`, by the clock, the main thread slowed four times by Chromium: what this machine
  shows. Without `--gpu` SwiftShader draws, in software, on the same cores as everything else.
- `drawing_ms`, the processor time of the page's own animation callback, 200 in a row, times four.
- `main_ms`, the processor time that the main thread takes for a frame at 60 Hz (script, style,
  layout, paint, and its share of all else that it does), times four: what of the 16.7 ms that
  there are the page itself would take on a phone. It comes out too high where frames are seldom:
  each then finds cold caches. For both the GPU process takes the page's
  commands and draws nothing, so that the main thread does not wait for it; it is told in
  processor time and does not depend on what else the machine does. What a graphics card and the
  compositor add is not in it.

For the last two the page is made to believe in a graphics card, so that it does what it does with
one: wide lines, and a drawing whenever there is a new moment to draw.
"""

from __future__ import annotations

import json
import shutil
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from main_thread import spent
from playwright.sync_api import Page, Playwright, ViewportSize, sync_playwright

SETTLE_S = 10
SECONDS = 10
LONGEST_S = 60
FRAMES = 60
WARM_UP, IN_A_ROW = 30, 200
SLOWER = 4
SOFTWARE = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
DRAW_NOTHING = "--disable-gl-drawing-for-tests"
SIZE: ViewportSize = {"width": 412, "height": 915}
CATEGORIES = ["devtools.timeline", "disabled-by-default-devtools.timeline"]
_BELIEVE = """
const open = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, how) {
  return open.call(this, kind, { ...how, failIfMajorPerformanceCaveat: false });
};
"""
# Callbacks are kept, to be called by us.
_KEEP = """
window.due = [];
window.requestAnimationFrame = (act) => window.due.push(act);
"""
_CALL = """
(count) => {
  let time = performance.now();
  for (let i = 0; i < count; i += 1) {
    const due = window.due;
    window.due = [];
    time += 50;
    for (const act of due) act(time);
  }
  return window.drawn;
}
"""
_COUNT = """
window.drawn = 0;
document.getElementById("overlay").addEventListener("drawn", () => { window.drawn += 1; });
"""


def main() -> int:
    address = sys.argv[1]
    real = ["--no-sandbox"] if "--gpu" in sys.argv else ["--no-sandbox", *SOFTWARE]
    with sync_playwright() as playwright:
        for view in ("both", "parts"):
            with opened(playwright, [*real, DRAW_NOTHING], address, view, _BELIEVE + _KEEP) as page:
                figures = {"drawing_ms": drawing_ms(page)}
            with opened(playwright, [*real, DRAW_NOTHING], address, view, _BELIEVE) as page:
                figures |= costs(page)
            with opened(playwright, real, address, view, "") as page:
                figures |= drawn(page)
            sys.stdout.write(json.dumps({"view": view, **figures}) + "\n")
            sys.stdout.flush()
    return 0


@contextmanager
def opened(
    playwright: Playwright, arguments: list[str], address: str, view: str, script: str
) -> Iterator[Page]:
    """The page in one of its views, when it has settled; a script is run before its own."""
    chromium = shutil.which("chromium")
    browser = playwright.chromium.launch(executable_path=chromium, args=arguments)
    page = browser.new_page(viewport=SIZE)
    page.set_default_timeout(180_000)
    page.add_init_script(script)
    page.goto(address)
    page.wait_for_selector('#state[data-state="running"]')
    page.wait_for_selector("#step:not([hidden])")
    page.check(f'input[value="{view}"]', force=True)
    page.evaluate(_COUNT)
    page.wait_for_timeout(SETTLE_S * 1000)
    yield page
    browser.close()


def drawing_ms(page: Page) -> float:
    """What the page's own callback takes, many in a row, four times slower, ms."""
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    def busy_s() -> float:
        metrics = session.send("Performance.getMetrics")["metrics"]
        return next(float(one["value"]) for one in metrics if one["name"] == "TaskDuration")

    drawn_before: int = page.evaluate(_CALL, WARM_UP)
    before_s = busy_s()
    count: int = page.evaluate(_CALL, IN_A_ROW) - drawn_before
    return round(SLOWER * (busy_s() - before_s) * 1000 / count, 2)


def costs(page: Page) -> dict[str, float]:
    """The main thread's share of a frame at 60 Hz, four times slower, ms."""
    browser = page.context.browser
    assert browser is not None
    browser.start_tracing(page=page, categories=CATEGORIES)
    count = wait_for_drawings(page)
    it = spent(json.loads(browser.stop_tracing())["traceEvents"])
    beside_ms = it.beside_ms_a_second / 60
    return {
        "parts": page.locator("#parts tr").count(),
        "main_ms": round(SLOWER * (it.frame_ms + beside_ms), 2),
        "of_frame_ms": round(SLOWER * it.frame_ms, 2),
        "of_frame_ms_median": round(SLOWER * it.frame_ms_median, 2),
        "of_frame_ms_95": round(SLOWER * it.frame_ms_95, 2),
        "beside_ms": round(SLOWER * beside_ms, 2),
        "frames": it.frames,
        "drawn": count,
        "frames_a_second": round(it.frames / it.seconds, 1),
    }


def drawn(page: Page) -> dict[str, float]:
    """How often is drawn, by the clock."""
    session = page.context.new_cdp_session(page)
    session.send("Emulation.setCPUThrottlingRate", {"rate": SLOWER})
    from_s = time.monotonic()
    count = wait_for_drawings(page)
    return {"drawn_a_second": round(count / (time.monotonic() - from_s), 2)}


def wait_for_drawings(page: Page) -> int:
    """How often is drawn in some seconds, or in more where that is seldom."""
    before: int = page.evaluate("window.drawn")
    for _ in range(LONGEST_S // SECONDS):
        page.wait_for_timeout(SECONDS * 1000)
        count: int = page.evaluate("window.drawn") - before
        if count >= FRAMES:
            break
    return count


if __name__ == "__main__":
    sys.exit(main())
