"""Numbers in texts."""

from __future__ import annotations

from flankload.base.rounding import TIE


def number_of(text: str) -> float:
    """A number from its digits 0 to 9; Python also reads "5_0" and the digits of other scripts.

    Raises ValueError if the text is not a number; infinity and NaN are left to the caller.
    """
    if "_" in text or not text.isascii():
        raise ValueError(f"no number: {text!r}")
    return float(text)


def percent(part: float) -> str:
    """Percentage with two digits, without an exponent; a part that is rounding is 0 %."""
    return f"{float(f'{100 * part:.2g}') if abs(part) > TIE else 0:g} %"


def error_of(value: float, part: float, unit: str) -> str:
    """Relative error `part` as a percentage; in the unit of the value if it exceeds the value."""
    return percent(part) if part <= 1.0 else f"{float(f'{part * abs(value):.2g}'):g} {unit}"
