"""The table of a study as text, and its notes: errors that stay, runs without a solution."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.text_table import text_table
from flankload.result.notes import outside_words
from flankload.studies.accuracy.quantities import CORNER, HEADS, MEANINGS
from flankload.studies.accuracy.refinements import KINKS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.scene import Scene
    from flankload.studies.accuracy.study import AccuracyStudy, Row

#: Names of parameters in text.
PARAMETER_LABELS = {
    "flank_element_mm": "flank elements, mm",
    "modes": "pressure modes",
    "strips_per_half_width": "strips on the half-width",
    "zone_half_widths": "half-width of the zone",
    "axial_degree": "degree along the axis",
    "load_degree_z": "load degree along it",
    "slices": "slices of the width",
    "count": "positions",
}
#: Other groups, in order.
GROUPS = {
    "as it stands": "scene as given",
    "default": "default",
    "finest": "finest",
    "plane": "plane section",
    "coarse": "coarse bodies",
    "lumped": "lumped Hertz contact",
    "nodes": "plain nodal loads",
}
#: Tolerances for which the cheapest discretization is given.
NAMED = (1e-2, 1e-3, 1e-4)
#: Units of the parameters in the label of a run.
UNITS = {
    "flank_element_mm": "mm",
    "modes": "m",
    "strips_per_half_width": "s",
    "zone_half_widths": "z",
    "axial_degree": "deg",
    "slices": "sl",
    "count": "p",
}
#: Description of the reference, and of its uncertainty.
LIMIT = "uncertainty of the limit"
#: Data that kinds of bodies import.
FROM_FILES = {"mesh": "elements", "compliance": "influence coefficients"}
#: Replaces seconds if the uncertainty of the limit exceeds the tolerance.
IN_DOUBT = "?"
#: Column heading of the seconds of a step with the other parameters at their default.
DEFAULT_SECONDS = "default"


def text_of(study: AccuracyStudy) -> str:
    """Tables of parameter steps, and contact models; the cheapest discretizations."""
    return "\n".join(_lines(study))


def _lines(study: AccuracyStudy) -> Iterator[str]:
    names = [m for m in HEADS if any(m in row.errors for row in study.rows)]
    yield f"{study.name}: cost of accuracy"
    yield "CPU seconds and memory of a run alone, elements included; errors in %"
    yield "steps of a parameter: others at their finest, errors relative to its limit; column"
    yield f"'{DEFAULT_SECONDS}': seconds with the others at their default; other rows: errors"
    yield "relative to the limit of all parameters"
    if not study.has_errors:
        yield "the finest discretization was not run: errors are unknown"
    for name in names:
        counts = "" if name in study.measures else "; not requested"
        yield f"  {HEADS[name]:10s}{MEANINGS[name]}{counts}"
    yield ""
    for parameter, words in PARAMETER_LABELS.items():
        if study.steps.get(parameter):
            yield from _ladder(study, parameter, words, names)
    yield from _others(study, names)
    for note in study.notes:
        yield f"note: {note}"
    if study.stopped is not None:
        yield f"note: {study.stopped}"
    if study.has_errors:
        yield ""
        yield from _cheapest(study, names)


def _ladder(
    study: AccuracyStudy, parameter: str, words: str, names: Sequence[str]
) -> Iterator[str]:
    """Errors against the limit of this parameter, the others at their finest; coarse first."""
    steps = study.steps[parameter]
    adaptive = [row for row in steps if row.run.discretization.adaptive is not None]
    rows = [_heading(f"{words} (others finest)", names, DEFAULT_SECONDS)]
    for row in (*(row for row in reversed(steps) if row not in adaptive), *adaptive):
        used = row.run.discretization
        label = f"{getattr(used, parameter):g}{' (finest)' * (row.group == 'finest')}"
        if used.adaptive is not None:
            label = f"adaptive from {used.count}, to {used.adaptive:g}"
        seconds = study.seconds_at_default(row, parameter)
        rows.append(
            _cells(label, row, row.alone, names, "-" if seconds is None else f"{seconds:.3f}")
        )
    yield from text_table(rows, left=1)
    yield from _orders(study, parameter)
    yield ""


def _orders(study: AccuracyStudy, parameter: str) -> Iterator[str]:
    limits = study.limits.get(parameter)
    if limits is None:
        return
    if parameter == "count" and any(row.run.discretization.adaptive == KINKS for row in study.rows):
        yield "  no order of convergence because of kinks: errors relative to the last line"
        return
    orders = [
        f"{limit.order:.1f} ({_named(name)})"
        for name, limit in limits.items()
        if limit.order is not None
    ]
    if orders:
        yield f"  order {', '.join(orders)}"
    erratic = [name for name, limit in limits.items() if not limit.monotone]
    slow = [name for name, limit in limits.items() if limit.monotone and limit.slow]
    for what, found in (("does not converge monotonically", erratic), ("converges slowly", slow)):
        if found:
            yield f"  {what} in {', '.join(map(_named, found))}: errors relative to the finest step"


def _named(name: str) -> str:
    return HEADS.get(name) or name.replace("stiffness_", "").replace("_", " ")


def _others(study: AccuracyStudy, names: Sequence[str]) -> Iterator[str]:
    for group, words in GROUPS.items():
        rows = [row for row in study.rows if row.group == group and row.run.failure is None]
        if not rows:
            continue
        cells = [_heading(words, names)]
        cells += [_cells(_label(row), row, row.errors, names) for row in rows]
        if group == "finest":
            doubts = (_percent(study.doubts.get(name)) for name in names)
            cells.append([f"  {LIMIT}", "", "", *doubts])
        yield from text_table(cells, left=1)
        yield ""


def _label(row: Row) -> str:
    """Parameters of a run in short."""
    used = row.run.discretization
    if used.is_empty:
        return "all parameters as in the scene"
    alone = used.level == "nodes" and used.flank_element_mm is None
    parts = ["nodes by the contact's width"] * alone
    for name, unit in UNITS.items():
        if (value := getattr(used, name)) is not None:
            degrees = f"/{used.load_degree_z}" * (name == "axial_degree")
            parts.append(f"{value:g}{degrees} {unit}")
    if used.adaptive is not None:
        parts[-1] += f" to {used.adaptive:g}"
    return ", ".join(parts)


def _heading(words: str, names: Sequence[str], *further: str) -> list[str]:
    return [words, "CPU s", *further, "MB", *(HEADS[name] for name in names)]


def _cells(
    label: str, row: Row, errors: Mapping[str, float], names: Sequence[str], *further: str
) -> list[str]:
    """Line of a run in a table."""
    if row.run.failure is not None:
        return [f"  {label}", "no answer"]
    cost = (f"{row.run.cpu_s:.3f}", *further, f"{row.run.memory_bytes / 1e6:.1f}")
    return [f"  {label}", *cost, *(_percent(errors.get(name)) for name in names)]


def _percent(error: float | None) -> str:
    if error is None:
        return "-"
    return "0" if error == 0 else f"{100 * error:.2g}"


def _cheapest(study: AccuracyStudy, names: Sequence[str]) -> Iterator[str]:
    yield "CPU seconds of the cheapest discretization"
    rows = [["  to", *(HEADS[name] for name in names), "all"]]
    for tolerance in NAMED:
        seconds = (_seconds(study, tolerance, *of) for of in (*((name,) for name in names), ()))
        rows.append([f"  {100 * tolerance:g} %", *seconds])
    yield from text_table(rows, left=1)
    for tolerance in NAMED:
        row = study.cheapest(tolerance)
        if row is None:
            yield f"{100 * tolerance:g} %: {_why_none(study, tolerance)}"
            continue
        yield f"{100 * tolerance:g} %: {row.run.cpu_s:.3f} CPU s"
        lines = row.run.discretization.lines() or "scene as given"
        yield from (f"    {line}" for line in lines.splitlines())


def _seconds(study: AccuracyStudy, tolerance: float, *names: str) -> str:
    row = study.cheapest(tolerance, *names)
    if row is not None:
        return f"{row.run.cpu_s:.3f}"
    return IN_DOUBT if _is_in_doubt(study, tolerance, *names) else "none"


def _is_in_doubt(study: AccuracyStudy, tolerance: float, *names: str) -> bool:
    doubt = study.doubt(*names)
    return doubt is not None and doubt > tolerance


def _why_none(study: AccuracyStudy, tolerance: float) -> str:
    if not _is_in_doubt(study, tolerance):
        return "not reached by any run"
    worst = max(
        (name for name in study.measures if name in study.doubts), key=study.doubts.__getitem__
    )
    doubt = study.doubts[worst]
    size = f"{_percent(doubt)} % ({HEADS[worst]})" if isfinite(doubt) else "unknown"
    return f"not reached ({IN_DOUBT}): the uncertainty of the limit is {size}"


def notes_of(scene: Scene, rows: Sequence[Row], cells: Sequence[Row]) -> tuple[str, ...]:
    """All notes of a study; `cells` are the steps of the number of cells."""
    return *limit_notes(rows), *corner_notes(cells), *file_notes(scene), *failure_notes(rows)


def limit_notes(rows: Sequence[Row]) -> tuple[str, ...]:
    """Note on errors that are not included: violated premises of the model."""
    names = sorted({name for row in rows for name in row.run.outside})
    return (f"errors {outside_words(names).removeprefix('; ')}",) if names else ()


def corner_notes(rows: Sequence[Row]) -> tuple[str, ...]:
    """Note on an error that no discretization reduces: the pressure on sharp corners."""
    carrying = []
    for row in rows:
        strips = row.run.discretization.strips_per_half_width
        if row.run.values is not None and strips:
            pressure = float(np.max(row.run.values[CORNER], initial=0.0))
            carrying += [(strips, pressure)] * (pressure > 0)
    if not carrying:
        return ()
    (few, low), (many, high) = min(carrying), max(carrying)
    note = (
        f"a sharp corner carries load: its pressure, {low:.0f} MPa with {few:g} strips "
        f"and {high:.0f} MPa with {many:g}, has no limit; no discretization changes that, "
        "but a tip radius (tip_radius_mm) or a parabolic relief does"
    )
    return (note,)


def file_notes(scene: Scene) -> tuple[str, ...]:
    """Note on data in files, which a study cannot vary."""
    return tuple(
        f"{key}: its {what} come from a file, whose own error is not included"
        for key, body in (("body_1", scene.body_1), ("body_2", scene.body_2))
        if (what := FROM_FILES.get(body.kind)) is not None
    )


def failure_notes(rows: Sequence[Row]) -> tuple[str, ...]:
    """Runs without a solution, with the reason."""
    notes = []
    for row in rows:
        if row.run.failure is not None:
            used = ", ".join(f"{k} {x}" for k, x in row.run.discretization.as_dict().items())
            notes.append(f"{row.group.replace('_', ' ')} ({used}): {row.run.failure}")
    return tuple(notes)
