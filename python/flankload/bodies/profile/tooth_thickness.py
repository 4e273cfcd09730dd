"""Measurements of the tooth thickness: span and dimension over balls (DIN 3960, ISO 21771)."""

from __future__ import annotations

from math import atan, cos, floor, pi, sqrt, tan
from typing import TYPE_CHECKING, NamedTuple

from flankload.base.involute import roll_of_involute_angle

if TYPE_CHECKING:
    from flankload.bodies.profile.involute import Involute


class Measurements(NamedTuple):
    """Measurements of the tooth thickness.

    Attributes
    ----------
    span_mm : float or None
        Span measurement over `span_teeth` teeth; None for internal teeth, and for measuring planes
        that do not touch the flanks between form and tip circle.
    span_teeth : int
    ball_mm : float
        Dimension over two balls, or between them for internal teeth.
    ball_diameter_mm : float
    """

    span_mm: float | None
    span_teeth: int
    ball_mm: float
    ball_diameter_mm: float


def measurements(
    involute: Involute, teeth: int, helix_rad: float = 0.0, span_teeth: int | None = None
) -> Measurements:
    """Span measurement and measurement over balls of a finished gear.

    The involute is that of the transverse section, the helix angle that on the reference cylinder.
    Planes touch near the circle in the middle between form and tip circle, balls near the middle of
    the flank's roll; `span_teeth` is another number of teeth between the planes.
    """
    base, half = involute.base_radius_mm, involute.base_half_angle_rad
    # base helix: tan(b_b) = tan(b) r_b/r
    cosine = cos(atan(tan(helix_rad) * base / involute.reference_radius_mm))
    ends = (involute.form_radius_mm, involute.tip_radius_mm)
    low, high = sorted(involute.roll_at(radius) for radius in ends)
    middle = 0.5 * (low + high)
    span, k = None, 0
    if involute.outward > 0:
        # W_k = 2 r_b cos(b_b) [half + (k - 1) pi/z] touches at the roll W_k cos(b_b)/(2 r_b)
        touched = involute.roll_at(0.5 * sum(ends))
        k = span_teeth or max(1, floor((touched / cosine**2 - half) * teeth / pi + 1.5))
        spanned = half + (k - 1) * pi / teeth
        span = 2 * base * cosine * spanned if low < spanned * cosine**2 < high else None
    diameter, over = _over_balls(involute, teeth, base * cosine, middle)
    return Measurements(span, k, over, diameter)


def _over_balls(
    involute: Involute, teeth: int, normal_base: float, middle: float
) -> tuple[float, float]:
    """Diameter of balls that touch at the roll `middle`, and the dimension over them."""
    half = involute.base_half_angle_rad
    if involute.outward > 0:
        gap = pi / teeth - half
        diameter = 2 * normal_base * (tan(middle + gap) - middle)
    else:
        diameter = 2 * normal_base * (middle - tan(middle - half))
    diameter = float(f"{diameter:.2g}")
    width = 0.5 * diameter / normal_base
    angle = width - gap if involute.outward > 0 else half - width
    roll = roll_of_involute_angle(max(angle, 0.0))
    over = 2 * involute.base_radius_mm * sqrt(1.0 + roll**2)
    if teeth % 2:
        over *= cos(0.5 * pi / teeth)
    return diameter, over + involute.outward * diameter
