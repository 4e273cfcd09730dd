"""A result as text for the terminal."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.text_table import MARK, NONE, number, text_table
from flankload.result.accuracy_lines import accuracy_lines, outside_words
from flankload.result.coast_contact import CoastContact
from flankload.result.warning_lines import warning_lines

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flankload.result.friction import FrictionResult
    from flankload.result.result import Result

#: Columns of a position and their units.
HEAD = ("position", "transm. error", "tangent stiffness", "secant stiffness")
UNITS = ("deg", "um", "N/um", "N/um")

#: Largest number of pairs with a column each; with more pairs a row lists the loaded ones.
MOST_COLUMNS = 8
#: Parts of a quantity below this limit are roundoff, and printed as zero.
ROUNDING = 1e-9
#: Sources of the estimate with a separate line: they apply to harmonics, which others do not.
SHOWN_ALONE = {"positions": "by positions alone", "period": "by period alone"}
#: Words that such a line omits from its names.
OF_ROTATION = "transmission_error_"
#: Least part of the mean transmission error at which the state without load is reported separately.
LEAST_UNLOADED = 1e-3
#: Quantities that need several positions.
OF_SEVERAL = ("transmission_error_mean", "transmission_error_peak_to_peak")
#: Result of the contact solver's check at a position, other than "solved" (0).
STATUS_WORDS = {
    1: "solved; how neighbouring pairs share their force is uncertain, sums are right",
    2: "solved; a pair has neither force nor gap",
    3: "solved; that no other state exists is not proven",
}


def text_of(result: Result) -> str:
    """Return warnings, a row per position, then summary, estimate and cost.

    Parameters
    ----------
    result : Result

    Returns
    -------
    str
        Lines without a final line break.
    """
    return _text([_title(result), "", *_warnings((result,)), *_body(result)])


def texts_of(results: Sequence[Result]) -> str:
    """Return the text of several torques: common warnings first, then each table.

    Parameters
    ----------
    results : sequence of Result
        Results of one scene.

    Returns
    -------
    str
    """
    if len(results) == 1:
        return text_of(results[0])
    tables = [_text([_title(result), "", *_body(result)]) for result in results]
    warnings = _text([*_warnings(results)])
    return "\n\n".join([warnings, *tables] if warnings else tables)


def _text(lines: list[str]) -> str:
    return "\n".join(line.rstrip() for line in lines).rstrip("\n")


def _warnings(results: Sequence[Result]) -> Iterator[str]:
    """Warnings and an empty line."""
    lines = warning_lines(results)
    yield from (_labelled("warning", line) for line in lines)
    if lines:
        yield ""


def _body(result: Result) -> list[str]:
    """Rows and the text below them."""
    if result.drive is not None:
        rows = [*result.drive.rows(result)]
    elif result.has_cam:
        rows = _rows_of_cam(result)
    elif result.whole_circle:
        rows = _rows_of_circle(result)
    elif result.sites.size > MOST_COLUMNS:
        rows = _rows_of_loaded(result)
    else:
        rows = _rows(result)
    return [*rows, "", *_footer(result)]


def _title(result: Result) -> str:
    count = result.position_rad.size
    where = f"{count} position{'s' * (count != 1)}"
    if result.closed:
        if result.has_cam:
            return f"{result.name}: {result.torque_Nm:g} N m, {where} over one turn of the cam"
        pitches = result.period_pitches
        where += f" over {'one pitch' if pitches == 1 else f'{pitches} pitches'}"
        where += f" of {degrees(result.pitch_rad):g} deg"
    return f"{result.name}: {result.torque_Nm:g} N m, {where}"


def _rows(result: Result) -> list[str]:
    """A row per position."""
    sites = range(result.sites.size)
    return text_table(
        [
            (*HEAD, *(text for s in sites for text in (f"pair {result.sites[s]}", ""))),
            (*UNITS, *("share %", "MPa") * result.sites.size),
            *(
                (*cells, *(text for s in sites for text in _share_and_pressure(result, p, s)))
                for p, cells in enumerate(_position_cells(result))
            ),
        ]
    )


def _rows_of_cam(result: Result) -> list[str]:
    """A row per position: angle of the follower, then the values of its one contact."""
    assert result.follower_angle_rad is not None
    follower = np.degrees(result.follower_angle_rad)
    return text_table(
        [
            (*HEAD, "follower", "force", "pressure"),
            (*UNITS, "deg", "kN", "MPa"),
            *(
                (*cells, f"{follower[p]:.3f}", *_force_and_pressure(result, p, 0))
                for p, cells in enumerate(_position_cells(result))
            ),
        ]
    )


def _rows_of_loaded(result: Result) -> list[str]:
    """A row per position with the pairs that carry load there, out of many."""
    most = int(result.loaded_pairs.max())
    rows: list[tuple[str, ...]] = [
        (*HEAD, *("pair that", "carries", "") * most),
        (*UNITS, *("pair", "share %", "MPa") * most),
    ]
    for p, cells in enumerate(_position_cells(result)):
        carrying = np.flatnonzero(result.site_force_N[p] > 0).tolist()
        rows.append(
            (
                *cells,
                *(
                    text
                    for s in carrying
                    for text in (f"{result.sites[s]}", *_share_and_pressure(result, p, s))
                ),
            )
        )
    return text_table(rows)


def _rows_of_circle(result: Result) -> list[str]:
    """A row per position, then one per tooth at the position of the largest force."""
    rows: list[tuple[str, ...]] = [
        (*HEAD, "teeth loaded", "most on one", "at tooth"),
        (*UNITS, "", "share %", ""),
    ]
    for p, cells in enumerate(_position_cells(result)):
        s = int(np.argmax(result.site_force_N[p]))
        at = f"{result.sites[s]}" if result.loaded_pairs[p] else NONE
        rows.append(
            (*cells, f"{result.loaded_pairs[p]}", f"{100 * result.load_share[p, s]:.2f}", at)
        )
    p = int(np.argmax(result.site_force_N.max(axis=1)))
    title = f"load per tooth at {degrees(result.position_rad[p]):.3f} deg"
    return [*text_table(rows), "", title, *_rows_of_teeth(result, p)]


def _rows_of_teeth(result: Result, p: int) -> list[str]:
    """A row per tooth at a position."""
    coast = result.coast
    heads = ("", "coast", "pressure") if coast is not None else ()
    units = ("", "kN", "MPa") if coast is not None else ()
    rows: list[tuple[str, ...]] = [
        ("tooth", "force", "share", "pressure", *heads),
        ("", "kN", "%", "MPa", *units),
    ]
    for s, site in enumerate(result.sites):
        force, pressure = _force_and_pressure(result, p, s)
        share = _share_and_pressure(result, p, s)[0]
        beside = () if coast is None else ("", *_force_and_pressure(coast, p, s))
        rows.append((f"{site}", force, share, pressure, *beside))
    return text_table(rows)


def _position_cells(result: Result) -> Iterator[list[str]]:
    """Cells of a position before its pairs."""
    numbers = np.column_stack(
        [
            np.degrees(result.position_rad),
            result.transmission_error_um,
            result.stiffness_tangent_N_per_um,
            result.stiffness_secant_N_per_um,
        ]
    )
    for row in numbers:
        yield [number(*both) for both in zip(row, (".3f", ".3f", ".2f", ".2f"), strict=True)]


def _share_and_pressure(result: Result, p: int, s: int) -> tuple[str, str]:
    pressure = _force_and_pressure(result, p, s)[1]
    return (NONE if pressure == NONE else f"{100 * result.load_share[p, s]:.2f}"), pressure


def _force_and_pressure(contact: Result | CoastContact, p: int, s: int) -> tuple[str, str]:
    """Force in kN and pressure in MPa, marked on a sharp corner; empty if unloaded."""
    force = contact.force_N if isinstance(contact, CoastContact) else contact.site_force_N
    if force[p, s] <= 0:
        return NONE, NONE
    mark = MARK * bool(contact.corner_contact[p, s])
    return f"{force[p, s] / 1e3:.3f}", f"{contact.peak_pressure_MPa[p, s]:.0f}{mark}"


def _footer(result: Result) -> Iterator[str]:
    summary = result.summary
    yield from _transmission_error_lines(result)
    yield _labelled("loaded pairs", _loaded_pairs(result))
    if summary["peak_pressure_pair"] is not None:
        yield _labelled("largest pressure", _largest_pressure(summary))
    if result.drive is not None:
        yield _labelled(result.drive.name, result.drive.words())
    yield from _contact_lines(result)
    for z in (1, 2):
        if f"root_stress_{z}" in summary and result.torque_Nm > 0:
            yield _labelled(f"root of body {z}", _root_stress(summary[f"root_stress_{z}"]))
    if result.friction is not None:
        yield _labelled("friction", _friction(result.friction))
    beyond = outside_words(result.outside_limits)
    yield from _estimate_lines(result, beyond)
    if result.accuracy is not None:
        first, *more = accuracy_lines(result.accuracy)
        yield _labelled("tolerance", first + beyond)
        for text in more:
            yield _labelled("", text)
    yield _labelled("cost", _cost(result.cost))
    for status, words in STATUS_WORDS.items():
        positions = np.flatnonzero(result.status == status)
        if positions.size:
            listed = ", ".join(map(str, positions[:8])) + (", ..." if positions.size > 8 else "")
            yield _labelled(f"status {status}", f"{words}: positions {listed}")


def _transmission_error_lines(result: Result) -> Iterator[str]:
    summary = result.summary
    mean, by_load = (summary[f"transmission_error_{kind}mean_um"] for kind in ("", "by_load_"))
    beyond = ""
    if result.torque_Nm > 0 and abs(by_load - mean) > LEAST_UNLOADED * abs(mean):
        beyond = f" ({by_load:.3f} um beyond the state without load)"
    text = f"mean {mean:.3f} um{beyond}, "
    text += f"peak to peak {summary['transmission_error_peak_to_peak_um']:.3f} um"
    if result.position_rad.size == 1:
        text = f"{mean:.3f} um at one position{beyond}"
    harmonics = summary["transmission_error_mesh_harmonics_um"]
    if harmonics is not None:
        text += f", harmonics 1 to {len(harmonics)}: {_amplitudes(harmonics)} um"
    yield _labelled("transmission error", text)
    if harmonics is not None and result.period_pitches > 1:
        whole = _amplitudes(summary["transmission_error_harmonics_um"])
        yield _labelled("", f"harmonics of {result.period_pitches} pitches: {whole} um")


def _loaded_pairs(result: Result) -> str:
    summary = result.summary
    least, most = summary["loaded_pairs_min"], summary["loaded_pairs_max"]
    text = f"{least}" if least == most else f"{least} to {most}"
    if summary["contact_ratio_under_load"] is not None:
        text += f" (contact ratio under load {summary['contact_ratio_under_load']:.3f}"
        if summary["contact_ratio_geometric"] is not None:
            by_tips, usable = (
                f"{summary[f'contact_ratio_{kind}']:.3f}" for kind in ("geometric", "usable")
            )
            text += f", {by_tips} by geometry"
            text += f", {usable} of it on both involutes" * (usable != by_tips)
        text += ")"
    return text + f" of {result.sites.size} teeth carry load" * result.whole_circle


def _estimate_lines(result: Result, beyond: str) -> Iterator[str]:
    """Estimated errors, and those of single sources; `beyond`: note on violated premises."""
    if result.estimate is None:
        return
    estimate, summary = result.estimate, result.summary
    if result.position_rad.size == 1:
        estimate = {key: value for key, value in estimate.items() if key not in OF_SEVERAL}
    text = _estimate(estimate)
    off_corners = summary["peak_pressure_off_corners_pair"] is not None
    if summary["peak_pressure_pair"] is not None and not off_corners:
        text += ", peak pressure not estimated (sharp corners)"
    yield _labelled("estimated error", text + beyond)
    for source, label in SHOWN_ALONE.items():
        left = result.estimate.get("by_source", {}).get(source, {})
        if any(error > ROUNDING for error in left.values()) or (left and source == "positions"):
            text = _estimate({key.removeprefix(OF_ROTATION): error for key, error in left.items()})
            yield _labelled(label, text + beyond)


def _amplitudes(harmonics: list[float | None]) -> str:
    return " ".join("-" if a is None else f"{a:.3f}" for a in harmonics)


def _root_stress(found: Any) -> str:
    parts = []
    for name in ("tension", "compression"):
        extreme = found[name]
        parts.append(
            f"{name} {extreme['stress_MPa']:.0f} MPa on pair {extreme['pair']} at "
            f"{degrees(extreme['position_rad']):.3f} deg (radius {extreme['radius_mm']:.2f} mm, "
            f"tangent {extreme['slant_deg']:.0f} deg"
            + (f", z {extreme['z_mm']:.2f} mm)" if "z_mm" in extreme else ")")
        )
    return "; ".join(parts)


def _contact_lines(result: Result) -> Iterator[str]:
    """Available lines on stiffness, line load, sliding and coast flanks."""
    summary = result.summary
    tangent, secant = (summary[f"stiffness_{kind}_mean_N_per_um"] for kind in ("tangent", "secant"))
    if tangent is not None and secant is not None:
        text = f"mean {tangent:.2f} N/um tangent, {secant:.2f} N/um secant"
        yield _labelled("stiffness", text)
    if summary["peak_line_load_pair"] is not None and result.drive is None:
        text = f"up to {summary['peak_line_load_N_per_mm']:.1f} N/mm on pair "
        text += f"{summary['peak_line_load_pair']} at "
        text += f"{degrees(summary['peak_line_load_position_rad']):.3f} deg"
        yield _labelled("line load", text)
    if summary["largest_sliding_mm_per_rad"]:
        turning = "the cam, for a roller that does not rotate" if result.has_cam else "body 1"
        text = f"up to {summary['largest_sliding_mm_per_rad']:.2f} mm per rad of {turning}"
        yield _labelled("sliding", text)
    if result.coast is not None:
        yield _labelled("coast flanks", _coast_forces(summary))
    elif summary["coast_flank_gap_min_um"] is not None:
        gap = summary["coast_flank_gap_min_um"]
        text = f"at least {gap:.1f} um apart under load"
        if gap < 0:
            text = f"overlap of up to {-gap:.1f} um under load: they would carry load as well"
        yield _labelled("coast flanks", text)
    elif result.geometry is not None and not result.has_cam:
        reason = result.geometry.coast_unknown or "none face each other"
        yield _labelled("coast flanks", f"unknown: {reason}")


def _coast_forces(summary: dict[str, Any]) -> str:
    if summary["coast_force_pair"] is None:
        gap = summary["coast_flank_gap_min_um"]
        return "none carries" + ("" if gap is None else f", at least {gap:.1f} um apart")
    least, most = summary["coast_flanks_loaded_min"], summary["coast_flanks_loaded_max"]
    text = f"{least}" if least == most else f"{least} to {most}"
    text += (
        f" carry, up to {summary['coast_force_N'] / 1e3:.3f} kN on pair "
        f"{summary['coast_force_pair']} at {degrees(summary['coast_force_position_rad']):.3f} deg"
    )
    if summary["coast_peak_pressure_off_corners_pair"] is not None:
        text += f", {summary['coast_peak_pressure_off_corners_MPa']:.0f} MPa"
    return text


def _labelled(label: str, text: str) -> str:
    return f"{label:<18}  {text}"


def _largest_pressure(summary: dict[str, Any]) -> str:
    parts = []
    if summary["peak_pressure_off_corners_pair"] is not None:
        parts.append(
            f"{summary['peak_pressure_off_corners_MPa']:.0f} MPa on pair "
            f"{summary['peak_pressure_off_corners_pair']} at "
            f"{degrees(summary['peak_pressure_off_corners_position_rad']):.3f} deg"
        )
    if summary["peak_pressure_at_corner"]:
        parts.append(
            f"up to {summary['peak_pressure_MPa']:.0f} MPa on a sharp corner ({MARK}), "
            "which is meaningless"
        )
    return "; ".join(parts)


def _friction(friction: FrictionResult) -> str:
    least, most = friction.torque_2_Nm.min(), friction.torque_2_Nm.max()
    text = f"{friction.driver} drives, torque on body 2 {least:.4g} to {most:.4g} N m"
    if friction.efficiency is None or friction.loss_work_J is None:
        return text
    return (
        f"{text}; loss {friction.loss_work_J:.4g} J per period, efficiency "
        f"{100 * friction.efficiency:.3f} %"
    )


def _estimate(estimate: Any) -> str:
    """Each quantity's error, and its largest source."""
    sources = estimate.get("dominant_source", {})
    return ", ".join(
        f"{quantity.replace('_', ' ')} {100 * error if error > ROUNDING else 0:.2g} %"
        + (f" ({sources[quantity]})" if quantity in sources and error > ROUNDING else "")
        for quantity, error in estimate.items()
        if isinstance(error, int | float)
    )


def _cost(cost: Any) -> str:
    stages = cost.get("stages", {})
    seconds = {
        name: account["wall_s"] if isinstance(account, dict) else account
        for name, account in stages.items()
    }
    parts = [f"{name} {value:.3g} s" for name, value in seconds.items()]
    counters = [
        f"{cost[key]} {words}"
        for key, words in (
            ("fe_factorisations", "FE factorisations"),
            ("unit_loads_normal", "unit loads"),
            *(
                [("unit_loads_tangential", "tangential unit loads")]
                if cost.get("unit_loads_tangential")
                else []
            ),
            *(
                [("fe_load_cases_growth", "load cases of expansion")]
                if cost.get("fe_load_cases_growth")
                else []
            ),
            ("pivots", "pivots"),
        )
        if key in cost
    ]
    total = f"{sum(seconds.values()):.3g} s ({', '.join(parts)})" if parts else ""
    return "; ".join(part for part in (total, ", ".join(counters)) if part)
