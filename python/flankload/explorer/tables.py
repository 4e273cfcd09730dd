"""Texts of the page: status, key figures beside the pinned design, names of keys."""

from __future__ import annotations

from html import escape
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from flankload.plot.study_table import unit_of, words
from flankload.report.key_figures import key_rows, percent

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.explorer.keys import Key
    from flankload.explorer.worker import Answer
    from flankload.result import Result
    from flankload.studies.sensitivity import Sensitivity

#: Figures to choose from: entries of `Result.summary`.
FIGURES = (
    *("transmission_error_peak_to_peak_um", "transmission_error_mean_um", "peak_pressure_MPa"),
    *("peak_line_load_N_per_mm", "face_load_factor", "load_share_max", "contact_ratio_under_load"),
    "stiffness_secant_mean_N_per_um",
)
#: Figures that need several positions, and those that need a width of the contact.
OF_SEVERAL = ("transmission_error_peak_to_peak_um", "contact_ratio_under_load")
OF_WIDTH = ("peak_pressure_MPa", "peak_line_load_N_per_mm")
#: Change of a key by which its importance is measured, as part of its slider.
CHANGE = 0.1


def number_of(result: Result, figure: str) -> float | None:
    """A figure of a result; None if it has none."""
    value = result.summary.get(figure)
    return value if isinstance(value, int | float) and isfinite(value) else None


def label_of(figure: str) -> str:
    """A figure in words, with its unit."""
    return f"{words(figure)}, {unit_of(figure)}".rstrip(", ")


def choices(result: Result) -> list[tuple[str, str]]:
    """Names and words of the figures that a result has."""
    absent = (*OF_SEVERAL * (result.position_rad.size == 1),
              *OF_WIDTH * (not result.engagement.has_pressures))  # fmt: skip
    known = (name for name in FIGURES if name not in absent and number_of(result, name))
    return [(name, label_of(name)) for name in known]


def status(answer: Answer) -> str:
    """Error and milliseconds of an answer, or the line why there is none."""
    if answer.error:
        return f'<span class="line broken">{escape(answer.error)}</span>'
    result = answer.result
    assert result is not None
    count = result.position_rad.size
    text = f"{1e3 * answer.seconds:.0f} ms, {count} position{'s' * (count > 1)}"
    if not answer.at_rest:
        return f"{text}, no error estimate while a key moves"
    estimate = (result.estimate or {}).items()
    errors = {name: x for name, x in estimate if isinstance(x, float) and isfinite(x)}
    if errors:
        worst = max(errors, key=errors.__getitem__)
        text += f", estimated error up to {percent(errors[worst])} ({words(worst)})"
    if result.status.any():
        text += f", {np.count_nonzero(result.status)} positions with a status"
    if result.warnings:
        title = escape("\n".join(result.warnings), quote=True)
        text += f', <span title="{title}">notes: {len(result.warnings)}</span>'
    return text


def figures(result: Result | None, pinned: Result | None) -> str:
    """Table of the key figures, with their differences to those of the pinned design."""
    if result is None:
        return ""
    rows, before = (
        {} if one is None else {row.name: row for row in key_rows([one])}
        for one in (result, pinned)
    )
    lines = ["<tr><th></th><th></th><th>error</th><th>change</th></tr>"]
    for name in dict.fromkeys([*before, *rows]):
        text, error, change = "…", "", ""
        if name in rows and (cell := rows[name].cells[0]) is not None:
            text, error = f"{cell.text} {rows[name].unit}", percent(cell.error)
            old = before[name].cells[0] if name in before else None
            if isinstance(cell.value, float) and old and isinstance(old.value, float) and old.value:
                part = 100.0 * (cell.value - old.value) / abs(old.value)
                change = f"{part:+.1f} %" if abs(part) >= 0.05 else "="
        cells = "".join(f"<td>{escape(part)}</td>" for part in (name, text, error, change))
        lines.append(f"<tr>{cells}</tr>")
    return f"<table>{''.join(lines)}</table>"


def key_name(key: Key, effect: tuple[str, float], *, reaching: bool) -> str:
    """Name of a key; its meaning on hover; the change of a figure that it causes."""
    title = escape(f"{key.path}: {key.meaning}", quote=True)
    text, width = effect
    return (
        f'<div class="name" title="{title}">'
        f"<span>{escape(key.name)}{' · on release' * reaching}</span>"
        f'<span class="small">{escape(text)}</span></div>'
        f'<div class="bar"><i style="width:{width:.0f}%"></i></div>'
    )


def effects(
    keys: Mapping[str, Key], figure: str, found: Sensitivity | None
) -> dict[str, tuple[str, float]]:
    """Change of a figure over a part of each slider in words, and its size, % of the largest."""
    if found is None or not figure:
        return {}
    spans = {path: CHANGE * (keys[path].high - keys[path].low) for path in found.paths}
    slopes = zip(found.paths, found.derivative(figure)[:, -1].tolist(), strict=True)
    known = {path: slope * spans[path] for path, slope in slopes if isfinite(slope)}
    most = max(map(abs, known.values()), default=0.0) or 1.0
    return {
        path: (
            f"{change:+.2g} {unit_of(figure)} per {spans[path]:.3g} {unit_of(path)}",
            100.0 * abs(change) / most,
        )
        for path, change in known.items()
    }
