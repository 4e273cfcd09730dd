"""Plots over the flanks of involutes: pressure with points A to E, deviation from the involute."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, tan
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from flankload.plot.curves import draw_off_corners, explain_dashes
from flankload.plot.figures import BOX, label_torques, note, set_title
from flankload.plot.load_maps import contact_pattern
from flankload.plot.picture import all_torques, panels, picture
from flankload.plot.positions import way_curve
from flankload.plot.style import BODIES, GREY, SIZE, short, torque_colours

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from flankload.base.arrays import Floats
    from flankload.bodies.profile_deviation import ProfileDeviation
    from flankload.plot.picture import Results
    from flankload.result import Result


#: Least distance of two ticks of the roll angle, as part of the width.
CLOSEST = 0.05
#: Least range of the plotted deviations, um: smaller values are roundoff.
LEAST_SPAN_UM = 5.0
#: Height of the title of a panel: that of the label of the upper axis, beside it; points.
BESIDE = 21.0
#: Height of a row of names, as part of the plot.
ROW = 0.085


@dataclass(frozen=True)
class PathOnFlank:
    """The path of contact of two involutes on the flank of one of them.

    Attributes
    ----------
    base_radius_mm : float
    pitch_roll_mm : float
        Roll length of the pitch point.
    pitch_mm : float
        Roll length of a base pitch in the sense of motion; negative if the contact moves to the
        base circle.
    ends : (float, float)
        Ends of the path in base pitches from the pitch point, in the sense of motion.
    """

    base_radius_mm: float
    pitch_roll_mm: float
    pitch_mm: float
    ends: tuple[float, float]

    def diameter_mm(self, place: Any) -> Any:
        """Diameter of places in base pitches from the pitch point."""
        roll = np.maximum(self.pitch_roll_mm + self.pitch_mm * place, 0.0)
        return 2.0 * np.hypot(self.base_radius_mm, roll)

    def roll_angle_deg(self, diameter_mm: Any) -> Any:
        """Roll angle: the tangent of the pressure angle at a diameter."""
        ratio = 0.5 * np.asarray(diameter_mm) / self.base_radius_mm
        return np.degrees(np.sqrt(np.maximum(ratio**2 - 1.0, 0.0)))

    def diameter_of_roll_mm(self, roll_angle_deg: Any) -> Any:
        """Inverse of `roll_angle_deg`."""
        roll = np.radians(np.maximum(roll_angle_deg, 0.0))
        return 2.0 * self.base_radius_mm * np.hypot(1.0, roll)

    def points(self) -> dict[str, float]:
        """Characteristic points in base pitches from the pitch point (ISO 21771).

        A and E are the ends of the path, C is the pitch point; between B and D one pair carries.
        B and D are defined for a contact ratio from 1 to 2.
        """
        start, end = self.ends
        points = {"A": start, "C": 0.0, "E": end}
        if 1.0 <= end - start < 2.0:
            points |= {"B": end - 1.0, "D": start + 1.0}
        return dict(sorted(points.items()))


def path_on_flank(result: Result, body: int) -> PathOnFlank | None:
    """The path of contact on body 1 or 2; None unless both have involutes and a known path."""
    drawing, geometry = result.drawing, result.geometry
    one, two = drawing.profiles
    if one is None or two is None or geometry is None or geometry.path_pitches is None:
        return None
    sense = -1.0 if drawing.is_around else 1.0
    bases = one.base_radius_mm, two.base_radius_mm
    angle = acos(abs(bases[1] + sense * bases[0]) / geometry.center_distance_mm)
    pitch = 2.0 * np.pi * bases[0] / drawing.teeth_1
    if body == 2:
        # in an external pair the contact moves to the base circle of body 2
        pitch *= -sense
    base = bases[body - 1]
    return PathOnFlank(base, base * tan(angle), pitch, geometry.path_pitches)


@picture(all_torques)
def plot_pressure_over_diameter(results: Results, body: int | None = None) -> Figure:
    """Figure of the peak pressure over the diameter of each body, with points A to E."""
    results = all_torques(results)
    with panels(results, "Peak pressure over the flanks") as figure:
        bodies = (1, 2) if body is None else (body,)
        figure.set_size_inches(SIZE[0], (0.5 + 0.5 * len(bodies)) * SIZE[1])
        for each, axes in zip(
            bodies, figure.subplots(len(bodies), squeeze=False).flat, strict=True
        ):
            draw_pressure_over_diameter(axes, results, body=each, key=each == bodies[-1])
    return figure


@picture(all_torques)
def draw_pressure_over_diameter(
    axes: Axes, results: Results, *, body: int = 1, key: bool = True
) -> None:
    """Draw the peak pressure over the diameter of a body, with roll angles on a second axis.

    Plane contacts are placed at their nominal diameter, that of the undeformed involutes.

    Raises
    ------
    ValueError
        If the path of contact of two involutes is unknown.
    """
    results = all_torques(results)
    path = path_on_flank(results[0], body)
    if path is None:
        raise ValueError("result: expected two involutes with a path of contact, found none")
    tops, colours = [], torque_colours(len(results))
    for result, colour in zip(results, colours, strict=True):
        diameter, pressure, corner = _along_flank(result, path, body)
        label = f"{result.torque_Nm:g} N m"
        draw_off_corners(axes, diameter, pressure, corner, color=colour, label=label)
        tops.append(float(np.nanmax(np.where(corner, np.nan, pressure), initial=0.0)))
    ends = path.diameter_mm(np.array(path.ends))
    margin = 0.06 * float(np.ptp(ends))
    axes.set_xlim(ends.min() - margin, ends.max() + margin)
    axes.set_ylim(0, 1.15 * max(tops) or None)
    axes.set_xlabel(f"diameter on body {body} in mm", color=BODIES[body - 1])
    axes.set_ylabel("peak pressure in MPa")
    _add_roll_axis(axes, path, body)
    _mark_points(axes, path)
    if len(results) > 1:
        label_torques(axes, results, tops, [f"{top:.0f} MPa" for top in tops])
    if key:
        explain_dashes(axes, results)


def _add_roll_axis(axes: Axes, path: PathOnFlank, body: int) -> None:
    """A second axis of roll angles, whose ticks come closer towards the base circle."""
    turns = (path.roll_angle_deg, path.diameter_of_roll_mm)
    second = axes.secondary_xaxis("top", functions=turns)
    second.set_xlabel(f"roll angle of body {body} in degrees")
    low, high = axes.get_xlim()
    shown: list[float] = []
    for angle in MaxNLocator(nbins=9).tick_values(*path.roll_angle_deg(np.array([low, high]))):
        place = float(path.diameter_of_roll_mm(angle))
        before = float(path.diameter_of_roll_mm(shown[-1])) if shown else -np.inf
        if angle > 0 and low <= place <= high and place - before > CLOSEST * (high - low):
            shown.append(float(angle))
    second.set_xticks(shown, [f"{angle:g}" for angle in shown])


def _along_flank(
    result: Result, path: PathOnFlank, body: int
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Diameters, peak pressures, and whether these are on a sharp corner."""
    if result.slices is not None:
        diameter, pressure = contact_pattern(result, body)
        return diameter, pressure.max(axis=1), np.zeros(diameter.size, dtype=bool)
    place, pressure = way_curve(result, result.peak_pressure_MPa)
    _, corner = way_curve(result, result.corner_contact.astype(float))
    return path.diameter_mm(place), pressure, corner > 0


