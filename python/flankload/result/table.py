"""A result as text for the terminal."""

from __future__ import annotations

from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.number_text import error_of, percent
from flankload.base.rounding import TIE
from flankload.base.text_table import MARK, NONE, text_table
from flankload.contact.status import Status
from flankload.cost import COUNTERS
from flankload.result.notes import accuracy_lines, outside_words, warning_lines
from flankload.result.quantities import plus_minus
from flankload.result.summary import NO_VALUE

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.result.friction import FrictionResult
    from flankload.result.result import Result

    #: Label and text.
    Line = tuple[str, str]

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
    Status.ILL_CONDITIONED: (
        "solved; the sum of the forces of neighbouring pairs is accurate, their shares are not"
    ),
    Status.DEGENERATE: "solved; a pair has neither force nor gap",
    Status.NOT_UNIQUE: (
        "solved; the solution satisfies all contact conditions; that it is the only one could not "
        "be proven (see Statuses)"
    ),
}
#: Counters of the cost in the last line, with their words; the second part only if it is not 0.
COUNTED = {"fe_factorisations": "FE factorisations", "unit_loads_normal": "unit loads"}
COUNTED_IF_ANY = {
    "unit_loads_tangential": "tangential unit loads",
    "fe_load_cases_growth": "load cases of expansion",
}
#: Entries of an account beside its counters: key, name, and number of units in one of the
#: account's.
MEASURES = (
    ("cpu_s", "CPU s", 1.0),
    ("wall_s", "wall s", 1.0),
    ("bytes", "MB held", 1e-6),
    ("workspace_bytes", "MB workspace", 1e-6),
)


def texts_of(results: Sequence[Result]) -> str:
    """Return the text of one or several torques.

    Parameters
    ----------
    results : sequence of Result
        Results of one scene.

    Returns
    -------
    str
        Common warnings, then for each torque a row per position, summary, estimate and cost; lines
        without a final line break.
    """
    warnings = [_labelled("warning", line) for line in warning_lines(results)]
    if len(results) == 1:
        return _text(results[0], [*warnings, ""] if warnings else [])
    tables = [_text(result) for result in results]
    return "\n\n".join(["\n".join(warnings), *tables] if warnings else tables)


def _text(result: Result, before: Sequence[str] = ()) -> str:
    """Text of one torque, with lines before its rows."""
    below = (_labelled(*line) for line in _footer(result))
    lines = [_title(result), "", *before, *result.engagement.rows(result), "", *below]
    return "\n".join(line.rstrip() for line in lines).rstrip("\n")


def _labelled(label: str, text: str) -> str:
    return f"{label:<18}  {text}"


def _title(result: Result) -> str:
    count = result.position_rad.size
    where = f"{count} position{'s' * (count != 1)}"
    if result.closed:
        where += f" over {result.engagement.period_in_words(result)}"
    return f"{result.name}: {result.torque_Nm:g} N m, {where}"


def _footer(result: Result) -> Iterator[Line]:
    """Labels and texts of the lines below the rows."""
    summary = result.summary
    yield from _transmission_error_lines(result)
    yield f"loaded {result.words_for_sites[1]}", _loaded_pairs(result)
    if summary["peak_pressure_pair"] is not None or summary["corner_pressure_pair"] is not None:
        yield "largest pressure", _largest_pressure(result)
    if result.drive is not None:
        yield result.drive.name, result.drive.words()
    yield from _contact_lines(result)
    for z in (1, 2):
        if f"root_stress_{z}" in summary and result.torque_Nm > 0:
            yield f"root of body {z}", _root_stress(result, summary[f"root_stress_{z}"])
    if result.friction is not None:
        yield "friction", _friction(result.friction)
    if "power_W" in summary:
        yield "power", _power(result)
    beyond = outside_words(result.outside_limits)
    yield from _estimate_lines(result, beyond)
    if result.accuracy is not None:
        first, *more = accuracy_lines(result.accuracy)
        yield "tolerance", first + beyond
        for text in more:
            yield "", text
    yield "cost", _cost(result.cost)
    for status, words in STATUS_WORDS.items():
        positions = np.flatnonzero(result.status == status)
        if positions.size:
            listed = ", ".join(map(str, positions[:8])) + (", ..." if positions.size > 8 else "")
            yield f"status {status}", f"{words}: positions {listed}"


