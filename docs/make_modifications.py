"""Draws `docs/pictures/metal_removed.png`: where each key along the axis removes metal.

`./dev measure` runs it; alone it takes seconds: `.venv/bin/python docs/make_modifications.py`.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context

import flankload as fl
from flankload.base.files import write_atomically
from flankload.bodies.flank_surface import section_curves
from flankload.bodies.profile_deviation import deviation_at
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.plot.style import STYLE, new_figure, png_of

DOCS = Path(__file__).parent
SCENE = DOCS.parent / "examples" / "scenes" / "helical_gear.toml"
#: Keys of body 1, or of [pair], each alone, with the amounts that are drawn.
PANELS: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("lead_crowning_um = 10", "body_1", {"lead_crowning_um": 10.0}),
    ("helix_slope_um = 10", "body_1", {"helix_slope_um": 10.0}),
    ("helix_slope_um = -10", "body_1", {"helix_slope_um": -10.0}),
    (
        "end_relief_um = [5, 10]\nend_relief_length_mm = [4, 8]",
        "body_1",
        {"end_relief_um": [5.0, 10.0], "end_relief_length_mm": [4.0, 8.0]},
    ),
    ("profile_twist_um = 20", "body_1", {"profile_twist_um": 20.0}),
    ("profile_twist_um = -20", "body_1", {"profile_twist_um": -20.0}),
    (
        'topography_file =\n"../topographies/pinion.csv"',
        "body_1",
        {"topography_file": "../topographies/pinion.csv"},
    ),
    ("[pair] inclination_um_per_mm = 1", "pair", {"inclination_um_per_mm": 1.0}),
    ("[pair] deviation_um_per_mm = 1", "pair", {"deviation_um_per_mm": 1.0}),
)
#: Keys of the scene that the panels do without.
REMOVED = ("tip_relief_um", "tip_relief_start_diameter_mm", "tip_relief_shape", "lead_crowning_um")
LARGEST_UM = 12.5
POINTS = 60


def main() -> None:
    """Draw all panels."""
    with rc_context(STYLE):
        figure = new_figure((9.6, 8.4))
        for number, (title, table, keys) in enumerate(PANELS, start=1):
            pair = _pair(table, keys)
            assert pair.slices is not None
            diameters, gap_um = _gap_um(pair)
            axes = figure.add_subplot(3, 3, number)
            axes.grid(visible=False)
            z = pair.slices.edges_mm - pair.slices.edges_mm[0]
            colours = axes.pcolormesh(
                z, diameters, gap_um, cmap="RdBu_r", vmin=-LARGEST_UM, vmax=LARGEST_UM
            )
            middle = 0.5 * (z[1:] + z[:-1]), 0.5 * (diameters[1:] + diameters[:-1])
            lines = axes.contour(
                *middle, gap_um, levels=np.arange(-12, 13, 2), colors="#444444", linewidths=0.6
            )
            axes.clabel(lines, fontsize=7, fmt="%g")
            axes.set_title(title, fontsize=9, family="DejaVu Sans Mono", fontweight="normal")
            axes.set_xticks([0.0, 12.5, 25.0], ["I", "12.5 mm", "II"])
            if number % 3 == 1:
                axes.set_ylabel("diameter in mm")
            if number > 6:
                axes.set_xlabel("face width, z from I to II")
        bar = figure.colorbar(colours, ax=figure.axes, shrink=0.5, aspect=30)
        bar.set_label("metal removed, or gap, in µm (negative: metal added, gap closed)")
    write_atomically(DOCS / "pictures" / "metal_removed.png", png_of(figure))


def _pair(table: str, keys: dict[str, Any]) -> BodyPair:
    """The helical pair with these keys alone, in narrow slices."""
    tables = tomllib.loads(SCENE.read_text(encoding="utf-8"))
    for body in ("body_1", "body_2"):
        tables[body] = {key: v for key, v in tables[body].items() if key not in REMOVED}
    tables[table] |= keys
    tables["accuracy"] = {"slices": POINTS}
    return build_bodies(fl.Scene.from_dict(tables, file=SCENE))


def _gap_um(pair: BodyPair) -> tuple[np.ndarray, np.ndarray]:
    """Diameters (m + 1,) and gap (m, J) between them, as the core gets it; body 2 with the axes."""
    body, slices = pair.body_1, pair.slices
    assert slices is not None
    assert body.involute is not None
    s = np.linspace(*body.mode_range_mm, POINTS + 1)
    diameters = 2.0 * np.hypot(*body.curve.point(s).T)
    middle = 0.5 * (s[1:] + s[:-1])
    gap = np.tile(slices.removed_mm[0] + slices.removed_mm[1], (POINTS, 1))
    if slices.surfaces_mm[0] is not None:
        curves = section_curves(body, slices.surfaces_mm[0])
        deviations = [deviation_at(body.involute, curve.point(middle))[1] for curve in curves]
        gap -= np.array(deviations).T
    return diameters, 1000.0 * gap


if __name__ == "__main__":
    main()
