"""How quickly the page draws: python tests/bench/page_speed.py ADDRESS.

ADDRESS is that of a running server, such as one that `snapfit demo --asset nano-chuck --detector
none` tells (eight parts). Chromium's main thread is slowed four times, as on a phone; pictures are
drawn by SwiftShader, in software, unless `--gpu` is given.
"""

from __future__ import annotations

import json
import math
import shutil
import sys
from typing import Any

from playwright.sync_api import sync_playwright

SECONDS = 10
LONGEST_S = 30
FRAMES = 60
SLOWER = 4
SOFTWARE = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
SIZE = {"width": 412, "height": 915}
# The page's animation callback is timed by wrapping what it hands over.
_TIMED = """
window.taken = [];
const ask = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (act) => ask((time) => {
  const from = performance.now();
  act(time);
  window.taken.push([time, performance.now() - from]);
});
"""


def main() -> int:
    address = sys.argv[1]
    arguments = ["--no-sandbox"] if "--gpu" in sys.argv else ["--no-sandbox", *SOFTWARE]
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=chromium, args=arguments)
        page = browser.new_page(viewport=SIZE)  # type: ignore[arg-type]
        page.add_init_script(_TIMED)
        page.goto(address)
        page.set_default_timeout(120_000)
        page.wait_for_selector('#state[data-state="running"]')
        page.wait_for_selector("#step:not([hidden])")
        for view in ("both", "parts"):
            page.check(f'input[value="{view}"]', force=True)
            page.wait_for_timeout(3000)
            sys.stdout.write(json.dumps({"view": view, **measured(page)}) + "\n")
        browser.close()
    return 0


def measured(page: Any) -> dict[str, float]:
    """Frames a second, and what a frame costs.

    `main_ms` is processor time of Chromium's main thread for a frame, all that the page does in
    it included, not slowed: it does not depend on what else the machine does, as times by the
    clock do (`frames_a_second`, `callback_ms_median`; these with the main thread slowed).
    """
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})
    before = _busy_s(session)
    frames = len(_frames(page))
    busy_s = _busy_s(session) - before
    session.send("Emulation.setCPUThrottlingRate", {"rate": SLOWER})
    taken = _frames(page)
    session.send("Emulation.setCPUThrottlingRate", {"rate": 1})
    took = sorted(ms for _, ms in taken)
    seconds = (taken[-1][0] - taken[0][0]) / 1000 if len(taken) > 1 else math.inf
    return {
        "parts": page.evaluate("document.querySelectorAll('#parts tr').length"),
        "main_ms": round(busy_s * 1000 / max(frames, 1), 2),
        "frames": frames,
        "frames_a_second": round((len(taken) - 1) / seconds, 2),
        "callback_ms_median": round(took[len(took) // 2], 2) if took else math.inf,
    }


def _busy_s(session: Any) -> float:
    metrics = session.send("Performance.getMetrics")["metrics"]
    return float(next(one["value"] for one in metrics if one["name"] == "TaskDuration"))


def _frames(page: Any) -> list[tuple[float, float]]:
    """Time and duration of the frames of some seconds, or of more where they are few, ms."""
    page.evaluate("() => { window.taken.length = 0; }")
    for _ in range(LONGEST_S // SECONDS):
        page.wait_for_timeout(SECONDS * 1000)
        taken: list[tuple[float, float]] = page.evaluate("window.taken")
        if len(taken) >= FRAMES:
            break
    return taken


if __name__ == "__main__":
    sys.exit(main())