def _transmission_error_lines(result: Result) -> Iterator[Line]:
    summary = result.summary
    mean, by_load = (summary[f"transmission_error_{kind}mean_um"] for kind in ("", "by_load_"))
    beyond = ""
    if result.torque_Nm > 0 and abs(by_load - mean) > LEAST_UNLOADED * abs(mean):
        beyond = f" ({by_load:.3f} um beyond the state without load)"
    text = f"mean {mean:.3f} um{beyond}, "
    swing = summary["transmission_error_peak_to_peak_um"]
    text += f"peak to peak {swing:.3f} um"
    part = (result.estimate or {}).get("transmission_error_peak_to_peak", 0.0)
    if part > 1.0:
        text += f" +- {error_of(swing, part, 'um')}"
    if result.position_rad.size == 1:
        text = f"{mean:.3f} um at one position{beyond}"
    harmonics = summary["transmission_error_mesh_harmonics_um"]
    if harmonics is not None:
        text += f", harmonics 1 to {len(harmonics)}: {_amplitudes(harmonics)} um"
    yield "transmission error", text
    if harmonics is not None and result.period_pitches > 1:
        whole = _amplitudes(summary["transmission_error_harmonics_um"])
        yield "", f"harmonics of {result.period_pitches} pitches: {whole} um"


def _loaded_pairs(result: Result) -> str:
    summary = result.summary
    text = _range(summary, "loaded_pairs")
    if summary["contact_ratio_under_load"] is not None:
        text += f" (contact ratio under load {summary['contact_ratio_under_load']:.3f}"
        if summary["contact_ratio_geometric"] is not None:
            text += f", {_geometric_ratios(summary)}"
        text += ")"
    return text + result.engagement.out_of_all(result)


def _geometric_ratios(summary: dict[str, Any]) -> str:
    """Contact ratios by geometry: of straight teeth the transverse one, otherwise all."""
    total, transverse, usable = (
        f"{summary[f'contact_ratio_{kind}']:.3f}" for kind in ("total", "geometric", "usable")
    )
    of_it = f", {usable} of it on both involutes" * (usable != transverse)
    if not summary["overlap_ratio"]:
        return f"{total} by geometry{of_it}"
    overlap = f"eps_beta {summary['overlap_ratio']:.3f}"
    return f"eps_gamma {total} by geometry: {overlap}, eps_alpha {transverse}{of_it}"


def _estimate_lines(result: Result, beyond: str) -> Iterator[Line]:
    """Estimated errors, and those of single sources; `beyond`: note on violated premises."""
    if result.estimate is None:
        return
    estimate, summary = result.estimate, result.summary
    if result.position_rad.size == 1:
        estimate = {key: value for key, value in estimate.items() if key not in OF_SEVERAL}
    text = _estimate(estimate)
    if summary["peak_pressure_MPa"] is None:
        text += ", peak pressure not estimated (sharp corners)"
    elif unestimated_pressure(result) and "peak_pressure" not in estimate:
        text += ", peak pressure not estimated (beside ends of flanks)"
    yield "estimated error", text + beyond
    for source, label in SHOWN_ALONE.items():
        left = result.estimate.get("by_source", {}).get(source, {})
        if any(error > TIE for error in left.values()) or (left and source == "positions"):
            text = _estimate({key.removeprefix(OF_ROTATION): error for key, error in left.items()})
            yield label, text + beyond


