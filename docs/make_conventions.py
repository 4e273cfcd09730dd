"""Draws `docs/pictures/conventions_*.png`: frames, position zero, tooth and pair numbers, signs.

`./dev measure` runs it; alone it takes seconds: `.venv/bin/python docs/make_conventions.py`.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rc_context
from matplotlib.patches import Arc, PathPatch
from matplotlib.path import Path as Outline

import flankload as fl
from flankload.base.files import write_atomically
from flankload.base.rotation import turned
from flankload.plot.style import COLOURS, GREY, STEEL, STYLE, new_figure, png_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from flankload.result import Result

    Floats = NDArray[np.float64]

DOCS = Path(__file__).parent
SCENES = DOCS.parent / "examples" / "scenes"
#: Box behind a label, over the outlines.
LABEL = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.5}
#: Only the position zero.
AT_ZERO = {"positions.angles_deg": [0.0]}


def main() -> None:
    """Draw both pictures."""
    with rc_context(STYLE):
        figure = new_figure((9.2, 4.9))
        _draw_pair(figure.add_subplot(1, 2, 1), "external_gear", "External gears", outside=True)
        _draw_pair(figure.add_subplot(1, 2, 2), "internal_gear", "Internal gear", outside=False)
        write_atomically(DOCS / "pictures" / "conventions_gears.png", png_of(figure))
        figure = new_figure((9.2, 4.7))
        _draw_spline(figure.add_subplot(1, 2, 1))
        _draw_cam(figure.add_subplot(1, 2, 2))
        write_atomically(DOCS / "pictures" / "conventions_spline_cam.png", png_of(figure))


def _at_zero(name: str, **changes: object) -> Result:
    scene = fl.read_scene(SCENES / f"{name}.toml")
    changed = scene.to_dict()
    changed["positions"] = {}
    result = fl.solve(scene.from_dict(changed).replace(AT_ZERO | changes))
    assert isinstance(result, fl.Result)
    return result


def _draw_bodies(axes: Axes, result: Result) -> None:
    drawing = result.drawing
    bodies = (
        (drawing.outline_1, drawing.teeth_1, drawing.angle_1[0], 0.0),
        (drawing.outline_2, drawing.teeth_2, drawing.angle_2[0], drawing.center_distance_mm),
    )
    for z, (outline, teeth, angle, centre) in enumerate(bodies):
        sectors = [turned(outline, angle + 2 * np.pi * k / teeth) for k in range(teeth)]
        parts = [np.vstack(sectors)]
        rim = (drawing.bore_radius_1_mm, drawing.bore_radius_2_mm)[z]
        if z == 1 and drawing.is_around:
            turn = np.linspace(0.0, -2 * np.pi, 361)
            parts.append((rim or 0.0) * np.stack([np.cos(turn), np.sin(turn)], axis=1))
        outlines = [Outline(part + np.array([centre, 0.0]), closed=True) for part in parts]
        axes.add_patch(
            PathPatch(
                Outline.make_compound_path(*outlines),
                facecolor=STEEL[z], edgecolor="#404040", linewidth=0.8,
            )
        )  # fmt: skip
    axes.set_aspect("equal")
    axes.set_axis_off()


def _draw_pair(axes: Axes, name: str, title: str, *, outside: bool) -> None:
    """The pair around the pitch point, with axes, pairs, teeth and directions."""
    result = _at_zero(name)
    _draw_bodies(axes, result)
    drawing, geometry = result.drawing, result.geometry
    assert geometry is not None
    distance, side = drawing.center_distance_mm, 1.0 if outside else -1.0
    ratio = drawing.teeth_2 / drawing.teeth_1
    working = distance / (ratio + 1.0) if outside else distance / (ratio - 1.0)
    base = result.reference_radius_mm
    alpha = np.arccos(base / working)
    pitch_point = np.array([side * working, 0.0])
    along = side * np.array([np.sin(alpha), np.cos(alpha)])
    base_pitch = 2 * np.pi * base / drawing.teeth_1
    reach = 1.45 * base_pitch
    ends = np.stack([pitch_point - reach * along, pitch_point + reach * along])
    axes.plot(*ends.T, color=GREY, linewidth=1.0, linestyle="--")
    arrow = {"arrowstyle": "-|>", "color": GREY}
    axes.annotate("", ends[1], ends[1] - 0.2 * reach * along, arrowprops=arrow)
    axes.text(
        *(ends[1] + side * np.array([0.0, 0.04 * reach])), "recess", color=GREY, ha="center",
        va="bottom" if outside else "top",
    )  # fmt: skip
    for pair in (-1, 0, 1):
        place = pitch_point + pair * base_pitch * along
        axes.plot(*place, "o", color=COLOURS[1], markersize=6)
        offset = np.array([0.28 * base_pitch, -0.12 * base_pitch * side])
        axes.annotate(
            f"pair {pair}".replace("-", "−"), place + offset * [1.0 if outside else -1.0, 1.0],
            color=COLOURS[1], ha="left" if outside else "right", va="center", fontweight="bold",
            bbox=LABEL,
        )  # fmt: skip
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    _name_teeth(axes, result, side, working, outside)
    half = 1.75 * base_pitch
    axes.set_xlim(pitch_point[0] - half, pitch_point[0] + half)
    axes.set_ylim(-half, half)
    axes.set_title(title, loc="left")
    _mark_senses(axes, outside)


def _name_teeth(axes: Axes, result: Result, side: float, working: float, outside: bool) -> None:
    """Numbers of the teeth as in `pitch_errors_um`: in the order in which they meet."""
    drawing = result.drawing
    centres = (np.zeros(2), np.array([drawing.center_distance_mm, 0.0]))
    teeth = (drawing.teeth_1, drawing.teeth_2)
    angles = (drawing.angle_1[0], drawing.angle_2[0])
    for z in (0, 1):
        # teeth that point inwards: the frame's zero is the middle of a space
        inwards = z == 1 and not outside
        radius = working if z == 0 else abs(side * working - centres[1][0])
        radius *= 1.045 if inwards else 0.955
        pitch = 2 * np.pi / teeth[z]
        next_tooth = pitch if z == 1 and outside else -pitch
        for number in (0, 1):
            angle = angles[z] + (0.5 * pitch if inwards else 0.0) + number * next_tooth
            place = centres[z] + radius * np.array([np.cos(angle), np.sin(angle)])
            axes.text(
                *place, str(number), color=COLOURS[0], ha="center", va="center", fontweight="bold"
            )


def _mark_senses(axes: Axes, outside: bool) -> None:
    """Names of the bodies and their senses of rotation, in the corners."""
    box = {"transform": axes.transAxes, "fontsize": 9, "fontweight": "bold", "bbox": LABEL}
    if outside:
        axes.text(0.02, 0.02, "body 1 ↺\nfree to turn, torque", va="bottom", ha="left", **box)
        axes.text(0.98, 0.02, "body 2 ↻\nat its kinematic angle", va="bottom", ha="right", **box)
    else:
        axes.text(0.98, 0.02, "body 1 ↺", va="bottom", ha="right", **box)
        axes.text(0.02, 0.02, "body 2 ↺", va="bottom", ha="left", **box)


def _draw_spline(axes: Axes) -> None:
    """The spline with its tooth numbers."""
    result = _at_zero("spline")
    _draw_bodies(axes, result)
    teeth = result.drawing.teeth_1
    for tooth in (0, 1, 2, 3, 22, 23):
        angle = 2 * np.pi * tooth / teeth
        axes.text(
            20.5 * np.cos(angle), 20.5 * np.sin(angle), str(tooth), color=COLOURS[0], ha="center",
            va="center", fontweight="bold", fontsize=8,
        )  # fmt: skip
    axes.plot([0, 34], [0, 0], color=GREY, linewidth=0.7)
    axes.text(0, 0, "shaft ↺\nbody 1", ha="center", va="center", fontweight="bold")
    axes.text(0, -31.5, "hub, body 2", ha="center", va="center", fontweight="bold")
    axes.set_xlim(-40, 40)
    axes.set_ylim(-40, 40)
    axes.set_title("Spline: pair j is tooth j", loc="left")


def _draw_cam(axes: Axes) -> None:
    """The cam at angle zero, with the follower's angle."""
    result = _at_zero("cam")
    _draw_bodies(axes, result)
    assert result.follower_angle_rad is not None
    distance = result.drawing.center_distance_mm
    axes.plot([0, distance], [0, 0], color=GREY, linewidth=0.7)
    angle = float(np.degrees(result.follower_angle_rad[0]))
    tip = 70 * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    axes.plot([0, tip[0]], [0, tip[1]], color=COLOURS[1], linewidth=1.2)
    low, high = sorted((0.0, angle))
    axes.add_patch(Arc((0, 0), 50, 50, theta1=low, theta2=high, color=COLOURS[1], linewidth=1.2))
    axes.text(
        39, -6, f"{angle:.1f}°".replace("-", "−"), color=COLOURS[1], ha="center", va="center",
        fontweight="bold",
    )  # fmt: skip
    axes.text(-14, 18, "follower, body 1 ↺", ha="left", fontweight="bold")
    axes.text(distance, 40, "cam, body 2 ↻", ha="center", fontweight="bold")
    axes.set_xlim(-18, 120)
    axes.set_ylim(-69, 69)
    axes.set_title("Cam at its angle 0", loc="left")


if __name__ == "__main__":
    main()
