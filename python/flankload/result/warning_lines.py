"""Warnings of several torques without repetition."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.result.result import Result

#: Separate numbers, not those in a name such as body_1.
NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d+)?(e[-+]?\d+)?")


def warning_lines(results: Sequence[Result]) -> list[str]:
    """Warnings of the results of a scene, without repetition.

    Parameters
    ----------
    results : sequence of Result
        One per torque.

    Returns
    -------
    list of str
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
