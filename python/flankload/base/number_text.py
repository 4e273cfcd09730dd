"""Numbers in text files."""

from __future__ import annotations


def number_of(text: str) -> float:
    """A number from its digits 0 to 9; Python also reads "5_0" and the digits of other scripts.

    Raises ValueError if the text is no number; infinity and NaN are left to the caller.
    """
    if "_" in text or not text.isascii():
        raise ValueError(f"no number: {text!r}")
    return float(text)
