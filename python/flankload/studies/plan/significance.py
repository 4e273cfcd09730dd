"""Significant effects: those that change more than a quarter of the tolerance."""

from __future__ import annotations

#: Part of the tolerance beyond which a change is significant.
SIGNIFICANT_PART = 0.25
#: Digits of a size; more digits if rounding would move it across the threshold.
FEWEST_DIGITS, MOST_DIGITS = 2, 17


def is_significant(size: float, tolerance: float) -> bool:
    """Whether a change is more than a quarter of the tolerance."""
    return size > SIGNIFICANT_PART * tolerance


def threshold_text(tolerance: float) -> str:
    """A quarter of the tolerance in %, with all its digits."""
    return f"{100 * SIGNIFICANT_PART * tolerance:.10g} %"


def against_threshold(size: float, tolerance: float) -> str:
    """A change and a quarter of the tolerance, with enough digits to compare them."""
    sign = ">" if is_significant(size, tolerance) else "<="
    for digits in range(FEWEST_DIGITS, MOST_DIGITS):
        shown = f"{100 * size:.{digits}g}"
        if is_significant(float(shown) / 100, tolerance) == is_significant(size, tolerance):
            break
    return f"{shown} % {sign} {threshold_text(tolerance)}"
