"""What is to be said of a study: what no setting cures, what has no answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.result.accuracy_lines import outside_words
from flankload.studies.accuracy.observed import CORNER

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.scene import Scene
    from flankload.scene.named_discretization import NamedDiscretization
    from flankload.studies.accuracy.study import Row

#: What kinds of bodies bring along.
FROM_FILES = {"mesh": "elements", "compliance": "influence numbers"}


def limit_notes(rows: Sequence[Row]) -> tuple[str, ...]:
    """What no error knows of: premises of the model that the scene breaks."""
    names = sorted({name for row in rows for name in row.run.outside})
    return (f"errors {outside_words(names).removeprefix('; ')}",) if names else ()


def corner_notes(rows: Sequence[Row]) -> tuple[str, ...]:
    """What no setting cures: the pressure on sharp corners, along a ladder of strips."""
    pressures = [
        (row.setting.strips_per_half_width, float(np.max(row.run.values[CORNER], initial=0.0)))
        for row in rows
        if row.run.values is not None
    ]
    carrying = sorted((n, pressure) for n, pressure in pressures if n and pressure > 0)
    if not carrying:
        return ()
    (few, low), (many, high) = carrying[0], carrying[-1]
    note = (
        f"a sharp corner carries: the pressure there, {low:.0f} MPa on {few:g} strips, is "
        f"{high:.0f} MPa on {many:g} and has no limit; no setting cures that, but a tip radius "
        "(tip_radius_mm) or a parabolic relief does"
    )
    return (note,)


def file_notes(scene: Scene) -> tuple[str, ...]:
    """What a study cannot see, since it stands in files."""
    return tuple(
        f"{key}: its {what} come from a file, whose own error is not part of this"
        for key, body in (("body_1", scene.body_1), ("body_2", scene.body_2))
        if (what := FROM_FILES.get(body.kind)) is not None
    )


def failure_notes(rows: Sequence[Row]) -> tuple[str, ...]:
    """Runs without an answer, and why."""
    return tuple(
        f"{row.group.replace('_', ' ')} ({_short(row.setting)}): {row.run.failure}"
        for row in rows
        if row.run.failure is not None
    )


def _short(setting: NamedDiscretization) -> str:
    return ", ".join(f"{key} {value}" for key, value in setting.as_dict().items())
