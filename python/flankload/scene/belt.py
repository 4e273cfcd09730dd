"""The tables of timing belts and their pulleys and the rules between their keys."""

from collections.abc import Mapping
from math import pi, radians, sqrt, tan
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene.belt_profiles import ProfileName
from flankload.scene.drive import DriveTable, WrappedTable
from flankload.scene.materials import MaterialName
from flankload.scene.refusal import refuse
from flankload.scene.table import (
    BY_NAME,
    USUAL_SIZE,
    BodyTable,
    Deviation,
    Force,
    Length,
    Modulus,
    PoissonRatio,
    Toothed,
    YoungModulus,
    about,
)

Pitch = Annotated[Length, about("pitch", "mm", usual=(0.5, 500.0))]
FlankAngle = Annotated[float, Meta(ge=0, le=45)]
#: Largest relative difference of the pitches for which the belt fits the pulley.
LARGEST_PITCH_DIFFERENCE = 0.02
#: Largest width of a belt tooth over the pitch, so that a land remains.
WIDEST_TOOTH = 0.9
#: Least width of a groove of an elastic pulley at its bottom, over its width at the land.
LEAST_BOTTOM = 0.1
#: Keys that only an elastic pulley has.
ELASTIC = ("bore_diameter_mm", "material", "young_modulus_MPa", "poisson_ratio")


class Pulley(Toothed, DriveTable, frozen=True, kw_only=True, tag="pulley"):
    """A pulley for timing belts: rigid, or an elastic ring fixed at its bore."""

    partner: ClassVar[str | None] = "belt"

    teeth: Annotated[int, Meta(ge=6, le=1000), about("number of grooves", "-")]
    pitch_mm: Pitch = BY_NAME
    profile: Annotated[
        Literal["T", "HTD"] | ProfileName,
        about(
            "shape of belt teeth and grooves: 'T' is trapezoidal; 'HTD' has a round tip and, if "
            "the height exceeds half the width, straight sides; or the name of a profile "
            "(docs/guide/catalogues.md), which gives the pitch and the keys of the belt that the "
            "scene does not set"
        ),
    ] = "T"
    groove_width_mm: Annotated[
        Length | None,
        about(
            "width of the grooves at the land; the excess over the width of the belt's teeth is "
            "clearance; absent = no clearance",
            "mm",
        ),
    ] = None
    groove_depth_mm: Annotated[
        Length | None,
        about(
            "depth of the grooves; absent = deep enough (rigid pulley) or the height of the "
            "belt's teeth (elastic pulley)",
            "mm",
        ),
    ] = None
    groove_angle_deg: Annotated[
        FlankAngle | None,
        about(
            "angle between flank and centre line of a groove, 'T' only; absent = that of the belt",
            "deg",
        ),
    ] = None
    rigid: Annotated[
        bool,
        about(
            "true: rigid pulley; false: elastic pulley, as wide as the belt; requires "
            "bore_diameter_mm"
        ),
    ] = True
    bore_diameter_mm: Annotated[
        Length | None,
        about(
            "diameter of the bore, where the pulley is fixed; required for elastic pulleys",
            "mm",
            usual=USUAL_SIZE,
        ),
    ] = None
    material: MaterialName = None
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3

    @property
    def tooth_shape(self) -> str:
        """Shape of teeth and grooves: "T" or "HTD"."""
        return "HTD" if self.profile.startswith("HTD") else "T"


