"""The loaded pair to be turned in a page: outlines of both bodies, loads of each position."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.plot.style import all_around, turned
from flankload.report.loads import LETTER, REACH, path_text, scales_of, short, state_at

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from flankload.result import Result

    Floats = NDArray[np.float64]

#: Most positions in a page; more are thinned evenly.
MOST_POSITIONS = 128
#: Points of an outline may lie off by this part of the picture's width.
OFF = 5e-4


@dataclass(frozen=True)
class Turning:
    """Picture of both bodies that a page turns.

    Attributes
    ----------
    view_box : str
        Left, top, width and height, mm; y points down, as in SVG.
    outlines : tuple of str
        SVG path of each body in its own frame, y upwards.
    center_mm : float
        Place of the axis of body 2 on the x axis.
    letter_mm : float
        Height of the numbers of the pairs.
    start : int
        Position that is shown at first.
    data : dict
        For the script: `deg` (P,) angles of the positions; `turn` of both bodies (2, P), deg;
        `torques` (T,); `states` (T, P) of transmission error in um, rows of pairs (number, force in
        kN, share in %, pressure in MPa if there is one, or "corner") and loads of the pairs (path,
        x and y of the pair's number).
    """

    view_box: str
    outlines: tuple[str, ...]
    center_mm: float
    letter_mm: float
    start: int
    data: dict[str, Any]


def turning(results: Sequence[Result]) -> Turning:
    """Picture of the loaded bodies at every position.

    Parameters
    ----------
    results : sequence of Result
        One per torque, at the same positions.

    Returns
    -------
    Turning
    """
    result = results[-1]
    drawing = result.drawing
    shown = _positions(result)
    low, high = _window(results, shown)
    size = float((high - low).max())
    outlines = [_outline(drawing.outline_1, drawing.teeth_1, OFF * size)]
    turns = [drawing.angle_1]
    if result.drive is None:
        outlines.append(_outline(drawing.outline_2, drawing.teeth_2, OFF * size))
        turns.append(drawing.angle_2)
    outlines = [
        outline + _hole(radius, _largest(shape))
        for outline, radius, shape in zip(
            outlines,
            (drawing.bore_radius_1_mm, drawing.bore_radius_2_mm),
            (drawing.outline_1, drawing.outline_2),
            strict=False,
        )
    ]
    states = [[state_at(one, p, scales_of(results), size) for p in shown] for one in results]
    return Turning(
        f"{low[0]:.3f} {-high[1]:.3f} {high[0] - low[0]:.3f} {high[1] - low[1]:.3f}",
        tuple(outlines),
        drawing.center_distance_mm,
        round(LETTER * size, 3),
        int(np.argmin(np.abs(np.array(shown) - _start(result)))),
        {
            "deg": [short(degrees(result.position_rad[p])) for p in shown],
            "turn": [[round(degrees(angle[p]), 4) for p in shown] for angle in turns],
            "torques": [one.torque_Nm for one in results],
            "states": states,
        },
    )


def _positions(result: Result) -> list[int]:
    """Positions in the order of their angles, thinned evenly if there are many."""
    order = np.argsort(result.position_rad, kind="stable")
    return [int(p) for p in order[:: ceil(order.size / MOST_POSITIONS)]]


def _start(result: Result) -> int:
    """Position of the largest meaningful pressure, or of the largest force."""
    smooth = np.where(result.corner_contact, 0.0, result.peak_pressure_MPa).max(axis=1)
    value = smooth if smooth.max() > 0 else result.site_force_N.max(axis=1)
    order = np.argsort(result.position_rad, kind="stable")
    return int(np.argmax(value[order]))


def _largest(outline: Floats) -> float:
    return float(np.hypot(*outline.T).max())


def _window(results: Sequence[Result], shown: list[int]) -> tuple[Floats, Floats]:
    """Corners of the picture: the contacts of all positions, or whole bodies."""
    result = results[-1]
    drawing = result.drawing
    apart = np.array([drawing.center_distance_mm, 0.0])
    if result.drive is not None or result.whole_circle:
        rims = (drawing.bore_radius_2_mm or 0.0, *map(_largest, _outlines(result)))
        half = 1.05 * max(rims) * np.ones(2)
        if result.drive is not None:
            half *= 1.0 + 2 * REACH
        return apart - half, apart + half
    if result.has_cam:
        swept = [
            turned(outline, angle) + center
            for outline, angles, center in (
                (drawing.outline_1, drawing.angle_1, 0.0 * apart),
                (drawing.outline_2, drawing.angle_2, apart),
            )
            for angle in angles[shown]
        ]
        whole = np.concatenate(swept)
        room = 0.03 * float(np.ptp(whole, axis=0).max())
        return whole.min(axis=0) - room, whole.max(axis=0) + room
    places = np.concatenate(
        [
            np.column_stack([table.x_mm, table.y_mm])[table.force_N > 0]
            for one in results
            for table in (one.pairs(p) for p in shown)
        ]
    )
    pitch = 2 * np.pi * _largest(drawing.outline_1) / drawing.teeth_1
    if not len(places):
        places = np.array([[_largest(drawing.outline_1), 0.0]])
    return places.min(axis=0) - 0.9 * pitch, places.max(axis=0) + 0.9 * pitch


def _outlines(result: Result) -> tuple[Floats, ...]:
    drawing = result.drawing
    return (drawing.outline_1,) if result.drive else (drawing.outline_1, drawing.outline_2)


def _outline(sector: Floats, teeth: int, off_mm: float) -> str:
    """SVG path of all teeth of a body."""
    return f"M{path_text(all_around(thinned(sector, off_mm), teeth))}Z"


def thinned(points: Floats, off_mm: float) -> Floats:
    """Leave out points that lie nearer than a distance to the line through those kept.

    Parameters
    ----------
    points : (n, 2) array
    off_mm : float

    Returns
    -------
    (k, 2) array
        With both ends (Douglas and Peucker, 1973).
    """
    keep = np.zeros(len(points), dtype=bool)
    keep[[0, -1]] = True
    parts = [(0, len(points) - 1)]
    while parts:
        one, two = parts.pop()
        chord, inner = points[two] - points[one], points[one + 1 : two] - points[one]
        if not len(inner):
            continue
        length = float(np.hypot(*chord))
        off = np.abs(inner @ [-chord[1], chord[0]]) / length if length else np.hypot(*inner.T)
        k = int(np.argmax(off))
        if off[k] > off_mm:
            keep[one + 1 + k] = True
            parts += [(one, one + 1 + k), (one + 1 + k, two)]
    return points[keep]


def _hole(radius: float | None, largest: float) -> str:
    """Bore, or the rim around internal teeth: the even-odd rule makes a hole of the smaller."""
    if not radius or abs(radius - largest) < 1e-9:
        return ""
    arc = f"a{radius:.3f} {radius:.3f} 0 1 0"
    return f"M{-radius:.3f} 0{arc} {2 * radius:.3f} 0{arc} {-2 * radius:.3f} 0Z"
