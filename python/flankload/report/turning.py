"""The loaded pair to be turned in a page: outlines of both bodies, loads of each position."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.rotation import all_around, directions
from flankload.result.corners import off_corners

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flankload.base.arrays import Floats
    from flankload.result import PairTable, Result
    from flankload.result.pairs import DrawnBody


#: Most positions in a page; more are thinned evenly.
MOST_POSITIONS = 128
#: Points of an outline may lie off by this part of the picture's width.
OFF = 5e-4
#: Space around whole bodies, as part of their size.
MARGIN = 0.03
#: Length of the largest force or pressure, as part of the size of the picture; of teeth all around.
ARROW, ARROW_AROUND = 0.2, 0.1
#: Height of letters, as part of the width of the picture.
LETTER = 0.03
#: Decimals of a transmission error in um: the rest is roundoff.
DECIMALS = 6
#: Least and most points of the pressure on a flank.
LEAST_POINTS, MOST_POINTS = 3, 24


@dataclass(frozen=True)
class Turning:
    """Picture of both bodies that a page turns.

    `view_box` is left, top, width and height in mm, y down as in SVG; `outlines` are the SVG paths
    of the bodies in their own frames, y upwards; `centers_mm` are the places of their axes, and
    `numbers` those of body 1 or 2, whose look they have; `letter_mm` is the height of the numbers
    of the pairs; `start` the position that is shown at first; `heads` are those of the columns of
    the pairs; `legend` is the meaning of the red areas.

    `data` is for the script: `deg` (P,) angles of the positions; `turn` of the bodies (n, P), deg;
    `torques` (T,); `states` (T, P) of transmission error in um, rows of pairs (number, force in kN,
    share in %, pressure in MPa if there is one, or "corner") and loads of the pairs (path, x and y
    of the pair's number).
    """

    view_box: str
    outlines: tuple[str, ...]
    centers_mm: tuple[tuple[float, float], ...]
    numbers: tuple[int, ...]
    letter_mm: float
    start: int
    heads: tuple[str, ...]
    legend: str
    data: dict[str, Any]


def turning(results: Sequence[Result]) -> Turning:
    """Picture of the loaded bodies at every position; results of all torques have the same ones."""
    result = results[-1]
    shown = positions_of(result)
    low, high = window(results, shown)
    size = float((high - low).max())
    bodies = drawn_bodies(result)
    pressure = ("pressure, MPa",) * result.engagement.has_pressures
    heads = (result.words_for_sites[0], "force, kN", "share, %", *pressure)
    states = [[_state_at(one, p, scales_of(results), size) for p in shown] for one in results]
    return Turning(
        f"{low[0]:.3f} {-high[1]:.3f} {high[0] - low[0]:.3f} {high[1] - low[1]:.3f}",
        tuple(body_path(body, size) for body in bodies),
        tuple((float(body.center_mm[0]), float(body.center_mm[1])) for body in bodies),
        tuple(body.number for body in bodies),
        round(LETTER * size, 3),
        int(np.argmin(np.abs(np.array(shown) - _start(result)))),
        heads,
        _legend(result),
        {
            "deg": [_short(degrees(result.position_rad[p])) for p in shown],
            "turn": [[round(degrees(body.angle[p]), 4) for p in shown] for body in bodies],
            "torques": [one.torque_Nm for one in results],
            "states": states,
        },
    )


def drawn_bodies(result: Result) -> tuple[DrawnBody, ...]:
    """The bodies of the picture: a belt or a chain has no outline."""
    return result.drawing.bodies[: result.engagement.drawn_bodies]


def positions_of(result: Result) -> list[int]:
    """Positions in the order of their angles, thinned evenly if there are many."""
    order = np.argsort(result.position_rad, kind="stable")
    return [int(p) for p in order[:: ceil(order.size / MOST_POSITIONS)]]


def _start(result: Result) -> int:
    """Position of the largest meaningful pressure, or of the largest force."""
    smooth = off_corners(result).max(axis=1)
    value = smooth if smooth.max() > 0 else result.site_force_N.max(axis=1)
    order = np.argsort(result.position_rad, kind="stable")
    return int(np.argmax(value[order]))


def _largest(outline: Floats) -> float:
    return float(np.hypot(*outline.T).max())


def _largest_arrow(result: Result) -> float:
    """Length of the largest force or pressure, as part of the size of the picture."""
    return ARROW_AROUND if result.whole_circle else ARROW


def window(results: Sequence[Result], shown: list[int]) -> tuple[Floats, Floats]:
    """Corners of the picture: the contacts of all positions, or whole bodies with all arrows."""
    result = results[-1]
    drawing, engagement = result.drawing, result.engagement
    places, forces = (
        np.concatenate(parts) for parts in zip(*_contacts(results, shown), strict=True)
    )
    if engagement.draws_whole_bodies:
        low, high = drawing.extent_mm(shown)
        size = float((high - low).max())
        # arrows and letters are parts of the final size, which is larger
        arrow = _largest_arrow(result)
        larger = 1.0 + 2.0 * (arrow + LETTER)
        length = np.hypot(*forces.T)[:, np.newaxis]
        beyond = arrow * forces + 2.0 * LETTER * forces / length
        ends = np.vstack([low, high, places + larger * size * beyond])
        return ends.min(axis=0) - MARGIN * size, ends.max(axis=0) + MARGIN * size
    pitch = 2 * np.pi * _largest(drawing.outline_1) / drawing.teeth_1
    if not len(places):
        places = np.array([[_largest(drawing.outline_1), 0.0]])
    return places.min(axis=0) - 0.9 * pitch, places.max(axis=0) + 0.9 * pitch


def _contacts(results: Sequence[Result], shown: list[int]) -> Iterator[tuple[Floats, Floats]]:
    """Places (n, 2) of loaded pairs, and the forces of their sites relative to the largest."""
    largest = scales_of(results)[0]
    for one in results:
        for p in shown:
            table = one.pairs(p)
            loaded = table.force_N > 0
            site_force = one.site_force_N[p, np.searchsorted(one.sites, table.site[loaded])]
            yield table.point_mm[loaded], table.normal[loaded] * site_force[:, None] / largest


def body_path(body: DrawnBody, size_mm: float) -> str:
    """SVG path of all teeth of a body and of its hole, in its own frame, for a size of picture."""
    sector = thinned(body.outline, OFF * size_mm)
    hole = _hole(body.hole_mm, _largest(body.outline))
    return f"M{path_text(all_around(sector, body.teeth))}Z{hole}"


def thinned(points: Floats, off_mm: float) -> Floats:
    """Leave out points (n, 2) that lie nearer than a distance to the line through those kept.

    Both ends are kept (Douglas and Peucker, 1973).
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


def scales_of(results: Sequence[Result]) -> tuple[float, float]:
    """Largest force, N, and largest pressure off corners, MPa, of all torques."""
    force = max(float(one.site_force_N.max()) for one in results)
    pressure = max(one.summary["peak_pressure_MPa"] or 0.0 for one in results)
    return force or 1.0, pressure or 1.0


def _state_at(
    result: Result, p: int, scales: tuple[float, float], size_mm: float
) -> dict[str, Any]:
    """Numbers and paths of a position."""
    table = result.pairs(p)
    rows, paths = [], []
    for s, site in enumerate(result.sites):
        force = float(result.site_force_N[p, s])
        if force <= 0:
            continue
        row: list[float | str] = [int(site), _short(force / 1e3)]
        row.append(_short(100 * result.load_share[p, s]))
        if result.engagement.has_pressures:
            corner = bool(result.corner_contact[p, s])
            row.append("corner" if corner else _short(result.peak_pressure_MPa[p, s]))
        rows.append(row)
        shape, tip, out = load_shape(result, table, p, s, scales, size_mm)
        name = tip + LETTER * size_mm * (out - [0.0, 0.4])
        paths.append([f"M{path_text(shape)}Z", *(round(float(value), 2) for value in name)])
    return {
        "te": _short(round(float(result.transmission_error_um[p]), DECIMALS)),
        "pairs": rows,
        "paths": paths,
    }


def load_shape(
    result: Result, table: PairTable, p: int, s: int, scales: tuple[float, float], size_mm: float
) -> tuple[Floats, Floats, Floats]:
    """Outline (n, 2) of the load of a pair, its tip and direction: pressure on the flank, or arrow.

    Parameters
    ----------
    table : PairTable
        Contact pairs of position p.
    s : int
        Index of the site, which carries load.
    scales : (float, float)
        As for `scales_of`.
    size_mm : float
        Size of the picture.
    """
    reach_mm = _largest_arrow(result) * size_mm
    rows = np.flatnonzero((table.site == result.sites[s]) & (table.force_N > 0))
    lumped = table.half_width_mm is not None or table.z_mm is not None
    plain = not result.engagement.draws_pressures or result.corner_contact[p, s]
    if plain or lumped or len(rows) < LEAST_POINTS:
        angle, radius, direction = result.engagement.drawn_force(result, p, s)
        start, along = directions(np.array([angle, direction]))
        force = float(result.site_force_N[p, s]) / scales[0]
        return _arrow(radius * start, along, force * reach_mm)
    place = table.point_mm[rows]
    normal = table.normal[rows]
    order = np.argsort(table.arc_length_1_mm[rows], kind="stable")
    order = order[:: max(1, len(order) // MOST_POINTS)]
    height = reach_mm * table.pressure_MPa[rows][order] / scales[1]
    tips = place[order] + normal[order] * height[:, None]
    most = int(np.argmax(height))
    return np.vstack([place[order], tips[::-1]]), tips[most], normal[order][most]


def _arrow(start: Floats, direction: Floats, length: float) -> tuple[Floats, Floats, Floats]:
    """Outline of an arrow with a head of a third of its length, its tip and direction."""
    aside = np.array([-direction[1], direction[0]])
    tip = start + length * direction
    neck = start + 0.68 * length * direction
    half, wide = 0.045 * length, 0.13 * length
    corners = [
        start + half * aside, neck + half * aside, neck + wide * aside, tip,
        neck - wide * aside, neck - half * aside, start - half * aside,
    ]  # fmt: skip
    return np.array(corners), tip, direction


def _short(value: float) -> float | int:
    """Four significant digits; an integer where the rest is 0."""
    rounded = float(f"{float(value):.4g}")
    return int(rounded) if rounded.is_integer() else rounded


def _legend(result: Result) -> str:
    """Meaning of the red areas of the picture."""
    scale = "to scale with the largest of all positions"
    section = "" if result.slices is None else "Transverse section at z = 0. "
    if not result.engagement.draws_pressures:
        return f"{section}Arrows: force on each {result.words_for_sites[0]}, {scale}."
    if section:
        return f"{section}Arrows: force of each pair, at the centre of its load, {scale}."
    return (
        f"Red: pressure on the flanks, {scale}; an arrow where a pair carries on a sharp corner, "
        "to scale with the largest force. Numbers: pairs."
    )


def path_text(points: Floats) -> str:
    """Points (n, 2) as in an SVG path."""
    return "L".join(f"{x:.2f} {y:.2f}" for x, y in points)
