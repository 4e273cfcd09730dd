"""What matters: more than a quarter of the tolerance; both sides of that, as text that agrees."""

from __future__ import annotations

#: An effect matters where it changes more than this part of the tolerance.
QUARTER = 0.25
#: Digits of a size; where so few would put it on the wrong side, more, up to those of a float.
FEWEST_DIGITS, MOST_DIGITS = 2, 17


def matters(size: float, tolerance: float) -> bool:
    """Whether a change is more than a quarter of the tolerance."""
    return size > QUARTER * tolerance


def quarter_text(tolerance: float) -> str:
    """A quarter of the tolerance with all its digits, not rounded.

    Parameters
    ----------
    tolerance : float

    Returns
    -------
    str
        In %.
    """
    return f"{100 * QUARTER * tolerance:.10g} %"


def against_quarter(size: float, tolerance: float) -> str:
    """A change beside a quarter of the tolerance, in digits enough to see which is more.

    Parameters
    ----------
    size, tolerance : float

    Returns
    -------
    str
    """
    sign = ">" if matters(size, tolerance) else "<="
    for digits in range(FEWEST_DIGITS, MOST_DIGITS):
        shown = f"{100 * size:.{digits}g}"
        if matters(float(shown) / 100, tolerance) == matters(size, tolerance):
            break
    return f"{shown} % {sign} {quarter_text(tolerance)}"
