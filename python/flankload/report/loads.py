"""Loads of the pairs at a position: numbers, and paths for the picture of both bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from flankload.result import PairTable, Result

    Floats = NDArray[np.float64]

#: Length of the largest force or pressure, as part of the height of the picture.
REACH = 0.2
#: Height of letters, as part of the width of the picture.
LETTER = 0.03
#: Decimals of a transmission error in um: the rest is roundoff.
DECIMALS = 6
#: Most points of the pressure on a flank.
MOST_POINTS = 24


def scales_of(results: Sequence[Result]) -> tuple[float, float]:
    """Largest force, N, and largest pressure off corners, MPa, of all torques."""
    force = max(float(one.site_force_N.max()) for one in results)
    pressure = max(
        float(np.where(one.corner_contact, 0.0, one.peak_pressure_MPa).max()) for one in results
    )
    return force or 1.0, pressure or 1.0


def state_at(result: Result, p: int, scales: tuple[float, float], size_mm: float) -> dict[str, Any]:
    """Numbers and paths of a position."""
    table = result.pairs(p)
    rows, paths = [], []
    for s, site in enumerate(result.sites):
        force = float(result.site_force_N[p, s])
        if force <= 0:
            continue
        row: list[float | str] = [int(site), short(force / 1e3)]
        row.append(short(100 * result.load_share[p, s]))
        if result.drive is None:
            corner = bool(result.corner_contact[p, s])
            row.append("corner" if corner else short(result.peak_pressure_MPa[p, s]))
        rows.append(row)
        path, tip, out = _path_of_load(result, table, p, s, scales, REACH * size_mm)
        name = tip + LETTER * size_mm * (out - [0.0, 0.4])
        paths.append([path, *(round(float(value), 2) for value in name)])
    return {
        "te": short(round(float(result.transmission_error_um[p]), DECIMALS)),
        "pairs": rows,
        "paths": paths,
    }


def _path_of_load(
    result: Result,
    table: PairTable,
    p: int,
    s: int,
    scales: tuple[float, float],
    reach_mm: float,
) -> tuple[str, Floats, Floats]:
    """SVG path of the load of a pair, its tip and direction: pressure on the flank, or an arrow."""
    force = float(result.site_force_N[p, s]) / scales[0]
    if result.drive is not None:
        start, direction = _on_wheel(result, p, s)
        return arrow(start, direction, force * reach_mm)
    rows = np.flatnonzero((table.site == result.sites[s]) & (table.force_N > 0))
    place = np.column_stack([table.x_mm, table.y_mm])[rows]
    normal = np.column_stack([table.normal_x, table.normal_y])[rows]
    weight = table.force_N[rows]
    lumped = table.half_width_mm is not None or table.z_mm is not None
    if lumped or result.whole_circle or result.corner_contact[p, s] or len(rows) < 3:
        mean = np.average(place, axis=0, weights=weight)
        out = np.average(normal, axis=0, weights=weight)
        part = 0.5 if result.whole_circle else 1.0
        return arrow(mean, out / np.hypot(*out), part * force * reach_mm)
    order = np.argsort(table.arc_length_1_mm[rows], kind="stable")
    order = order[:: max(1, len(order) // MOST_POINTS)]
    height = reach_mm * table.pressure_MPa[rows][order] / scales[1]
    tips = place[order] + normal[order] * height[:, None]
    tip = tips[int(np.argmax(height))]
    middle = normal[order][int(np.argmax(height))]
    return f"M{path_text(place[order])}L{path_text(tips[::-1])}Z", tip, middle


def _on_wheel(result: Result, p: int, s: int) -> tuple[Floats, Floats]:
    """Place and direction of the force at a site of a chain or a belt."""
    assert result.drive is not None
    angle, radius, direction = result.drive.drawn_force(result, p, s)
    place = radius * np.array([np.cos(angle), np.sin(angle)])
    return place, np.array([np.cos(direction), np.sin(direction)])


def arrow(start: Floats, direction: Floats, length: float) -> tuple[str, Floats, Floats]:
    """SVG path of an arrow with a head of a third of its length, its tip and direction."""
    aside = np.array([-direction[1], direction[0]])
    tip = start + length * direction
    neck = start + 0.68 * length * direction
    half, wide = 0.045 * length, 0.13 * length
    corners = [
        start + half * aside, neck + half * aside, neck + wide * aside, tip,
        neck - wide * aside, neck - half * aside, start - half * aside,
    ]  # fmt: skip
    return f"M{path_text(np.array(corners))}Z", tip, direction


def short(value: float) -> float | int:
    """Four significant digits; an integer where the rest is 0."""
    rounded = float(f"{float(value):.4g}")
    return int(rounded) if rounded.is_integer() else rounded


def heads_of(result: Result) -> tuple[str, ...]:
    """Heads of the columns of `pairs`."""
    name = result.words_for_sites[0]
    if result.drive is not None:
        return name, "force, kN", "share, %"
    return name, "force, kN", "share, %", "pressure, MPa"


def legend(result: Result) -> str:
    """Meaning of the red areas of the picture."""
    scale = "to scale with the largest of all positions"
    if result.drive is not None:
        return f"Arrows: forces on the teeth of body 1, {scale}."
    if result.slices is not None:
        return (
            "Transverse section at z = 0. Arrows: force of each pair, at the centre of its load, "
            f"{scale}."
        )
    if result.whole_circle:
        return f"Arrows: force on each flank, {scale}."
    return (
        f"Red: pressure on the flanks, {scale}; an arrow where a pair carries on a sharp corner, "
        "to scale with the largest force. Numbers: pairs."
    )


def path_text(points: Floats) -> str:
    """Points (n, 2) as in an SVG path."""
    return "L".join(f"{x:.2f} {y:.2f}" for x, y in points)
