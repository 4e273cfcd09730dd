"""Tooth thickness: allowance, span measurement and measurement over balls (DIN 3960, ISO 21771).

A tool shift cuts a deviation of the thickness: the generating profile shift x_E replaces the
nominal one in the thickness and in the depth of the root.
"""

from __future__ import annotations

from math import acos, atan, cos, floor, pi, radians, sin, sqrt, tan
from typing import TYPE_CHECKING, NamedTuple

from flankload.base.involute import involute_function, roll_of_involute_angle
from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.bodies.profile.involute import Involute
    from flankload.scene.involute import InvoluteKeys

#: Largest |x_E|; a measurement with a larger one belongs to another gear.
LARGEST_SHIFT = 5.0


class _Gear(NamedTuple):
    """Number of teeth and basic rack; outward: -1 for internal teeth."""

    teeth: int
    module_mm: float
    normal_angle: float
    helix_rad: float
    outward: int

    @property
    def transverse_angle(self) -> float:
        return atan(tan(self.normal_angle) / cos(self.helix_rad))

    @property
    def base_radius_mm(self) -> float:
        radius = 0.5 * self.teeth * self.module_mm / cos(self.helix_rad)
        return radius * cos(self.transverse_angle)

    @property
    def normal_base(self) -> float:
        """z m_n cos(alpha_n): twice the base radius times the cosine of the base helix angle."""
        return self.teeth * self.module_mm * cos(self.normal_angle)

    def base_half_angle(self, shift: float) -> float:
        """Half the angle at the base circle of a tooth, or of a space between internal teeth."""
        own = (0.5 * pi + 2 * shift * tan(self.normal_angle)) / self.teeth
        return own + involute_function(self.transverse_angle)

    def shift_of(self, base_half_angle: float) -> float:
        """Inverse of `base_half_angle`."""
        own = base_half_angle - involute_function(self.transverse_angle)
        return (own * self.teeth - 0.5 * pi) / (2 * tan(self.normal_angle))


def generating_shift(spec: InvoluteKeys, teeth: int, key: str, *, outward: int = 1) -> float:
    """Generating profile shift x_E of a gear; the nominal one without a key of the thickness.

    `key` is the dotted path of the keys in the scene; `outward` is -1 for internal teeth, whose
    positive profile shift widens the space.

    Raises
    ------
    SceneError
        If no gear with these teeth and this module has the measurement.
    """
    gear = _Gear(teeth, spec.module_mm, radians(spec.pressure_angle_deg), spec.helix_rad, outward)
    if spec.tooth_thickness_allowance_um is not None:
        allowance = spec.tooth_thickness_allowance_um / 1000.0
        # x_E = x + E_sn/(2 m_n tan alpha_n) (DIN 3960)
        return spec.profile_shift + outward * allowance / (
            2 * spec.module_mm * tan(gear.normal_angle)
        )
    shift: float | None
    if spec.span_measurement_mm is not None:
        name, value = "span_measurement_mm", spec.span_measurement_mm
        shift = _shift_of_span(gear, value, spec.span_teeth or 1)
    elif spec.ball_measurement_mm is not None:
        name, value = "ball_measurement_mm", spec.ball_measurement_mm
        shift = _shift_over_balls(gear, value, spec.measuring_ball_mm or 0.0)
    else:
        return spec.profile_shift
    if shift is None or abs(shift) > LARGEST_SHIFT:
        raise SceneError(
            key=f"{key}.{name}",
            expected=f"a measurement of a gear with a profile shift from {-LARGEST_SHIFT:g} to "
            f"{LARGEST_SHIFT:g}",
            found=f"{value:g}" + ("" if shift is None else f", of the profile shift {shift:.4f}"),
        )
    return shift


def _shift_of_span(gear: _Gear, span: float, k: int) -> float:
    """W_k = m cos(a_n) [(k - 1/2) pi + z inv(a_t)] + 2 x m sin(a_n), solved for x."""
    flat = (k - 0.5) * pi + gear.teeth * involute_function(gear.transverse_angle)
    rest = span - gear.module_mm * cos(gear.normal_angle) * flat
    return rest / (2 * gear.module_mm * sin(gear.normal_angle))


def _shift_over_balls(gear: _Gear, measured: float, ball: float) -> float | None:
    """Profile shift from the dimension over, or between, two balls."""
    distance = measured - gear.outward * ball
    if gear.teeth % 2:
        distance /= cos(0.5 * pi / gear.teeth)
    cosine = 2 * gear.base_radius_mm / distance if distance > 0 else 2.0
    if cosine > 1.0:
        return None
    # inv(a_K) = D/(z m cos a_n) - (pi/z - half), or half - D/(z m cos a_n) between internal teeth
    angle, width = involute_function(acos(cosine)), ball / gear.normal_base
    half = angle + width if gear.outward < 0 else angle - width + pi / gear.teeth
    return gear.shift_of(half)


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