class Belt(WrappedTable, frozen=True, kw_only=True, tag="belt"):
    """A timing belt around a pulley; the end of its tight strand is fixed."""

    partner: ClassVar[str | None] = "pulley"
    known: ClassVar[Mapping[str, frozenset[str]]] = {
        "positions": frozenset({"count", "angles_deg", "pitches"}),
        "accuracy": frozenset({"tolerance", "estimate", "flank_element_mm"}),
    }
    no_pair: ClassVar[str] = "a belt has body_2.width_mm and lies on its pulley"

    pitch_mm: Pitch = BY_NAME
    wrapped_teeth: Annotated[int, Meta(ge=1, le=200), about("number of belt teeth in grooves", "-")]
    width_mm: Annotated[Length, about("width of the belt", "mm", usual=(0.5, 5000.0))]
    cord_stiffness_N_per_mm: Annotated[
        float,
        Meta(ge=1e-3, le=1e9),
        about("tension of the cord per unit of strain, per mm of width", "N/mm"),
    ] = BY_NAME
    land_distance_mm: Annotated[
        Length,
        about(
            "distance from the land between the teeth to the cord, which is the pitch line", "mm"
        ),
    ] = BY_NAME
    back_mm: Annotated[Length, about("thickness from the land to the back of the belt", "mm")] = (
        BY_NAME
    )
    tooth_height_mm: Annotated[Length, about("height of the teeth above the land", "mm")] = BY_NAME
    tooth_width_mm: Annotated[
        Length, about("width of the teeth at the land; 'HTD': diameter of the round tip", "mm")
    ] = BY_NAME
    flank_angle_deg: Annotated[
        FlankAngle | None,
        about(
            "angle between flank and centre line of a tooth; required for 'T', not allowed for "
            "'HTD'",
            "deg",
        ),
    ] = None
    young_modulus_MPa: Annotated[
        Modulus,
        # from soft rubber to filled polyurethane
        about("Young's modulus of the belt's material", "MPa", usual=(1.0, 2e4)),
    ] = BY_NAME
    poisson_ratio: Annotated[float, Meta(ge=0, lt=0.5), about("Poisson's ratio", "-")] = 0.45
    pitch_difference_um: Annotated[
        Deviation,
        about("pitch of the unloaded belt minus body_1.pitch_mm", "um", usual=(0.1, 2000.0)),
    ] = 0.0
    prestress_N: Annotated[
        Force,
        about(
            "mean tension of the cord, which keeps it straight; the mean of tight and slack "
            "tension is a good value",
            "N",
        ),
    ] = 0.0

    @property
    def rigid(self) -> bool:
        """A belt is always elastic."""
        return False

    def check_around(self, body_1: BodyTable, given: Mapping[str, Any]) -> None:
        """Check the pitch, the teeth and lands, and the dimensions of an elastic pulley."""
        assert isinstance(body_1, Pulley)
        _check_pitch(body_1, self)
        _check_tooth(body_1, self)
        _check_elastic(body_1, self, given)


def _check_pitch(pulley: Pulley, belt: Belt) -> None:
    if belt.wrapped_teeth >= pulley.teeth:
        expected = f"less than body_1.teeth ({pulley.teeth})"
        refuse("body_2.wrapped_teeth", expected, f"{belt.wrapped_teeth}")
    difference = belt.pitch_mm - pulley.pitch_mm
    part = 100 * LARGEST_PITCH_DIFFERENCE
    if abs(difference) > LARGEST_PITCH_DIFFERENCE * pulley.pitch_mm:
        expected = f"body_1.pitch_mm ({pulley.pitch_mm:g}) to {part:g} %"
        refuse("body_2.pitch_mm", expected, f"{belt.pitch_mm:g}")
    whole = difference + belt.pitch_difference_um / 1000.0
    if abs(whole) > LARGEST_PITCH_DIFFERENCE * pulley.pitch_mm:
        expected = f"at most {part:g} % of body_1.pitch_mm ({pulley.pitch_mm:g})"
        refuse("body_2.pitch_difference_um", expected, f"{belt.pitch_difference_um:g}")
    land = pulley.teeth * pulley.pitch_mm / (2 * pi) - belt.land_distance_mm
    if belt.land_distance_mm >= belt.back_mm:
        expected = f"less than body_2.back_mm ({belt.back_mm:g}): the cord lies in the belt"
        refuse("body_2.land_distance_mm", expected, f"{belt.land_distance_mm:g}")
    if belt.tooth_height_mm >= 0.5 * land:
        expected = f"less than half of the pulley's radius ({0.5 * land:.4g})"
        refuse("body_2.tooth_height_mm", expected, f"{belt.tooth_height_mm:g}")
    widest = WIDEST_TOOTH * 2 * pi * land / pulley.teeth
    if belt.tooth_width_mm > widest:
        expected = f"at most {widest:.4g}: lands between the teeth"
        refuse("body_2.tooth_width_mm", expected, f"{belt.tooth_width_mm:g}")


