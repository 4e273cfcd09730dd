"""Profile of a disc cam: a closed smooth curve through the rows of its table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.plane import across, directions
from flankload.errors import SceneError
from flankload.flank import CurvePiece, FlankCurve, fit_flank_curve
from flankload.flank.fit import TOLERANCE
from flankload.meshes.io.named_arrays import read_columns
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.base.arrays import Floats
    from flankload.flank import Place
    from flankload.scene import Cam


LEAST_ROWS = 8
#: Largest angle between rows, deg; with a larger one the curve between them is arbitrary.
LARGEST_STEP_DEG = 30.0
#: Tolerances within which a last row repeats the first one and so closes the turn.
SAME_ANGLE_DEG = 1e-9
SAME_RADIUS_MM = 1e-6
#: Largest turn of the curve at a row beyond that of its neighbours, rad; a larger one is a kink, or
#: a nose between two rows.
LARGEST_KINK = 0.2
#: Least wall between bore and profile, relative to the least radius.
LEAST_WALL = 0.02


@dataclass(frozen=True)
class CamProfile:
    """Profile of a cam.

    Attributes
    ----------
    curve : FlankCurve
        Closed and clockwise, so that the material is on its right.
    least_radius_mm, largest_radius_mm : float
        Radii of the curve about the axis.
    """

    curve: FlankCurve
    least_radius_mm: float
    largest_radius_mm: float


def cam_profile(spec: Cam, key: str, *, folder: Path) -> CamProfile:
    """Profile of a cam from its table, here or in a file of the folder.

    Raises
    ------
    SceneError
        If the table does not give a closed smooth curve around the bore; names the row.
    """
    if spec.profile_file is not None:
        name = f"{key}.profile_file"
        rows = read_columns(folder / spec.profile_file, name, ("angle_deg", "radius_mm"))
    else:
        name = f"{key}.profile"
        rows = np.array(spec.profile, dtype=float).reshape(-1, 2)
    angle, radius = _one_turn(rows, name)
    place = _closed_spline(angle, radius)
    # clockwise: from one turn beyond the first row's angle down to that angle
    pieces = [CurvePiece("flank", place, angle[-1], angle[0], knots=angle[-2:0:-1])]
    _check_kinks(place, angle, name)
    # the length is that of a whole turn; the radius is closer to the size of a flank
    curve = fit_flank_curve(pieces, tolerance_mm=TOLERANCE * float(radius.max()))
    radii = np.hypot(*curve.point(np.linspace(0.0, curve.length_mm, 8 * len(curve.labels) + 1)).T)
    least, largest = float(radii.min()), float(radii.max())
    if 0.5 * spec.bore_diameter_mm > (1 - LEAST_WALL) * least:
        expected = f"at most {1 - LEAST_WALL:g} of twice the least radius of the profile: "
        expected += f"{2 * (1 - LEAST_WALL) * least:.4f}"
        refuse(f"{key}.bore_diameter_mm", expected, f"{spec.bore_diameter_mm:g}")
    return CamProfile(curve, least, largest)


def _one_turn(rows: Floats, key: str) -> tuple[Floats, Floats]:
    """Angles in rad (n + 1,), ascending over exactly one turn, and radii; the last is the first."""

    def refuse(expected: str, found: str) -> None:
        raise SceneError(key=key, expected=expected, found=found)

    if len(rows) < LEAST_ROWS:
        refuse(f"at least {LEAST_ROWS} rows of angle and radius", f"{len(rows)}")
    angle, radius = rows.T
    steps = np.diff(angle)
    if (steps <= 0).any():
        k = int(np.flatnonzero(steps <= 0)[0])
        refuse("ascending angles", f"{angle[k + 1]:g} deg behind {angle[k]:g} deg in row {k + 2}")
    span = angle[-1] - angle[0]
    if span > 360.0 + SAME_ANGLE_DEG:
        refuse("angles within one turn", f"{angle[0]:g} to {angle[-1]:g} deg")
    if span > 360.0 - SAME_ANGLE_DEG:
        if abs(radius[-1] - radius[0]) > SAME_RADIUS_MM:
            refuse(
                "a periodic table, whose last row repeats the radius of the first one a turn on",
                f"{radius[0]:g} mm at {angle[0]:g} deg and {radius[-1]:g} mm at {angle[-1]:g} deg",
            )
        angle, radius = angle[:-1], radius[:-1]
    angle, radius = np.append(angle, angle[0] + 360.0), np.append(radius, radius[0])
    k = int(np.argmax(np.diff(angle)))
    if angle[k + 1] - angle[k] > LARGEST_STEP_DEG:
        refuse(
            f"rows at most {LARGEST_STEP_DEG:g} deg apart all around",
            f"none between {angle[k]:g} and {angle[k + 1]:g} deg",
        )
    return np.radians(angle), radius


def _closed_spline(angle: Floats, radius: Floats) -> Place:
    """Points by polar angle on the periodic cubic spline of the radius."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(angle, radius, bc_type="periodic")
    first, second = spline.derivative(1), spline.derivative(2)

    def place(u: Floats) -> tuple[Floats, Floats, Floats]:
        out = directions(u)
        along = across(out)
        r, r_1, r_2 = (f(u)[:, None] for f in (spline, first, second))
        return r * out, r_1 * out + r * along, (r_2 - r) * out + 2 * r_1 * along

    return place


def _check_kinks(place: Place, angle: Floats, key: str) -> None:
    """Refuse a curve that turns at one row as much as a smooth curve would over several."""
    _, first, second = place(angle[:-1])
    speed = np.hypot(*first.T)
    bend = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
    step = np.diff(angle)
    length = 0.5 * speed * (step + np.roll(step, 1))
    excess = np.abs(bend - 0.5 * (np.roll(bend, 1) + np.roll(bend, -1))) * length
    k = int(np.argmax(excess))
    if excess[k] > LARGEST_KINK:
        raise SceneError(
            key=key,
            expected="a smooth profile, without kinks or cusps, whose rows follow its curvature",
            found=f"a turn of {np.degrees(excess[k]):.1f} deg at the row of "
            f"{np.degrees(angle[k]):g} deg",
        )
