"""Keys of involute profiles (basic rack, tooth thickness, tip, reliefs) and their rules."""

from collections.abc import Mapping, Sequence
from math import atan, cos, pi, radians, tan
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene.refusal import refuse, refuse_absent
from flankload.scene.table import (
    MOST_TEETH,
    PER_MODULE,
    USUAL_MODIFICATION,
    USUAL_ROUNDING,
    USUAL_SIZE,
    Deviation,
    Length,
    Relief,
    ReliefShape,
    Shift,
    Table,
    about,
)

#: Largest pitch error over base pitch; larger ones could change the order of the teeth.
LARGEST_PITCH_ERROR = 0.1


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


class InvoluteKeys(ThicknessKeys, frozen=True, kw_only=True):
    """Keys of an involute profile without its root."""

    module_mm: Annotated[Length, about("module", "mm", usual=(0.02, 100.0))]
    pressure_angle_deg: Annotated[
        float, Meta(ge=5, le=45), about("pressure angle of the basic rack", "deg")
    ] = 20.0
    profile_shift: Annotated[Shift, about("profile shift in modules", "-")] = 0.0
    tip_diameter_mm: Annotated[Length, about("diameter of the tip circle", "mm", usual=USUAL_SIZE)]
    tip_relief_um: Annotated[
        Relief | None,
        about(
            "tip relief at the tip circle, normal to the involute",
            "um",
            usual=USUAL_MODIFICATION,
            per=PER_MODULE,
        ),
    ] = None
    tip_relief_start_diameter_mm: Annotated[
        Length | None, about("diameter at which the tip relief begins", "mm", usual=USUAL_SIZE)
    ] = None
    tip_relief_shape: Annotated[
        Literal[ReliefShape, "double_linear"],
        about(
            "shape of the tip relief over the roll angle: 'linear', as on drawings, begins with a "
            "kink, which acts as a sharp corner; 'parabolic' begins without a kink; "
            "'double_linear' has two straight parts that meet at tip_relief_knee_diameter_mm"
        ),
    ] = "linear"
    tip_relief_knee_um: Annotated[
        Relief | None,
        about(
            "tip relief at tip_relief_knee_diameter_mm, with tip_relief_shape = 'double_linear'",
            "um",
            usual=USUAL_MODIFICATION,
            per=PER_MODULE,
        ),
    ] = None
    tip_relief_knee_diameter_mm: Annotated[
        Length | None,
        about("diameter at which both parts of the tip relief meet", "mm", usual=USUAL_SIZE),
    ] = None
    root_relief_um: Annotated[
        Relief | None,
        about(
            "root relief at the form circle, normal to the involute",
            "um",
            usual=USUAL_MODIFICATION,
            per=PER_MODULE,
        ),
    ] = None
    root_relief_start_diameter_mm: Annotated[
        Length | None, about("diameter at which the root relief begins", "mm", usual=USUAL_SIZE)
    ] = None
    root_relief_shape: Annotated[
        ReliefShape,
        about("shape of the root relief over the roll angle, as tip_relief_shape"),
    ] = "linear"
    tip_radius_mm: Annotated[
        Length | None,
        about("radius of the arc between flank and tip circle", "mm", usual=USUAL_ROUNDING),
    ] = None
    tip_chamfer_mm: Annotated[
        Length | None,
        about(
            "radial height of the chamfer between flank and tip circle", "mm", usual=USUAL_ROUNDING
        ),
    ] = None
    profile_crowning_um: Annotated[
        Relief | None,
        about(
            "profile crowning, normal to the involute",
            "um",
            usual=USUAL_MODIFICATION,
            per=PER_MODULE,
        ),
    ] = None

    @property
    def flank_keys(self) -> tuple[str, Table | None]:
        """The keys of the flank are in this table itself."""
        return "", self

    @property
    def helix_rad(self) -> float:
        """Helix angle on the reference cylinder, rad; 0 for a spur tooth."""
        return 0.0

    @property
    def base_pitch_mm(self) -> float:
        """Distance of neighbouring flanks along the base tangent in the transverse section, mm."""
        return pi * self.module_mm / cos(self.helix_rad) * cos(self.transverse_angle_rad)

    @property
    def transverse_angle_rad(self) -> float:
        """Pressure angle in the transverse section, rad."""
        normal = radians(self.pressure_angle_deg)
        return atan(tan(normal) / cos(self.helix_rad)) if self.helix_rad else normal


ToolLength = Annotated[float, Meta(ge=0, le=1000)]


class Geometry(InvoluteKeys, frozen=True, kw_only=True):
    """Keys of the profile of an external gear, whose root is cut by a generating rack."""

    dedendum_factor: Annotated[
        float, Meta(gt=0, le=5), about("dedendum of the basic rack in modules", "-")
    ] = 1.25
    fillet_radius_factor: Annotated[
        float,
        Meta(ge=0, le=2.0),
        about("tip radius of the generating rack in modules; determines the root fillet", "-"),
    ] = 0.38
    protuberance_mm: Annotated[
        ToolLength | None,
        about(
            "protuberance of the rack's tip beyond its flank, normal to the flank (pr_P0): the "
            "root is cut free by protuberance_mm - grinding_stock_mm",
            "mm",
            usual=(5e-3, 3.0),
        ),
    ] = None
    protuberance_angle_deg: Annotated[
        float,
        Meta(ge=0, lt=45),
        about("pressure angle of the protuberance flank, less than that of the rack", "deg"),
    ] = 8.0
    grinding_stock_mm: Annotated[
        ToolLength,
        about(
            "stock that the rack leaves on each flank, normal to it, and that is ground off; the "
            "keys of the thickness are those of the finished teeth",
            "mm",
            usual=(5e-3, 3.0),
        ),
    ] = 0.0


