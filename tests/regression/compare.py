"""References as files, and the distance of results from them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import flankload as fl

from .cases import Case

REFERENCES = Path(__file__).parent / "references"
#: Two digits more than the finest tolerance that is relative.
DIGITS = 12


@dataclass(frozen=True)
class Movement:
    """Distance of one quantity from its reference.

    Attributes
    ----------
    quantity, unit : str
    moved, allowed : float
        The largest difference of its numbers; infinite where it came, went or changed its shape.
    reference, found : str
        Where it moved most, in words.
    """

    quantity: str
    unit: str
    moved: float
    allowed: float
    reference: str
    found: str

    @property
    def is_drift(self) -> bool:
        """More than allowed."""
        return not self.moved <= self.allowed


def plain(value: Any) -> Any:
    """A word, a whole number, or numbers of so many digits; arrays as flat lists."""
    if isinstance(value, str):
        return value
    array = np.asarray(value)
    if array.ndim > 0:
        return [plain(item) for item in array.ravel().tolist()]
    if isinstance(array.item(), bool | int):
        return int(array.item())
    return float(f"{array.item():.{DIGITS - 1}e}")


def plain_tree(value: Any) -> Any:
    """Inputs in the same manner; lists of lists do not change."""
    if isinstance(value, dict):
        return {key: plain_tree(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain_tree(item) for item in value]
    return value if isinstance(value, bool | None) else plain(value)


def reference_of(name: str, case: Case) -> dict[str, Any]:
    """The content of a reference file, solved now."""
    quantities = {}
    for key, value in case.solve().items():
        about = case.known[key.split(" at ")[0]]
        quantities[key] = {
            "unit": about.unit,
            "rtol": about.rtol,
            "atol": about.atol,
            "reason": about.reason,
            "value": plain(value),
        }
    return {
        "name": name,
        "made_with": f"flankload {fl.__version__}",
        "provenance": case.provenance,
        "inputs": plain_tree(case.inputs),
        "quantities": quantities,
    }


def path_of(name: str) -> Path:
    """Its file."""
    return REFERENCES / f"{name}.json"


def read_reference(name: str) -> dict[str, Any]:
    """A reference as it was written."""
    return dict(json.loads(path_of(name).read_text(encoding="utf-8")))


def write_reference(reference: dict[str, Any]) -> None:
    """A line for each list, so that a change shows which quantity moved."""
    path_of(reference["name"]).write_text(_text(reference, "") + "\n", encoding="utf-8")


def _text(value: Any, indent: str) -> str:
    if not isinstance(value, dict) or not value:
        return json.dumps(value, ensure_ascii=False)
    deeper = indent + " "
    lines = [f"{deeper}{json.dumps(key)}: {_text(item, deeper)}" for key, item in value.items()]
    return "{\n" + ",\n".join(lines) + f"\n{indent}}}"


def movements(reference: dict[str, Any], found: dict[str, Any]) -> list[Movement]:
    """All quantities of both, those of the reference first."""
    before, now = reference["quantities"], found["quantities"]
    moved = []
    for key in [*before, *(key for key in now if key not in before)]:
        about = before.get(key) or now[key]
        if key not in before or key not in now:
            gone, came = "absent", "there"
            words = (came, gone) if key in before else (gone, came)
            moved.append(Movement(key, about["unit"], np.inf, 0.0, *words))
            continue
        moved.append(_movement(key, before[key], now[key]["value"]))
    return moved


def _movement(key: str, before: dict[str, Any], now: Any) -> Movement:
    value, unit = before["value"], before["unit"]
    if isinstance(value, str) or isinstance(now, str):
        return Movement(key, unit, 0.0 if value == now else np.inf, 0.0, str(value), str(now))
    old, new = np.atleast_1d(value).astype(float), np.atleast_1d(now).astype(float)
    if old.shape != new.shape:
        words = (f"{old.size} numbers", f"{new.size} numbers")
        return Movement(key, unit, np.inf, 0.0, *words)
    if old.size == 0:
        return Movement(key, unit, 0.0, 0.0, "", "")
    difference = np.abs(new - old)
    k = int(difference.argmax())
    allowed = before["atol"] + before["rtol"] * float(np.abs(old).max())
    return Movement(key, unit, float(difference[k]), allowed, f"{old[k]:.9g}", f"{new[k]:.9g}")


def table(name: str, rows: list[Movement]) -> str:
    """Quantities that moved, and by how much."""
    lines = [f"{name}:"]
    width = max((len(row.quantity) for row in rows), default=0)
    for row in rows:
        moved = "changed" if np.isinf(row.moved) else f"{row.moved:.2e} {row.unit}"
        lines.append(
            f"  {'!' if row.is_drift else ' '} {row.quantity:<{width}}  moved {moved}, allowed "
            f"{row.allowed:.1e}: {row.reference} -> {row.found}"
        )
    return "\n".join(lines)
