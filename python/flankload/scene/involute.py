"""Keys of involute profiles (basic rack, tip, crowning, protuberance) and their rules."""

from collections.abc import Mapping, Sequence
from math import atan, cos, pi, radians, tan
from typing import Annotated, Any, ClassVar

from msgspec import Meta

from flankload.scene.refusal import refuse, refuse_absent
from flankload.scene.reliefs import ReliefKeys, check_reliefs
from flankload.scene.table import (
    BY_OTHERS,
    PER_MODULE,
    USUAL_MODIFICATION,
    USUAL_ROUNDING,
    USUAL_SIZE,
    Length,
    Relief,
    Shift,
    Table,
    about,
)
from flankload.scene.thickness import check_thickness

#: Largest pitch error over base pitch; larger ones could change the order of the teeth.
LARGEST_PITCH_ERROR = 0.1


class InvoluteKeys(ReliefKeys, frozen=True, kw_only=True):
    """Keys of an involute profile without its root."""

    instead_of: ClassVar[Mapping[str, tuple[str, ...]]] = {
        **ReliefKeys.instead_of,
        "tip_diameter_mm": ("addendum_factor",),
    }

    module_mm: Annotated[Length, about("module", "mm", usual=(0.02, 100.0))]
    pressure_angle_deg: Annotated[
        float, Meta(ge=5, le=45), about("pressure angle of the basic rack", "deg")
    ] = 20.0
    profile_shift: Annotated[Shift, about("profile shift in modules", "-")] = 0.0
    tip_diameter_mm: Annotated[
        Length, about("diameter of the tip circle", "mm", usual=USUAL_SIZE)
    ] = BY_OTHERS
    addendum_factor: Annotated[
        Annotated[float, Meta(gt=0, le=5)] | None,
        about(
            "addendum of the basic rack in modules (h_aP*), in place of tip_diameter_mm: "
            "d_a = d + 2 m_n (h_aP* + x + k), of internal teeth d - 2 m_n (h_aP* - x + k)",
            "-",
        ),
    ] = None
    tip_alteration_factor: Annotated[
        Shift,
        about(
            "tip alteration in modules (k), beside addendum_factor; negative = shorter teeth", "-"
        ),
    ] = 0.0
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
    check_thickness(body, key, inwards=inwards)
    check_reliefs(body, given, key)
    _check_start(body, key, inwards=inwards)
    if "tip_alteration_factor" in given and body.addendum_factor is None:
        refuse_absent(key, "addendum_factor", "a number > 0", "tip_alteration_factor")
    if isinstance(body, Geometry):
        _check_protuberance(body, given, key)
    if body.tip_radius_mm is not None and body.tip_chamfer_mm is not None:
        refuse(
            f"{key}.tip_radius_mm",
            f"nothing beside {key}.tip_chamfer_mm: a tip has one or the other",
            f"{body.tip_radius_mm:g} and {body.tip_chamfer_mm:g}",
        )


def _check_start(body: InvoluteKeys, key: str, *, inwards: bool) -> None:
    """Check that the tip relief begins on the side of the root."""
    start = body.tip_relief_start_diameter_mm
    if start is None:
        return
    if start <= body.tip_diameter_mm if inwards else start >= body.tip_diameter_mm:
        side = "more" if inwards else "less"
        expected = f"{side} than {key}.tip_diameter_mm ({body.tip_diameter_mm:g})"
        refuse(f"{key}.tip_relief_start_diameter_mm", expected, start)


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
