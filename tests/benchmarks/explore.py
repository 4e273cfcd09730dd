"""The explorer in a browser: milliseconds from an event to the painted answer, and of its start.

A slider moves by a step; the time ends after the frame in which its answer is drawn. Milliseconds
are those of this machine at this time: on a busy one they are mostly waiting.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from statistics import median

import flankload as fl
from tests.support.browser import Browser
from tests.support.paths import SCENES

#: Scene, key, and wanted milliseconds of the median.
CASES = (
    ("external_gear", "body_1.profile_crowning_um", 80.0),
    ("helical_gear", "pair.deviation_um_per_mm", 150.0),
)
#: Wanted seconds from the elements to the painted page.
WANTED_START_S = 2.0
EVENTS, QUIET_MS = 15, 200
READY = "window.flankload_painted >= 1 && deep('canvas').length > 3"
#: A step of the first slider when no answer has been painted for some time, and the milliseconds
#: until one is.
STEP = f"""(async () => {{
  const pause = ms => new Promise(done => setTimeout(done, ms));
  let before = null;
  while (before !== window.flankload_painted) {{
    before = window.flankload_painted;
    await pause({QUIET_MS});
  }}
  const begin = performance.now();
  const key = new KeyboardEvent("keydown", {{key: "ArrowRight", bubbles: true}});
  deep('.noUi-handle')[0].dispatchEvent(key);
  while (window.flankload_painted === before) await pause(1);
  return performance.now() - begin;
}})()"""


def run() -> str:
    """Measure and return the table."""
    lines = [f"{'scene':>16}{'start':>9}{'median':>9}{'least':>9}{'most':>9}{'wanted':>9}",
             f"{'':>16}{'s':>9}{'ms':>9}{'ms':>9}{'ms':>9}{'ms':>9}"]  # fmt: skip
    for name, path, wanted_ms in CASES:
        start_s, times = _measured(name, path)
        lines.append(
            f"{name:>16}{start_s:>9.2f}{median(times):>9.0f}{min(times):>9.0f}{max(times):>9.0f}"
            f"{wanted_ms:>9.0f}"
        )
    words = "start: from the address to the painted page, elements solved; wanted"
    lines.append(f"{words}: {WANTED_START_S:g} s")
    return "\n".join(lines)


def _measured(name: str, path: str) -> tuple[float, list[float]]:
    """Seconds of the start, and milliseconds of each event."""
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
        fl.explore(SCENES / f"{name}.toml", [path], open_browser=False) as explorer,
        Browser(Path(folder)) as browser,
    ):
        assert explorer.result is not None
        begin = time.monotonic()
        browser.open(explorer.url, READY)
        start_s = time.monotonic() - begin
        times = []
        for _ in range(EVENTS):
            explorer.worker.do(int).result()  # after the answer at rest and the derivatives
            times.append(browser.value(STEP))
        return start_s, times