def _check_tooth(pulley: Pulley, belt: Belt) -> None:
    trapezoid = pulley.tooth_shape == "T"
    for key, value in (
        ("body_1.groove_angle_deg", pulley.groove_angle_deg),
        ("body_2.flank_angle_deg", belt.flank_angle_deg),
    ):
        if not trapezoid and value is not None:
            refuse(key, "nothing with body_1.profile 'HTD'", f"{value:g}")
    if trapezoid:
        if belt.flank_angle_deg is None:
            refuse("body_2.flank_angle_deg", "a number with body_1.profile 'T'", "nothing")
        tip = belt.tooth_width_mm - 2 * belt.tooth_height_mm * tan(radians(belt.flank_angle_deg))
        if tip < 0.1 * belt.tooth_width_mm:
            expected = "so small that a tooth keeps a tenth of its width at the tip"
            refuse("body_2.flank_angle_deg", expected, f"{belt.flank_angle_deg:g}")
    elif belt.tooth_height_mm < 0.4 * belt.tooth_width_mm:
        refuse(
            "body_2.tooth_height_mm",
            f"at least 0.4 of body_2.tooth_width_mm ({belt.tooth_width_mm:g}) with body_1.profile "
            "'HTD'",
            f"{belt.tooth_height_mm:g}",
        )
    for key, groove, tooth in (
        ("groove_width_mm", pulley.groove_width_mm, "tooth_width_mm"),
        ("groove_depth_mm", pulley.groove_depth_mm, "tooth_height_mm"),
    ):
        least = getattr(belt, tooth)
        if groove is not None and groove < least:
            refuse(f"body_1.{key}", f"at least body_2.{tooth} ({least:g})", f"{groove:g}")


def _check_elastic(pulley: Pulley, belt: Belt, given: Mapping[str, Any]) -> None:
    """Check that an elastic pulley has a bore and teeth between its grooves."""
    named = [key for key in ELASTIC if key in given]
    if named and "rigid" not in given:
        refuse("body_1.rigid", f"true or false beside body_1.{named[0]}", "nothing")
    if pulley.rigid:
        return
    if pulley.bore_diameter_mm is None:
        refuse("body_1.bore_diameter_mm", "a number with body_1.rigid = false", "nothing")
    land = pulley.teeth * pulley.pitch_mm / (2 * pi) - belt.land_distance_mm
    width = pulley.groove_width_mm or belt.tooth_width_mm
    widest = WIDEST_TOOTH * 2 * pi * land / pulley.teeth
    if width > widest:
        refuse("body_1.groove_width_mm", f"at most {widest:.4g}: teeth between", f"{width:g}")
    deeper = 0.5 * (width - belt.tooth_width_mm) if pulley.tooth_shape == "HTD" else 0.0
    depth = max(pulley.groove_depth_mm or 0.0, belt.tooth_height_mm + deeper)
    if pulley.tooth_shape == "T":
        angle = pulley.groove_angle_deg
        angle = angle if angle is not None else belt.flank_angle_deg
        assert angle is not None
        if width - 2 * depth * tan(radians(angle)) < LEAST_BOTTOM * width:
            expected = "so small that a groove keeps a tenth of its width at the bottom"
            refuse("body_1.groove_depth_mm", expected, f"{depth:g}")
    bottom = 2 * (sqrt(land**2 - (0.5 * width) ** 2) - depth)
    if pulley.bore_diameter_mm >= bottom:
        expected = f"less than the diameter below the grooves ({bottom:.4g})"
        refuse("body_1.bore_diameter_mm", expected, f"{pulley.bore_diameter_mm:g}")
