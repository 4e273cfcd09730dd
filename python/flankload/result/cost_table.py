"""Cost of a run as text: stage by stage, beside the prediction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flankload.base.text_table import NONE, text_table
from flankload.cost import COUNTERS

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

HEAD = ("stage", "work", "predicted", "spent")
#: Entries of an account beside its counters: key, name, and number of units in one of the
#: account's.
MEASURES = (
    ("cpu_s", "CPU s", 1.0),
    ("wall_s", "wall s", 1.0),
    ("bytes", "MB held", 1e-6),
    ("workspace_bytes", "MB workspace", 1e-6),
)


def cost_table(cost: Mapping[str, Any]) -> str:
    """Return a row for each quantity that a stage was predicted to use, or used.

    Parameters
    ----------
    cost : mapping
        Cost of a result.

    Returns
    -------
    str
        Lines without a final line break.
    """
    rows = (row for item in cost["stages"].items() for row in _rows(*item))
    return "\n".join(text_table([HEAD, *rows], left=2))


def _rows(name: str, stage: Mapping[str, Any]) -> Iterator[tuple[str, str, str, str]]:
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
