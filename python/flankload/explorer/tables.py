"""Texts of the page: status, key figures beside the pinned design, names of keys."""

from __future__ import annotations

from html import escape
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from flankload.report.key_figures import key_rows, percent

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.explorer.keys import Key
    from flankload.explorer.worker import Answer
    from flankload.result import Result
    from flankload.studies.sensitivity import Sensitivity

#: Figures to choose from: entries of `Result.summary` with their words and units.
FIGURES = {
    "transmission_error_peak_to_peak_um": ("transmission error, peak to peak", "µm"),
    "transmission_error_mean_um": ("transmission error, mean", "µm"),
    "peak_pressure_MPa": ("largest pressure", "MPa"),
    "peak_line_load_N_per_mm": ("largest line load", "N/mm"),
    "face_load_factor": ("face load factor", ""),
    "load_share_max": ("largest share of the force", ""),
    "contact_ratio_under_load": ("contact ratio under load", ""),
    "stiffness_secant_mean_N_per_um": ("mesh stiffness, secant, mean", "N/µm"),
}
#: Figures that need several positions.
OF_SEVERAL = ("transmission_error_peak_to_peak_um", "contact_ratio_under_load")
#: Units as on paper, by those of the schema.
PRINTED = {"um": "µm", "um/mm": "µm/mm", "deg": "°", "-": "", "N m": "N m"}
#: Change of a key by which its importance is measured, as part of its slider.
CHANGE = 0.1


def number_of(result: Result, figure: str) -> float | None:
    """A figure of a result; None if it has none."""
    value = result.summary.get(figure)
    return value if isinstance(value, int | float) and isfinite(value) else None


def choices(result: Result) -> list[tuple[str, str]]:
    """Names and words of the figures that a result has."""
    several = result.position_rad.size > 1
    return [
        (name, f"{words}, {unit}" if unit else words)
        for name, (words, unit) in FIGURES.items()
        if (several or name not in OF_SEVERAL) and number_of(result, name)
    ]


def status(answer: Answer) -> str:
    """Error and milliseconds of an answer, or the line why there is none."""
    if answer.error:
        return f'<span class="line broken">{escape(answer.error)}</span>'
    result = answer.result
    assert result is not None
    text = f"{1e3 * answer.seconds:.0f} ms, {result.position_rad.size} positions"
    if not answer.at_rest:
        return f"{text}, no error estimate while a key moves"
    errors = [x for x in (result.estimate or {}).values() if isinstance(x, float) and isfinite(x)]
    if errors:
        text += f", estimated error up to {percent(max(errors))}"
    if result.status.any():
        text += f", {np.count_nonzero(result.status)} positions with a status"
    if result.warnings:
        title = escape("\n".join(result.warnings), quote=True)
        text += f', <span title="{title}">{len(result.warnings)} notes</span>'
    return text


def figures(result: Result | None, pinned: Result | None) -> str:
    """Table of the key figures, with their differences to those of the pinned design."""
    if result is None:
        return ""
    rows = {row.name: row for row in key_rows([result])}
    before = {} if pinned is None else {row.name: row for row in key_rows([pinned])}
    lines = ["<tr><th></th><th></th><th>error</th><th>change</th></tr>"]
    for name in dict.fromkeys([*before, *rows]):
        row = rows.get(name)
        if row is None or row.cells[0] is None:
            lines.append(f"<tr><td>{escape(name)}</td><td>…</td><td></td><td></td></tr>")
            continue
        cell = row.cells[0]
        old = before[name].cells[0] if name in before else None
        numbers = isinstance(cell.value, float) and old and isinstance(old.value, float)
        change = ""
        if numbers and old and old.value:
            part = 100.0 * (float(cell.value) - float(old.value)) / abs(float(old.value))
            change = f"{part:+.1f} %" if abs(part) >= 0.05 else "="
        lines.append(
            f"<tr><td>{escape(name)}</td><td>{escape(cell.text)} {escape(row.unit)}</td>"
            f"<td>{percent(cell.error)}</td><td>{change}</td></tr>"
        )
    return f"<table>{''.join(lines)}</table>"


def key_name(key: Key, effect: tuple[str, float], *, reaching: bool) -> str:
    """Name and unit of a key; its meaning on hover; the change of a figure that it causes."""
    unit = PRINTED.get(key.unit, key.unit)
    title = escape(f"{key.path}: {key.meaning}", quote=True)
    words = f"{escape(key.name)}{f', {unit}' if unit else ''}{' · on release' if reaching else ''}"
    text, width = effect
    return (
        f'<div class="name" title="{title}"><span>{words}</span>'
        f'<span class="small">{escape(text)}</span></div>'
        f'<div class="bar"><i style="width:{width:.0f}%"></i></div>'
    )


def effects(
    keys: Mapping[str, Key], figure: str, found: Sensitivity | None
) -> dict[str, tuple[str, float]]:
    """Change of a figure over a part of each slider in words, and its size, % of the largest."""
    if found is None or figure not in FIGURES:
        return {}
    slopes = found.derivative(figure)[:, -1]
    spans = {path: CHANGE * (keys[path].high - keys[path].low) for path in found.paths}
    changes = {
        path: float(slope) * spans[path] for path, slope in zip(found.paths, slopes, strict=True)
    }
    known = {path: change for path, change in changes.items() if isfinite(change)}
    most = max(map(abs, known.values()), default=0.0) or 1.0
    words = {}
    for path, change in known.items():
        unit = PRINTED.get(keys[path].unit, keys[path].unit)
        text = f"{change:+.2g} {FIGURES[figure][1]} per {spans[path]:.3g} {unit}"
        words[path] = (text, 100.0 * abs(change) / most)
    return words
