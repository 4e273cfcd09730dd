"""Bodies of kind "cam": a disc fixed at its bore, with a smooth closed profile from a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.files import path_of
from flankload.base.rotation import directions
from flankload.base.rounding import round_up
from flankload.bodies.body import Body, Material, WholeMesh
from flankload.bodies.plane import across
from flankload.errors import SceneError
from flankload.flank import CurvePiece, FlankCurve, fit_flank_curve, interpolating_spline
from flankload.flank.fit import FIT_TOLERANCE
from flankload.meshes.blocks import (
    MOST_NODES,
    MOST_PARTS,
    BlockMesh,
    check_count,
    growing_breaks,
    with_middles,
)
from flankload.meshes.io.named_arrays import MOST_LINES, read_columns
from flankload.scene.refusal import refuse

if TYPE_CHECKING:
    from pathlib import Path

    from flankload.base.arrays import Floats, Numbers
    from flankload.flank import Place
    from flankload.scene import Cam

LEAST_ROWS = 8
#: Rows of further turns at each end of a table, for a spline that is periodic up to rounding.
MORE_ROWS = 64
#: Largest angle between rows, deg; beyond it, the curve between rows is arbitrary.
LARGEST_STEP_DEG = 30.0
#: Largest differences of a last row that repeats the first one, after a full turn.
ANGLE_TOLERANCE_DEG = 1e-9
RADIUS_TOLERANCE_MM = 1e-6
#: Largest excess of the curve's turn at a row over that at its neighbours, rad; more is a kink.
LARGEST_KINK = 0.2
#: Least wall thickness between bore and profile, over the least radius.
LEAST_WALL = 0.02
#: Default number of elements around the profile: minimum; per length of one wall thickness; per
#: radian at the sharpest nose; maximum.
LEAST_ELEMENTS, ELEMENTS_PER_WALL, ELEMENTS_PER_RADIAN, MOST_ELEMENTS = 96.0, 4.0, 1.2, 400.0
#: Pressure modes per element, over those of a gear flank: five elements per harmonic.
MODES_PER_ELEMENT = 8.2 / 96
#: Thickness of the first layer over the length of the elements, and growth of the layers towards
#: the bore; a first layer of 1 leaves an error of 0.5 % in the wind-up of a thin cam.
FIRST_LAYER, GROWTH = 0.3, 1.4
LEAST_LAYERS = 3


@dataclass(frozen=True)
class CamProfile:
    """Profile of a cam.

    Attributes
    ----------
    curve : FlankCurve
        Closed and clockwise, so that the material is on its right.
    least_radius_mm : float
        Least radius of the curve about the axis.
    """

    curve: FlankCurve
    least_radius_mm: float


def build_cam(
    spec: Cam, key: str, *, folder: Path, flank_element_mm: float | None, fineness: float
) -> Body:
    """Build a cam, checked; parameters as for `build_body`.

    `fineness`: number of elements along the profile over the default, without `flank_element_mm`.
    """
    profile = cam_profile(spec, key, folder=folder)
    bore_radius = 0.5 * spec.bore_diameter_mm
    length = profile.curve.length_mm
    elements = _elements(profile, bore_radius)
    mesh = None
    if not spec.rigid:
        element_mm = flank_element_mm or length / (elements * fineness)
        mesh = cam_mesh(profile, bore_radius_mm=bore_radius, flank_element_mm=element_mm)
    turn = np.linspace(0.0, length, 721)
    return Body(
        kind=spec.kind,
        curve=profile.curve,
        teeth=1,
        material=Material(spec.young_modulus_MPa, spec.poisson_ratio),
        rigid=spec.rigid,
        mesh=mesh,
        mode_range_mm=(0.0, length),
        reference_radius_mm=profile.least_radius_mm,
        outline=profile.curve.point(turn)[::-1],
        bore_radius_mm=bore_radius,
        modes_factor=MODES_PER_ELEMENT * elements,
        turns_clockwise=spec.sense == "clockwise",
    )


def _elements(profile: CamProfile, bore_radius: float) -> float:
    """Number of elements around the profile in the default discretization."""
    curve, wall = profile.curve, profile.least_radius_mm - bore_radius
    sharpest = float(curve.curvature(curve.breaks).max())
    wanted = curve.length_mm * max(ELEMENTS_PER_WALL / wall, ELEMENTS_PER_RADIAN * sharpest)
    return min(max(wanted, LEAST_ELEMENTS), MOST_ELEMENTS)


def cam_mesh(profile: CamProfile, *, bore_radius_mm: float, flank_element_mm: float) -> WholeMesh:
    """Mesh a cam by rays from the bore to the profile and layers that grow inwards.

    The mesh has one closed flank, with elements no longer than `flank_element_mm`.
    """
    length = profile.curve.length_mm
    parts = 0.5 * length / flank_element_mm
    check_count(parts, MOST_PARTS, "elements along a line")
    half = max(8, round_up(parts))
    wall = profile.least_radius_mm - bore_radius_mm
    first = min(FIRST_LAYER * length / (2 * half), wall / LEAST_LAYERS)
    depth = growing_breaks(wall, first, GROWTH, None)
    up = 1.0 - with_middles(depth)[::-1]
    check_count(2.0 * half * up.size, MOST_NODES, "nodes")
    blocks = BlockMesh()
    ends: dict[str, Numbers] = {}
    halves = [with_middles(np.linspace(k, k + 1, half + 1)) * 0.5 * length for k in (0, 1)]
    rows, fixed = [], []
    for s in halves:
        top = profile.curve.point(s)
        bottom = bore_radius_mm * top / np.hypot(*top.T)[:, None]
        numbers = blocks.add(bottom + up[:, None, None] * (top - bottom), ends)
        ends = {"left": numbers[:, -1], "right": numbers[:, 0]}
        rows.append(numbers[-1])
        fixed.append(numbers[0])
    flank = np.append(rows[0], rows[1][1:])
    s = np.append(halves[0], halves[1][1:])
    return WholeMesh.of_blocks(blocks, np.concatenate(fixed), flank, s)


def cam_profile(spec: Cam, key: str, *, folder: Path) -> CamProfile:
    """Profile of a cam from its table, in the scene or in a file.

    Raises
    ------
    SceneError
        If the table does not give a closed smooth curve around the bore; names the row.
    """
    if spec.profile_file is not None:
        name = f"{key}.profile_file"
        path = folder / path_of(spec.profile_file)
        rows = read_columns(path, name, ("angle_deg", "radius_mm"))
    else:
        name = f"{key}.profile"
        rows = np.array(spec.profile, dtype=float).reshape(-1, 2)
    angle, radius = _one_turn(rows, name)
    place = _closed_spline(angle, radius)
    # clockwise: from the angle of the first row plus one turn to that angle
    pieces = [CurvePiece("flank", place, angle[-1], angle[0], knots=angle[-2:0:-1])]
    _check_kinks(place, angle, name)
    # the radius, unlike the length of a full turn, is of the size of a flank
    curve = fit_flank_curve(pieces, tolerance_mm=FIT_TOLERANCE * float(radius.max()))
    radii = np.hypot(*curve.point(np.linspace(0.0, curve.length_mm, 8 * len(curve.labels) + 1)).T)
    least = float(radii.min())
    if 0.5 * spec.bore_diameter_mm > (1 - LEAST_WALL) * least:
        expected = f"at most {1 - LEAST_WALL:g} of twice the least radius of the profile: "
        expected += f"{2 * (1 - LEAST_WALL) * least:.4f}"
        refuse(f"{key}.bore_diameter_mm", expected, f"{spec.bore_diameter_mm:g}")
    return CamProfile(curve, least)


def _one_turn(rows: Floats, key: str) -> tuple[Floats, Floats]:
    """Angles in rad (n + 1,), ascending over exactly one turn, and radii with equal ends."""

    def refuse(expected: str, found: str) -> None:
        raise SceneError(key=key, expected=expected, found=found)

    if not LEAST_ROWS <= len(rows) <= MOST_LINES:
        refuse(f"{LEAST_ROWS} to {MOST_LINES} rows of angle and radius", f"{len(rows)}")
    angle, radius = rows.T
    steps = np.diff(angle)
    if (steps <= 0).any():
        k = int(np.flatnonzero(steps <= 0)[0])
        refuse("ascending angles", f"{angle[k + 1]:g} deg behind {angle[k]:g} deg in row {k + 2}")
    span = angle[-1] - angle[0]
    if span > 360.0 + ANGLE_TOLERANCE_DEG:
        refuse("angles within one turn", f"{angle[0]:g} to {angle[-1]:g} deg")
    if span > 360.0 - ANGLE_TOLERANCE_DEG:
        if abs(radius[-1] - radius[0]) > RADIUS_TOLERANCE_MM:
            refuse(
                "a periodic table, whose last row repeats the radius of the first, one turn later",
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
    """Points of the periodic cubic spline of the radius, by polar angle."""
    # the rows of further turns: an end condition loses half of its effect from row to row
    turn, row = np.divmod(np.arange(-MORE_ROWS, radius.size + MORE_ROWS), radius.size - 1)
    spline = interpolating_spline(angle[row] + 2 * np.pi * turn, radius[row, None])

    def place(u: Floats) -> tuple[Floats, Floats, Floats]:
        out = directions(u)
        along = across(out)
        r, r_1, r_2 = spline.derivatives(u)
        return r * out, r_1 * out + r * along, (r_2 - r) * out + 2 * r_1 * along

    return place


def _check_kinks(place: Place, angle: Floats, key: str) -> None:
    """Refuse a curve with a kink at a row."""
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