def _range(summary: Mapping[str, Any], key: str) -> str:
    least, most = summary[f"{key}_min"], summary[f"{key}_max"]
    return f"{least}" if least == most else f"{least} to {most}"


def _place(result: Result, found: Mapping[str, Any], key: str = "") -> str:
    """Pair, or another site, and position of a largest value."""
    site, at = found[f"{key}pair"], degrees(found[f"{key}position_rad"])
    return f"on {result.words_for_sites[0]} {site} at {at:.3f} deg"


def _amplitudes(harmonics: list[float | None]) -> str:
    return " ".join("-" if a is None else f"{a:.3f}" for a in harmonics)


def _root_stress(result: Result, found: Any) -> str:
    parts = []
    for name in ("tension", "compression"):
        extreme = found[name]
        parts.append(
            f"{name} {extreme['stress_MPa']:.0f} MPa {_place(result, extreme)} "
            f"(radius {extreme['radius_mm']:.2f} mm, tangent {extreme['slant_deg']:.0f} deg"
            + (f", z {extreme['z_mm']:.2f} mm)" if "z_mm" in extreme else ")")
        )
    return "; ".join(parts)


def _contact_lines(result: Result) -> Iterator[Line]:
    """Available lines on stiffness, line load, sliding and coast flanks."""
    summary = result.summary
    tangent, secant = (summary[f"stiffness_{kind}_mean_N_per_um"] for kind in ("tangent", "secant"))
    if tangent is not None and secant is not None:
        yield "stiffness", f"mean {tangent:.2f} N/um tangent, {secant:.2f} N/um secant"
    if summary["peak_line_load_pair"] is not None and result.engagement.has_pressures:
        load = summary["peak_line_load_N_per_mm"]
        error = plus_minus(result.estimate, "peak_line_load")
        text = f"up to {load:.1f} N/mm{error} {_place(result, summary, 'peak_line_load_')}"
        if "face_load_factor" in summary:
            error = plus_minus(result.estimate, "face_load_factor")
            text = f"K_Hbeta {summary['face_load_factor']:.3f}{error}, {text}"
            text += f", of all pairs {summary['line_load_factor']:.3f} times the mean"
            text += f" (means over {summary['line_load_length_mm']:.3g} mm)"
        yield "line load", text
    if summary["largest_sliding_mm_per_rad"]:
        sliding, body = summary["largest_sliding_mm_per_rad"], result.engagement.sliding_body
        yield "sliding", f"up to {sliding:.2f} mm per rad of {body}"
    if result.coast is not None:
        yield "coast flanks", _coast_forces(result)
    elif summary["coast_flank_gap_min_um"] is not None:
        gap = summary["coast_flank_gap_min_um"]
        text = f"at least {gap:.1f} um apart under load"
        if gap < 0:
            text = f"overlap of up to {-gap:.1f} um under load: they would carry load as well"
        yield "coast flanks", text
    elif (geometry := result.geometry) is not None and geometry.has_coast_flanks:
        yield "coast flanks", f"unknown: {geometry.coast_unknown or 'none face each other'}"


def _coast_forces(result: Result) -> str:
    summary = result.summary
    if summary["coast_force_pair"] is None:
        gap = summary["coast_flank_gap_min_um"]
        return "none carries" + ("" if gap is None else f", at least {gap:.1f} um apart")
    text = f"{_range(summary, 'coast_flanks_loaded')} carry, up to "
    text += f"{summary['coast_force_N'] / 1e3:.3f} kN {_place(result, summary, 'coast_force_')}"
    if summary["coast_peak_pressure_pair"] is not None:
        text += f", {summary['coast_peak_pressure_MPa']:.0f} MPa"
    return text


