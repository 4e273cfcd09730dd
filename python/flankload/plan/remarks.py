"""Sentences on what a run leaves out and is likely to matter."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flankload.plan.planned import PlannedEffect
    from flankload.scene.effects import Effect

#: Less of the load share is not worth a word.
LEAST_SHARE = 1e-4


def remarked(row: PlannedEffect, effect: Effect) -> PlannedEffect:
    """A row with a sentence, of an effect that is left out or is an error.

    Parameters
    ----------
    row : PlannedEffect
        With a size.
    effect : Effect
        Its row in the table of effects.

    Returns
    -------
    PlannedEffect
    """
    size = row.size
    assert size is not None
    change = f"{_hundredths(size.rotation_largest)} % of the rotation at a position"
    if size.rotation_largest is None:
        change = f"{size.rotation_um:.2g} um of the transmission error"
    if size.load_share > LEAST_SHARE:
        change += f" and {_hundredths(size.load_share)} points of the load share"
    if effect.coarser:
        return replace(row, remark=f"{row.title} is on ({row.because}): that changes {change}")
    off = f"{row.title} is off ({row.because})"
    if row.assumed is not None:
        return replace(row, remark=f"{off}: with {row.assumed} it would change {change}")
    return replace(row, remark=f"{off} and likely to matter: it changes {change}")


def _hundredths(part: float | None) -> str:
    """Two digits, no exponent."""
    return f"{float(f'{100 * (part or 0.0):.2g}'):g}"
