"""Draws the two figures of the paper from two scenes of the examples (five seconds)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import flankload as fl

HERE = Path(__file__).resolve().parent
SCENES = HERE.parent / "examples" / "scenes"
SIZE_IN = (6.0, 2.8)


def draw_transmission_error(path: Path) -> None:
    """Transmission error of the FZG pair with sharp and with relieved tips, and its error."""
    plain = fl.read_scene(SCENES / "external_gear.toml")
    relieved = plain.replace(
        {
            "body_1.tip_relief_um": 30,
            "body_2.tip_relief_um": 30,
            "body_1.tip_relief_start_diameter_mm": 76.5,
            "body_2.tip_relief_start_diameter_mm": 112.5,
        }
    )
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    axes = figure.add_subplot()
    for scene, words in ((plain, "sharp tips"), (relieved, "tip relief of 30 µm")):
        result = fl.solve(scene)
        angle, error = np.degrees(result.position_rad), result.transmission_error_um
        uncertain = result.estimate["transmission_error"] * np.abs(error)
        [line] = axes.plot(angle, error, label=words)
        band = {"color": line.get_color(), "alpha": 0.4, "linewidth": 0}
        axes.fill_between(angle, error - uncertain, error + uncertain, **band)
    axes.set_xlabel("rotation of the pinion, degrees")
    axes.set_ylabel("transmission error, µm")
    axes.legend(frameon=False)
    figure.savefig(path, dpi=200)


def draw_planets(path: Path) -> None:
    """Share of each planet of a stage with one pin out of place, over a mesh period."""
    result = fl.solve(fl.read_scene(SCENES / "planetary_stage.toml"))
    forces = np.linalg.norm(result.drive.pin_force_N, axis=2)
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    axes = figure.add_subplot()
    shares = 100.0 * forces / forces.sum(axis=1, keepdims=True)
    axes.plot(np.degrees(result.position_rad), shares)
    axes.set_xlabel("rotation of the sun, degrees")
    axes.set_ylabel("share of the planet, %")
    axes.legend([f"planet {k + 1}" for k in range(shares.shape[1])], frameon=False, ncols=4)
    figure.savefig(path, dpi=200)


if __name__ == "__main__":
    draw_transmission_error(HERE / "transmission_error.png")
    draw_planets(HERE / "planets.png")
