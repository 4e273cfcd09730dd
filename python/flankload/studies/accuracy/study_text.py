"""The table of a study as text."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from flankload.studies.accuracy.quantities import HEADS, MEANINGS
from flankload.studies.accuracy.refinements import KINKS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flankload.studies.accuracy.study import Row, Study

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
    "combination": "combinations",
}
#: Tolerances for which the cheapest discretization is given.
NAMED = (1e-2, 1e-3, 1e-4)
WIDTH = 40
#: Description of the reference, and of its uncertainty.
LIMIT = "uncertainty of the limit"
#: Replaces seconds if the uncertainty of the limit exceeds the tolerance.
IN_DOUBT = "?"
#: Column heading of the seconds of a step with the other parameters at their default.
DEFAULT_SECONDS = "default"


def text_of(study: Study) -> str:
    """Tables of parameter steps, contact models and combinations; the cheapest discretizations.

    Parameters
    ----------
    study : Study

    Returns
    -------
    str
    """
    return "\n".join(_lines(study))


def _lines(study: Study) -> Iterator[str]:
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


def _ladder(study: Study, parameter: str, words: str, names: Sequence[str]) -> Iterator[str]:
    """Errors against the limit of this parameter, the others at their finest; coarse first."""
    yield _head(f"{words} (others finest)", names, DEFAULT_SECONDS)
    steps = study.steps[parameter]
    adaptive = [row for row in steps if row.run.discretization.adaptive is not None]
    for row in (*(row for row in reversed(steps) if row not in adaptive), *adaptive):
        used = row.run.discretization
        label = f"{getattr(used, parameter):g}{' (finest)' * (row.group == 'finest')}"
        if used.adaptive is not None:
            label = f"adaptive from {used.count}, to {used.adaptive:g}"
        seconds = study.seconds_at_default(row, parameter)
        beside = "-" if seconds is None else f"{seconds:.3f}"
        yield _row(label, row, row.alone, names, beside)
    yield from _orders(study, parameter)
    yield ""


def _orders(study: Study, parameter: str) -> Iterator[str]:
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


def _others(study: Study, names: Sequence[str]) -> Iterator[str]:
    for group, words in GROUPS.items():
        rows = [row for row in study.rows if row.group == group and row.run.failure is None]
        if group == "combination":
            rows = [row for row in study.front() if row.group == group]
            words = "combinations on the Pareto front"
        if not rows:
            continue
        yield _head(words, names)
        for row in rows:
            yield _row(_label(row), row, row.errors, names)
        if group == "finest":
            cells = "".join(f"{_percent(study.doubts.get(name)):>10s}" for name in names)
            yield f"  {LIMIT:{WIDTH - 2}s}{'':15s}{cells}"
        yield ""


def _label(row: Row) -> str:
    discretization = row.run.discretization
    if discretization.as_it_stands:
        return "all parameters as in the scene"
    parts = []
    if discretization.level == "nodes" and discretization.flank_element_mm is None:
        parts.append("nodes by the contact's width")
    if discretization.flank_element_mm is not None:
        parts.append(f"{discretization.flank_element_mm:g} mm")
    if discretization.modes is not None:
        parts.append(f"{discretization.modes} m")
    if discretization.strips_per_half_width is not None:
        parts.append(f"{discretization.strips_per_half_width:g} s")
    if discretization.zone_half_widths is not None:
        parts.append(f"{discretization.zone_half_widths:g} z")
    if discretization.axial_degree is not None:
        parts.append(f"{discretization.axial_degree}/{discretization.load_degree_z} deg")
    if discretization.slices is not None:
        parts.append(f"{discretization.slices} sl")
    if discretization.count is not None:
        even = discretization.adaptive is None
        parts.append(
            f"{discretization.count} p"
            if even
            else f"{discretization.count} p to {discretization.adaptive:g}"
        )
    return ", ".join(parts)


def _head(words: str, names: Sequence[str], further: str | None = None) -> str:
    columns = "".join(f"{HEADS[name]:>10s}" for name in names)
    beside = "" if further is None else f"{further:>10s}"
    return f"{words:{WIDTH}s}{'CPU s':>8s}{beside}{'MB':>7s}{columns}"


def _row(
    label: str,
    row: Row,
    errors: Mapping[str, float],
    names: Sequence[str],
    further: str | None = None,
) -> str:
    if row.run.failure is not None:
        return f"  {label:{WIDTH - 2}s}no answer"
    cells = "".join(f"{_percent(errors.get(name)):>10s}" for name in names)
    beside = "" if further is None else f"{further:>10s}"
    memory = row.run.memory_bytes / 1e6
    return f"  {label:{WIDTH - 2}s}{row.run.cpu_s:8.3f}{beside}{memory:7.1f}{cells}"


def _percent(error: float | None) -> str:
    if error is None:
        return "-"
    return "0" if error == 0 else f"{100 * error:.2g}"


def _cheapest(study: Study, names: Sequence[str]) -> Iterator[str]:
    yield "CPU seconds of the cheapest discretization"
    columns = "".join(f"{HEADS[name]:>10s}" for name in names)
    yield f"  {'to':8s}{columns}{'all':>12s}"
    for tolerance in NAMED:
        texts = [_seconds(study, tolerance, name) for name in names]
        texts.append(_seconds(study, tolerance))
        inner = "".join(f"{text:>10s}" for text in texts[:-1])
        yield f"  {100 * tolerance:g} %".ljust(10) + f"{inner}{texts[-1]:>12s}"
    for tolerance in NAMED:
        row = study.cheapest(tolerance)
        if row is None:
            yield f"{100 * tolerance:g} %: {_why_none(study, tolerance)}"
            continue
        yield f"{100 * tolerance:g} %: {row.run.cpu_s:.3f} CPU s"
        lines = row.run.discretization.lines() or "scene as given"
        yield from (f"    {line}" for line in lines.splitlines())


def _seconds(study: Study, tolerance: float, *names: str) -> str:
    row = study.cheapest(tolerance, *names)
    if row is not None:
        return f"{row.run.cpu_s:.3f}"
    return IN_DOUBT if _is_in_doubt(study, tolerance, *names) else "none"


def _is_in_doubt(study: Study, tolerance: float, *names: str) -> bool:
    doubt = study.doubt(*names)
    return doubt is not None and doubt > tolerance


def _why_none(study: Study, tolerance: float) -> str:
    if not _is_in_doubt(study, tolerance):
        return "not reached by any run"
    worst = max(
        (name for name in study.measures if name in study.doubts), key=study.doubts.__getitem__
    )
    doubt = study.doubts[worst]
    size = f"{_percent(doubt)} % ({HEADS[worst]})" if isfinite(doubt) else "unknown"
    return f"not reached ({IN_DOUBT}): the uncertainty of the limit is {size}"
