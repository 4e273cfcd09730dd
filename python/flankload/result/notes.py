"""Lines of text about warnings, violated premises and the report on a tolerance."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from flankload.base.number_text import percent

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flankload.result.result import Result

#: Separate numbers, not those in a name such as body_1.
NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d+)?(e[-+]?\d+)?")
#: Error bound relative to the largest transmission error, for estimates given as part of it.
PEAK_TO_PEAK = "transmission_error_peak_to_peak"
#: Prefix of results that violate a premise.
OUTSIDE = "outside the model's limits"


def warning_lines(results: Sequence[Result]) -> list[str]:
    """Warnings of the results of a scene, one per torque, without repetition.

    Warnings that differ only in their numbers are merged, in the words of the largest torque; a
    warning that does not apply to all torques names its torques.
    """
    groups: dict[str, dict[float, str]] = {}
    for result in results:
        for text in result.warnings:
            groups.setdefault(NUMBER.sub("#", text), {})[result.torque_Nm] = text
    return [_line(said, len(results)) for said in groups.values()]


def _line(said: dict[float, str], torques: int) -> str:
    largest = max(said)
    if len(said) == torques and len(set(said.values())) == 1:
        return said[largest]
    others = ", ".join(f"{torque:g}" for torque in sorted(said) if torque != largest)
    alike = f"; similar under {others} N m" if others else ""
    return f"{said[largest]} [under {largest:g} N m{alike}]"


def outside_words(names: Sequence[str]) -> str:
    """Words that accompany an error estimate if premises (`Result.outside_limits`) are violated."""
    listed = ", ".join(name.replace("_", " ") for name in names)
    return f"; {OUTSIDE} ({listed})" if names else ""


def accuracy_lines(found: Mapping[str, Any]) -> list[str]:
    """Verdict, discretization, changes of it, and missed limits, of `Result.accuracy`."""
    lines = [f"{percent(found['tolerance'])}: {_verdict(found)}"]
    words = ", ".join(_words(key, row) for key, row in found["knobs"].items())
    if words:
        lines.append(words)
    if found["tightened"]:
        steps = ", ".join(
            f"{key} {_number(one)} -> {_number(two)}"
            for key, (one, two) in found["tightened"].items()
        )
        lines.append(f"refined: {steps}")
    itself, bound = found["peak_to_peak_of_itself"], found["errors"].get(PEAK_TO_PEAK)
    if bound is not None and itself is not None and bound < itself > found["tolerance"]:
        lines.append(
            f"peak to peak {percent(itself)} of itself is {percent(bound)} of the largest "
            "transmission error, to which the tolerance refers"
        )
    lines += [
        f"not certain: {one['quantity'].replace('_', ' ')}: {one['why']}"
        for one in found["uncertain"]
    ]
    lines += [
        f"exceeded: {one['quantity'].replace('_', ' ')} {percent(one['error'])}, mostly from "
        f"{one['source']}{_beside(one['beside'])}: {one['why']}"
        for one in found["missed"]
    ]
    return lines


def _beside(sources: Sequence[str]) -> str:
    """Further sources that miss the tolerance by themselves."""
    if not sources:
        return ""
    exceed = "exceeds" if len(sources) == 1 else "each exceed"
    return f" ({' and '.join(sources)} alone also {exceed} the tolerance)"


def _verdict(found: Mapping[str, Any]) -> str:
    if not found["errors"]:
        return str(found["unchecked"])
    errors, state = dict(found["errors"]), "met" if found["met"] else "not met"
    if found["met"] is None:
        unknown = [one["quantity"] for one in found["uncertain"]]
        errors = {name: error for name, error in errors.items() if name not in unknown}
        state = f"not certain ({', '.join(unknown).replace('_', ' ')}), all else met"
    largest = max(errors, key=lambda name: errors[name])
    return f"{state}, {largest.replace('_', ' ')} {percent(errors[largest])} at most"


def _number(value: float | None) -> str:
    """Number as text; None is the default."""
    return "default" if value is None else f"{value:g}"


def _words(key: str, row: Mapping[str, Any]) -> str:
    value = row["value"]
    text = f"{key} {value:g}" if isinstance(value, float) else f"{key} {value}"
    if row["error"] is None:
        return text
    return f"{text} ({row['source']} {percent(row['error'])})"
