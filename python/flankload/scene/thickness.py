"""Tooth thickness: its keys and their rules, and the generating profile shift (ISO 21771).

A tool shift cuts a deviation of the thickness: the generating profile shift x_E replaces the
nominal one in the thickness and in the depth of the root.
"""

from math import acos, atan, cos, pi, radians, sin, tan
from typing import TYPE_CHECKING, Annotated, ClassVar, NamedTuple

from msgspec import Meta

from flankload.base.involute import involute_function
from flankload.errors import SceneError
from flankload.scene.refusal import refuse, refuse_absent
from flankload.scene.table import (
    MOST_TEETH,
    USUAL_MODIFICATION,
    USUAL_SIZE,
    Deviation,
    Length,
    Table,
    about,
)

if TYPE_CHECKING:
    from flankload.scene.involute import InvoluteKeys

#: Measurements of the tooth thickness, with the key that each requires.
MEASURED = {"span_measurement_mm": "span_teeth", "ball_measurement_mm": "measuring_ball_mm"}
#: Largest |x_E|; a measurement with a larger one belongs to another gear.
LARGEST_SHIFT = 5.0


class ThicknessKeys(Table, frozen=True, kw_only=True):
    """Keys of the tooth thickness, in the normal section; at most one measurement."""

    grouped: ClassVar[bool] = True

    tooth_thickness_allowance_um: Annotated[
        Deviation | None,
        about(
            "deviation of the tooth thickness on the reference circle from that of the profile "
            "shift, in the normal section (E_sn); negative = thinner teeth; the root is cut "
            "deeper accordingly",
            "um",
            usual=USUAL_MODIFICATION,
        ),
    ] = None
    span_measurement_mm: Annotated[
        Length | None,
        about(
            "span measurement W_k of the finished teeth, in place of the allowance; requires "
            "span_teeth",
            "mm",
            usual=USUAL_SIZE,
        ),
    ] = None
    span_teeth: Annotated[
        Annotated[int, Meta(ge=1, le=MOST_TEETH)] | None, about("number of teeth spanned, k", "-")
    ] = None
    ball_measurement_mm: Annotated[
        Length | None,
        about(
            "dimension over two balls, or between them for internal teeth (M_dK), in place of the "
            "allowance; requires measuring_ball_mm",
            "mm",
            usual=USUAL_SIZE,
        ),
    ] = None
    measuring_ball_mm: Annotated[
        Length | None, about("diameter of the balls", "mm", usual=(0.1, 200.0))
    ] = None


def check_thickness(body: ThicknessKeys, key: str, *, inwards: bool) -> None:
    """Check that there is at most one key of the thickness, with the key that it requires."""
    keys = ("tooth_thickness_allowance_um", *MEASURED)
    named = [name for name in keys if getattr(body, name) is not None]
    if len(named) > 1:
        expected = f"nothing beside {key}.{named[0]}, which gives the tooth thickness as well"
        refuse(f"{key}.{named[1]}", expected, getattr(body, named[1]))
    for name, beside in MEASURED.items():
        value, other = getattr(body, name), getattr(body, beside)
        if value is not None and other is None:
            refuse_absent(key, beside, "a number", name)
        if value is None and other is not None:
            refuse_absent(key, name, "a number", beside)
    if inwards and body.span_measurement_mm is not None:
        expected = "nothing for internal teeth (ball_measurement_mm instead)"
        refuse(f"{key}.span_measurement_mm", expected, body.span_measurement_mm)


class Teeth(NamedTuple):
    """Number of teeth and basic rack; outward: -1 for internal teeth."""

    teeth: int
    module_mm: float
    normal_angle: float
    helix_rad: float
    outward: int

    @property
    def transverse_angle(self) -> float:
        """Pressure angle in the transverse section, rad."""
        return atan(tan(self.normal_angle) / cos(self.helix_rad))

    @property
    def reference_radius_mm(self) -> float:
        """Radius of the reference circle, mm."""
        return 0.5 * self.teeth * self.module_mm / cos(self.helix_rad)

    @property
    def base_radius_mm(self) -> float:
        """Radius of the base circle, mm."""
        return self.reference_radius_mm * cos(self.transverse_angle)

    @property
    def base_helix_rad(self) -> float:
        """Helix angle on the base cylinder, rad: tan(b_b) = tan(b) r_b/r."""
        return atan(tan(self.helix_rad) * cos(self.transverse_angle))

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


def generating_shift(spec: "InvoluteKeys", teeth: int, key: str, *, outward: int = 1) -> float:
    """Generating profile shift x_E of a gear; the nominal one without a key of the thickness.

    `key` is the dotted path of the keys in the scene; `outward` is -1 for internal teeth, whose
    positive profile shift widens the space.

    Raises
    ------
    SceneError
        If no gear with these teeth and this module has the measurement.
    """
    gear = Teeth(teeth, spec.module_mm, radians(spec.pressure_angle_deg), spec.helix_rad, outward)
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


def _shift_of_span(gear: Teeth, span: float, k: int) -> float:
    """W_k = m cos(a_n) [(k - 1/2) pi + z inv(a_t)] + 2 x m sin(a_n), solved for x."""
    flat = (k - 0.5) * pi + gear.teeth * involute_function(gear.transverse_angle)
    rest = span - gear.module_mm * cos(gear.normal_angle) * flat
    return rest / (2 * gear.module_mm * sin(gear.normal_angle))


def _shift_over_balls(gear: Teeth, measured: float, ball: float) -> float | None:
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