def _largest_pressure(result: Result) -> str:
    summary = result.summary
    if summary["peak_pressure_MPa"] is None:
        return f"none: {NO_VALUE['peak_pressure_MPa']} ({MARK})"
    error = plus_minus(result.estimate, "largest_pressure")
    place = _place(result, summary, "peak_pressure_")
    text = f"{summary['peak_pressure_MPa']:.0f} MPa{error} {place}"
    if why := unestimated_pressure(result):
        text += f" (error not estimated: {why})"
    if summary["corner_pressure_pair"] is not None:
        text += f"; at sharp corners ({MARK}) no finite pressure exists"
    return text


def unestimated_pressure(result: Result) -> str:
    """Reason why the largest pressure has no estimate; empty if it has one, or nothing has."""
    return str((result.estimate or {}).get("uncertain", {}).get("largest_pressure", ""))


def _friction(friction: FrictionResult) -> str:
    least, most = friction.torque_2_Nm.min(), friction.torque_2_Nm.max()
    text = f"{friction.driver} drives, torque on body 2 {least:.4g} to {most:.4g} N m"
    if friction.axial_force_N is not None and friction.tilting_moment_Nm is not None:
        text += f"; axial force up to {np.abs(friction.axial_force_N).max():.1f} N, tilting moment "
        text += f"up to {friction.tilting_moment_Nm.max():.4g} N m"
    if friction.efficiency is None or friction.loss_work_J is None:
        return text
    return (
        f"{text}; loss {friction.loss_work_J:.4g} J per period, efficiency "
        f"{100 * friction.efficiency:.3f} %"
    )


def _power(result: Result) -> str:
    assert result.geometry is not None
    text = f"{result.summary['power_W']:.1f} W at {result.geometry.speed_rpm:g} 1/min"
    if (loss := result.summary.get("power_loss_W")) is not None:
        text += f", loss by friction {loss:.1f} W"
    return text


def _estimate(estimate: Any) -> str:
    """Each quantity's error, and its largest source."""
    sources = estimate.get("dominant_source", {})
    return ", ".join(
        f"{quantity.replace('_', ' ')} {percent(error)}"
        + (f" ({sources[quantity]})" if quantity in sources and error > TIE else "")
        for quantity, error in estimate.items()
        if isinstance(error, int | float)
    )


def _cost(cost: Any) -> str:
    seconds = {
        name: account["wall_s"] if isinstance(account, dict) else account
        for name, account in cost.get("stages", {}).items()
    }
    stages = ", ".join(f"{name} {value:.3g} s" for name, value in seconds.items())
    shown = COUNTED | {key: words for key, words in COUNTED_IF_ANY.items() if cost.get(key)}
    shown["pivots"] = "pivots"
    counters = ", ".join(f"{cost[key]} {words}" for key, words in shown.items() if key in cost)
    total = f"{sum(seconds.values()):.3g} s ({stages})" if stages else ""
    return "; ".join(part for part in (total, counters) if part)


def cost_table(cost: Mapping[str, Any]) -> str:
    """A row for each quantity that a stage was predicted to use, or used."""
    rows = (row for item in cost["stages"].items() for row in _rows_of_stage(*item))
    return "\n".join(text_table([("stage", "work", "predicted", "spent"), *rows], left=2))


def _rows_of_stage(name: str, stage: Mapping[str, Any]) -> Iterator[tuple[str, str, str, str]]:
    """Rows of a stage; the first one contains its name."""
    predicted = stage["predicted"]
    label = name
    for key, words, unit in MEASURES:
        if key == "workspace_bytes" and not stage[key]:
            continue
        guess = _number(predicted[key] * unit) if key in predicted else NONE
        yield label, words, guess, _number(stage[key] * unit)
        label = ""
    counted, expected = stage["counters"], predicted.get("counters", {})
    for key in COUNTERS:
        if counted.get(key, 0) or expected.get(key, 0):
            guess = str(expected[key]) if key in expected else NONE
            yield "", key.replace("_", " "), guess, str(counted.get(key, 0))


def _number(value: float) -> str:
    return f"{value:.3f}" if value < 10 else f"{value:.0f}"