def check_pitch_errors(
    errors_um: Sequence[float], teeth: int, base_pitch_mm: float, key: str
) -> None:
    """Check that there is one pitch error per tooth, and that none exceeds its limit."""
    if errors_um and len(errors_um) != teeth:
        expected = f"one entry per tooth: {teeth}, as in {key}.teeth"
        refuse(f"{key}.pitch_errors_um", expected, f"{len(errors_um)} entries")
    most = LARGEST_PITCH_ERROR * 1000 * base_pitch_mm
    for i, error in enumerate(errors_um):
        if base_pitch_mm and abs(error) > most:
            expected = f"at most {LARGEST_PITCH_ERROR:g} of the base pitch, {most:.0f} um"
            refuse(f"{key}.pitch_errors_um[{i}]", expected, error)


def check_tip(
    body: InvoluteKeys, given: Mapping[str, Any], key: str, *, inwards: bool = False
) -> None:
    """Check the keys of thickness, reliefs, protuberance, and tip rounding or chamfer."""
    _check_thickness(body, key, inwards=inwards)
    _check_reliefs(body, given, key)
    if isinstance(body, Geometry):
        _check_protuberance(body, given, key)
    if body.tip_radius_mm is not None and body.tip_chamfer_mm is not None:
        refuse(
            f"{key}.tip_radius_mm",
            f"nothing beside {key}.tip_chamfer_mm: a tip has one or the other",
            f"{body.tip_radius_mm:g} and {body.tip_chamfer_mm:g}",
        )
    start = body.tip_relief_start_diameter_mm
    if body.tip_relief_um is None:
        for name in ("tip_relief_start_diameter_mm", "tip_relief_shape"):
            if name in given:
                refuse_absent(key, "tip_relief_um", "a number >= 0", name)
    elif start is None:
        if body.tip_relief_um:  # a relief of 0 begins nowhere
            refuse_absent(key, "tip_relief_start_diameter_mm", "a number > 0", "tip_relief_um")
    elif start <= body.tip_diameter_mm if inwards else start >= body.tip_diameter_mm:
        side = "more" if inwards else "less"
        expected = f"{side} than {key}.tip_diameter_mm ({body.tip_diameter_mm:g})"
        refuse(f"{key}.tip_relief_start_diameter_mm", expected, start)


_DOUBLE = "double_linear"
#: Measurements of the tooth thickness, with the key that each requires.
MEASURED = {"span_measurement_mm": "span_teeth", "ball_measurement_mm": "measuring_ball_mm"}


def _check_protuberance(body: Geometry, given: Mapping[str, Any], key: str) -> None:
    """Check that a protuberance exceeds the grinding stock and has a smaller pressure angle."""
    if body.protuberance_mm is None:
        for name in ("protuberance_angle_deg", "grinding_stock_mm"):
            if name in given:
                refuse_absent(key, "protuberance_mm", "a number", name)
        return
    if body.protuberance_mm <= body.grinding_stock_mm:
        refuse(
            f"{key}.protuberance_mm",
            f"more than {key}.grinding_stock_mm ({body.grinding_stock_mm:g}), so that the root is "
            "cut free",
            body.protuberance_mm,
        )
    if body.protuberance_angle_deg >= body.pressure_angle_deg:
        expected = f"less than {key}.pressure_angle_deg ({body.pressure_angle_deg:g})"
        refuse(f"{key}.protuberance_angle_deg", expected, body.protuberance_angle_deg)


def _check_thickness(body: ThicknessKeys, key: str, *, inwards: bool) -> None:
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


def _check_reliefs(body: InvoluteKeys, given: Mapping[str, Any], key: str) -> None:
    """Check that a double-linear tip relief has a knee, and a root relief a start."""
    double = body.tip_relief_shape == "double_linear"
    for name in ("tip_relief_knee_um", "tip_relief_knee_diameter_mm"):
        value = getattr(body, name)
        if double and body.tip_relief_um and value is None:
            refuse(f"{key}.{name}", f"a number, since {key}.tip_relief_shape is '{_DOUBLE}'", None)
        if not double and value is not None:
            refuse(f"{key}.{name}", f"nothing without {key}.tip_relief_shape = '{_DOUBLE}'", value)
    if body.root_relief_um is None:
        for name in ("root_relief_start_diameter_mm", "root_relief_shape"):
            if name in given:
                refuse_absent(key, "root_relief_um", "a number >= 0", name)
    elif body.root_relief_um and body.root_relief_start_diameter_mm is None:
        refuse_absent(key, "root_relief_start_diameter_mm", "a number > 0", "root_relief_um")
