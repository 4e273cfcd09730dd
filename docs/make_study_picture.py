"""Draws `docs/pictures/study_map.png`: transmission error over the tip relief of both gears.

`./dev measure` runs it; alone it takes seconds: `.venv/bin/python docs/make_study_picture.py`.
"""

from __future__ import annotations

from pathlib import Path

import flankload as fl
from flankload.base.files import write_atomically
from flankload.plot import study_figures
from flankload.plot.style import png_of

DOCS = Path(__file__).parent
SCENE = DOCS.parent / "examples" / "scenes" / "external_gear.toml"
ERROR = "transmission_error_peak_to_peak_um"
RELIEFS_UM = list(range(0, 81, 10))
CHANGES = {
    "body_1.tip_relief_um": 0,
    "body_2.tip_relief_um": 0,
    "body_1.tip_relief_shape": "parabolic",
    "body_2.tip_relief_shape": "parabolic",
    "body_1.tip_relief_start_diameter_mm": 76.5,
    "body_2.tip_relief_start_diameter_mm": 112.5,
    "positions.count": 24,
}


def main() -> None:
    """Solve the designs and draw the map."""
    study = fl.study(
        fl.read_scene(SCENE).replace(CHANGES),
        {"body_1.tip_relief_um": RELIEFS_UM, "body_2.tip_relief_um": RELIEFS_UM},
        quantities=[ERROR],
    )
    figure = study_figures(study)[f"map_{ERROR}"]()
    write_atomically(DOCS / "pictures" / "study_map.png", png_of(figure))


if __name__ == "__main__":
    main()