def _mark_points(axes: Axes, path: PathOnFlank) -> None:
    """A line with a letter for each characteristic point."""
    low, high = axes.get_xlim()
    before, row = -np.inf, 0
    for diameter, name in sorted((float(path.diameter_mm(p)), n) for n, p in path.points().items()):
        row = 1 - row if diameter - before < CLOSEST * (high - low) else 0
        before = diameter
        axes.axvline(diameter, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
        coords, box = ("data", "axes fraction"), {**BOX, "pad": 1.0}
        offset = (0.0, 13.0 * row)
        note(axes, name, (diameter, 0.03), coords, offset, ha="center", weight="bold", bbox=box)


@picture(all_torques)
def plot_profile_deviation(results: Results, body: int | None = None) -> Figure:
    """Figure of the deviation from the involute along its normal, per body that has one."""
    results = all_torques(results)
    with panels(results) as figure:
        known = [z for z in (1, 2) if results[0].drawing.profiles[z - 1] is not None]
        bodies = known if body is None else [body]
        figure.set_size_inches(SIZE[0], 1.0 + 2.9 * len(bodies))
        set_title(figure, short(results[0].name), "Profile deviation")
        for each, axes in zip(
            bodies, figure.subplots(len(bodies), squeeze=False).flat, strict=True
        ):
            draw_profile_deviation(axes, results, body=each)
            axes.set_title(f"body {each}", color=BODIES[each - 1], fontsize=10, pad=BESIDE)
    return figure


@picture(all_torques)
def draw_profile_deviation(axes: Axes, results: Results, *, body: int = 1) -> None:
    """Draw the deviation of a body from its involute along its normal, over roll length.

    All torques have the same profiles; the scale is that of both bodies.

    Raises
    ------
    ValueError
        If the involute of the body is unknown.
    """
    results = all_torques(results)
    drawing = results[0].drawing
    profile = drawing.profiles[body - 1]
    if profile is None:
        raise ValueError(f"body: expected one with an involute, found {body}")
    axes.set_ylim(*_span([each for each in drawing.profiles if each is not None]))
    _draw_profile(axes, profile, drawing.active_roll_mm[body - 1], body - 1)


def _span(profiles: list[ProfileDeviation]) -> tuple[float, float]:
    """One scale for both bodies, with space above for the labels of the marks."""
    every = np.concatenate([profile.deviation_um for profile in profiles])
    low, high = min(0.0, float(every.min())), max(0.0, float(every.max()))
    if high - low < LEAST_SPAN_UM:
        low -= LEAST_SPAN_UM - (high - low)
    foot = 0.14 * (high - low)
    head = 0.05 + ROW * max(len(profile.marks) for profile in profiles)  # part of the height
    return low - foot, high + (high - low + foot) * head / (1.0 - head)


def _draw_profile(
    axes: Axes, profile: ProfileDeviation, active: tuple[float, float] | None, z: int
) -> None:
    colour = BODIES[z]
    ends = [*profile.roll_length_mm[[0, -1]], *(place for _, place in profile.marks)]
    margin = 0.03 * (max(ends) - min(ends))
    axes.set_xlim(min(ends) - margin, max(ends) + margin)
    if active is not None:
        axes.axvspan(*active, color="#f0f0f0", zorder=0)
        place, coords = (0.5 * sum(active), 0.03), ("data", "axes fraction")
        note(axes, "active profile", place, coords, ha="center", fontsize=8)
    axes.axhline(0.0, color=GREY, linewidth=1)
    _draw_marks(axes, profile)
    axes.plot(profile.roll_length_mm, profile.deviation_um, color=colour)
    axes.set_ylabel("deviation in µm")
    axes.set_xlabel("roll length in mm")
    base = profile.base_radius_mm

    def diameter(roll_length: Any) -> Any:
        return 2 * np.hypot(base, np.maximum(roll_length, 0.0))

    def roll_length(diameter: Any) -> Any:
        return np.sqrt(np.maximum((0.5 * np.asarray(diameter)) ** 2 - base**2, 0.0))

    axes.secondary_xaxis("top", functions=(diameter, roll_length)).set_xlabel("diameter in mm")


def _draw_marks(axes: Axes, profile: ProfileDeviation) -> None:
    """A line for each mark, with its label beside it in a row of its own."""
    marks = sorted(profile.marks, key=lambda mark: mark[1])
    low, high = axes.get_xlim()
    for row, (name, place) in enumerate(marks):
        axes.axvline(place, color=GREY, linewidth=0.9, linestyle=(0, (4, 3)))
        side, ha = (4, "left") if place < 0.5 * (low + high) else (-4, "right")
        text = f"{name} ⌀ {2 * np.hypot(profile.base_radius_mm, place):.2f}"
        look = {"va": "top", "fontsize": 8, "bbox": {**BOX, "alpha": 0.85, "pad": 0.6}}
        at, coords = (place, 0.97 - ROW * row), ("data", "axes fraction")
        note(axes, text, at, coords, (side, 0), ha=ha, **look)
