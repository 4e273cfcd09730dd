"""Pictures of docs/guide/explorer.md from a browser: `python docs/make_explorer_pictures.py`.

Further arguments are scenes whose pages are drawn beside them, into the current folder.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent.parent))

import flankload as fl
from tests.support.browser import Browser
from tests.support.paths import ROOT, SCENES

PICTURES = ROOT / "docs/pictures"
READY = "window.flankload_painted >= 0 && deep('canvas').length > 3"
#: Width and height of each window.
DESKTOP, PHONE = (1240, 900), (390, 900)
#: Seconds until derivatives have arrived and curves are drawn.
SETTLED_S = 4.0


def draw(
    scene: Path,
    path: Path,
    size: tuple[int, int] = DESKTOP,
    *,
    dark: bool = False,
    changes: dict[str, Any] | None = None,
) -> None:
    """Picture of the page of a scene, with a change after the first design."""
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder,
        fl.explore(scene, open_browser=False) as explorer,
        Browser(Path(folder)) as browser,
    ):
        width, height = size
        browser.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                     deviceScaleFactor=1, mobile=size == PHONE)  # fmt: skip
        colours = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        browser.call("Emulation.setEmulatedMedia", features=[colours])
        assert explorer.result is not None
        browser.open(explorer.url, READY)
        if changes:
            time.sleep(1.0)
            explorer.change(changes)
        time.sleep(SETTLED_S)
        browser.picture(path, whole=False)


def main(names: list[str]) -> None:
    """Draw the pictures of the page, or those of the scenes that are named."""
    if names:
        for name in names:
            draw(SCENES / f"{name}.toml", Path(f"{name}.png"), (1240, 1500))
        return
    relief = {"body_1.tip_relief_um": 45, "body_2.tip_relief_um": 45}
    gear, helical = SCENES / "external_gear.toml", SCENES / "helical_gear.toml"
    draw(gear, PICTURES / "explorer_gear.png", changes=relief)
    draw(helical, PICTURES / "explorer_helical.png", (1240, 1160), dark=True,
         changes={"pair.deviation_um_per_mm": 0.5})  # fmt: skip
    draw(gear, PICTURES / "explorer_phone.png", PHONE, changes=relief)


if __name__ == "__main__":
    main(sys.argv[1:])
