"""A plan as text, and changes that are significant: more than a quarter of the tolerance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flankload.base.text_table import text_table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.studies.plan.planned import Plan, PlannedEffect

MEGABYTE = 1e6
#: Smaller changes of the load share and of the face load factor are not mentioned.
LEAST_SHARE, LEAST_FACTOR = 1e-4, 0.005
#: Part of the tolerance beyond which a change is significant.
SIGNIFICANT_PART = 0.25
#: Digits of a size; more digits if rounding would move it across the threshold.
FEWEST_DIGITS, MOST_DIGITS = 2, 17
#: The most informative counters, with their names in text.
SHOWN = {
    "fe_factorisations": "factorisations",
    "fe_unknowns": "unknowns of the bodies",
    "unit_loads_normal": "normal unit loads",
    "unit_loads_tangential": "tangential unit loads",
    "coast_readings": "coast readings",
    "stress_recoveries": "stress recoveries",
    "states": "states",
    "slices": "slices in all states",
    "influence_columns": "influence columns",
    "pivots": "pivots",
}


def is_significant(size: float, tolerance: float) -> bool:
    """Whether a change is more than a quarter of the tolerance."""
    return size > SIGNIFICANT_PART * tolerance


def threshold_text(tolerance: float) -> str:
    """A quarter of the tolerance in %, with all its digits."""
    return f"{100 * SIGNIFICANT_PART * tolerance:.10g} %"


def against_threshold(size: float, tolerance: float) -> str:
    """A change and a quarter of the tolerance, with enough digits to compare them."""
    sign = ">" if is_significant(size, tolerance) else "<="
    for digits in range(FEWEST_DIGITS, MOST_DIGITS):
        shown = f"{100 * size:.{digits}g}"
        if is_significant(float(shown) / 100, tolerance) == is_significant(size, tolerance):
            break
    return f"{shown} % {sign} {threshold_text(tolerance)}"


def plan_text(plan: Plan) -> str:
    """Table of the effects, table of the stages, sentences."""
    threshold = threshold_text(plan.tolerance)
    title = (
        f"{plan.name}: changes of more than {threshold}, a quarter of the tolerance, are "
        "significant"
    )
    parts = [[title], _effects(plan), _stages(plan)]
    if plan.picked is not None:
        parts.append(_picked(plan.tolerance, plan.picked))
    if plan.choice:
        lines = [f"chosen by effects.choose: {chosen}" for chosen in plan.choice]
        if plan.left_out is not None:
            lines.append(
                "omitted effects together change the rotation by at most "
                f"{_percent(plan.left_out.rotation_largest)} and the load share by at most "
                f"{_points(plan.left_out.load_share)}"
            )
        parts.append(lines)
    unknown = [
        f"size of {effect.title} unknown: {effect.unknown}"
        for effect in plan.effects
        if effect.unknown is not None and effect.possible
    ]
    if unknown:
        parts.append(unknown)
    if plan.remarks:
        parts.append(list(plan.remarks))
    return "\n\n".join("\n".join(lines) for lines in parts)


def _picked(tolerance: float, picked: Mapping[str, Any]) -> list[str]:
    keys = [f"{key} = {value}" for table in picked["keys"].values() for key, value in table.items()]
    start = ", ".join(keys) or "the given parameters"
    return [
        f"accuracy.tolerance = {tolerance:g} begins with {start}",
        "if the error estimate of that run exceeds the tolerance, up to two finer runs follow",
    ]


def _effects(plan: Plan) -> list[str]:
    sizes = [effect.size for effect in plan.effects if effect.size is not None]
    faces = any(size.face_load_factor is not None for size in sizes)
    head = ["effect", "on", "s", "MB", "rotation", "at most", "share", "K_Hbeta" * faces]
    lines = text_table([head, *map(_cells, plan.effects)], left=2)
    width = max(map(len, lines))
    reasons = ["because of", *map(_reason, plan.effects)]
    return [f"{line:<{width}}  {why}" for line, why in zip(lines, reasons, strict=True)]


def _cells(effect: PlannedEffect) -> list[str]:
    """Name, cost and size of an effect; empty cells for what is unknown."""
    size, cells = effect.size, [effect.title, "yes" if effect.on else "no"]
    if effect.extra_s is None or effect.extra_bytes is None or not _is_possible(effect):
        cells += ["", ""]
    else:
        cells += [f"{effect.extra_s:.3f}", f"{effect.extra_bytes / MEGABYTE:.2f}"]
    if size is None or not _is_possible(effect):
        return cells
    return [
        *cells,
        "" if size.rotation_mean is None else f"{100 * size.rotation_mean:+.2f} %",
        _percent(size.rotation_largest) or f"{size.rotation_um:.3g} um",
        _points(size.load_share),
        "" if size.face_load_factor is None else f"{size.face_load_factor:+.3f}",
    ]


def _is_possible(effect: PlannedEffect) -> bool:
    return effect.possible or effect.on


def _reason(effect: PlannedEffect) -> str:
    if not _is_possible(effect):
        return "not with this scene"
    assumed = "" if effect.assumed is None else f" (with {effect.assumed.rpartition(' = ')[2]})"
    return effect.because + assumed + " (size unknown)" * (effect.unknown is not None)


def _stages(plan: Plan) -> list[str]:
    stages = plan.predicted["stages"]
    costs = {name: (s["cpu_s"], s["bytes"] + s["workspace_bytes"]) for name, s in stages.items()}
    costs["all"] = (plan.seconds, sum(memory for _, memory in costs.values()))
    rows = [(name, f"{s:.3f}", f"{size / MEGABYTE:.2f}") for name, (s, size) in costs.items()]
    lines = text_table([("stage", "s", "MB"), *rows], left=1)
    counters = plan.predicted["counters"]
    words = [f"{counters[name]} {text}" for name, text in SHOWN.items() if counters.get(name)]
    known = f"uncertainty of the seconds: a factor of {plan.within:g}"
    return [*lines, *filter(None, [", ".join(words)]), known]


def remark_on(row: PlannedEffect, *, coarser: bool) -> str | None:
    """A sentence on a significant effect that is omitted, or that is an error of the run."""
    size = row.size
    if size is None or not row.matters or row.on != coarser:
        return None
    change = f"the rotation at a position by {_hundredths(size.rotation_largest)} %"
    if size.rotation_largest is None:
        change = f"the transmission error by {size.rotation_um:.2g} um"
    if size.load_share > LEAST_SHARE:
        change += f" and the load share by {_hundredths(size.load_share)} points"
    if abs(size.face_load_factor or 0.0) > LEAST_FACTOR:
        change += f", K_Hbeta by {size.face_load_factor:+.2f}"
    if coarser:
        return f"{row.title} is on ({row.because}): that changes {change}"
    off = f"{row.title} is off ({row.because})"
    if row.assumed is not None:
        return f"{off}: with {row.assumed} it would change {change}"
    return f"{off} and likely to matter: it changes {change}"


def _hundredths(part: float | None) -> str:
    """Number with two digits, without an exponent."""
    return f"{float(f'{100 * (part or 0.0):.2g}'):g}"


def _percent(part: float | None) -> str:
    return "" if part is None else f"{100 * part:.2f} %"


def _points(part: float) -> str:
    return f"{100 * part:.2f} pts"
