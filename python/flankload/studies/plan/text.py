"""A plan as text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flankload.studies.plan.significance import threshold_text

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.studies.plan.planned import Plan, PlannedEffect

MEGABYTE = 1e6
#: Smaller changes of the load share and of the face load factor are not mentioned.
LEAST_SHARE, LEAST_FACTOR = 1e-4, 0.005
#: Width of the column of face load factors.
FACE = 9
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
    width = max(len(effect.title) for effect in plan.effects) + 2
    sizes = [effect.size for effect in plan.effects if effect.size is not None]
    faces = any(size.face_load_factor is not None for size in sizes)
    head = (
        f"{'effect':<{width}}{'on':<5}{'s':>8}{'MB':>8}{'rotation':>11}{'at most':>9}"
        f"{'share':>11}{'K_Hbeta' if faces else '':>{FACE * faces}}  because of"
    )
    return [head, *(_row(effect, width, FACE * faces) for effect in plan.effects)]


def _row(effect: PlannedEffect, width: int, face: int) -> str:
    size = effect.size
    numbers = ("", "", "", "")
    if size is not None:
        largest = _percent(size.rotation_largest)
        mean = "" if size.rotation_mean is None else f"{100 * size.rotation_mean:+.2f} %"
        factor = "" if size.face_load_factor is None else f"{size.face_load_factor:+.3f}"
        numbers = (
            mean,
            largest or f"{size.rotation_um:.3g} um",
            _points(size.load_share),
            factor,
        )
    because = effect.because
    if effect.assumed is not None:
        because += f" (with {effect.assumed.rpartition(' = ')[2]})"
    if not effect.possible and not effect.on:
        return f"{effect.title:<{width}}{'no':<5}{'':{47 + face}}  not with this scene"
    if effect.unknown is not None and effect.possible:
        because += " (size unknown)"
    cost = f"{'':16}"
    if effect.extra_s is not None and effect.extra_bytes is not None:
        cost = f"{effect.extra_s:8.3f}{effect.extra_bytes / MEGABYTE:8.2f}"
    line = (
        f"{effect.title:<{width}}{'yes' if effect.on else 'no':<5}{cost}"
        f"{numbers[0]:>11}{numbers[1]:>9}{numbers[2]:>11}{numbers[3]:>{face}}  {because}"
    )
    return line.rstrip()


def _stages(plan: Plan) -> list[str]:
    stages = plan.predicted["stages"]
    lines = [f"{'stage':<20}{'s':>8}{'MB':>8}"]
    memory = {
        name: (stage["bytes"] + stage["workspace_bytes"]) / MEGABYTE
        for name, stage in stages.items()
    }
    for name, stage in stages.items():
        lines.append(f"{name:<20}{stage['cpu_s']:8.3f}{memory[name]:8.2f}")
    lines.append(f"{'all':<20}{plan.seconds:8.3f}{sum(memory.values()):8.2f}")
    counters = plan.predicted["counters"]
    words = [f"{counters[name]} {text}" for name, text in SHOWN.items() if counters.get(name)]
    known = f"uncertainty of the seconds: a factor of {plan.within:g}"
    return [*lines, *filter(None, [", ".join(words)]), known]


def remark_on(row: PlannedEffect, *, coarser: bool) -> str | None:
    """A sentence on a significant effect that is omitted, or that is an error of the run.

    Parameters
    ----------
    row : PlannedEffect
    coarser : bool
        Whether the effect reduces the accuracy of the computation.

    Returns
    -------
    str or None
    """
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
