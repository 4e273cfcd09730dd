"""The tables of gears and rings and the rules of their keys."""

from collections.abc import Mapping
from itertools import pairwise
from math import asin, degrees, sin
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from flankload.scene import axial, regions
from flankload.scene.involute import Geometry, InvoluteKeys, check_pitch_errors, check_tip
from flankload.scene.materials import MaterialName
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import (
    USUAL_ROUNDING,
    USUAL_SIZE,
    BodyTable,
    Length,
    PitchErrors,
    PoissonRatio,
    Rigid,
    Shift,
    Teeth,
    Toothed,
    YoungModulus,
    about,
)

#: Support of a body at its bore, or at the outside of its rim.
Support = Literal["held", "torque"]
#: Least bore over tip diameter; a body fixed at a point could turn about it without resistance.
LEAST_BORE = 1e-3


class ByNormalModule(Toothed, axial.AxialKeys):
    """Mixin of toothed bodies whose helix angle belongs to the normal module."""

    __slots__ = ()

    if TYPE_CHECKING:
        module_mm: float

    @property
    def turn_per_mm(self) -> float:
        """Rotation of the section along the axis times half the number of teeth, rad/mm."""
        return sin(self.helix_rad) / self.module_mm

    def helix_deg_of(self, turn_per_mm: float) -> float:
        """Helix angle for such a rotation, deg; 90 if there is none."""
        return degrees(asin(min(1.0, turn_per_mm * self.module_mm)))


class Gear(
    regions.RegionKeys, ByNormalModule, Geometry, BodyTable, frozen=True, kw_only=True, tag="gear"
):
    """An external spur or helical gear with a generated root fillet, fixed at its bore."""

    teeth: Annotated[Teeth, about("number of teeth", "-")]
    bore_diameter_mm: Annotated[
        Length, about("diameter of the bore, where the body is held", "mm", usual=USUAL_SIZE)
    ]
    bore: Annotated[
        Support,
        about(
            "'held': no point of the bore moves, as on a shaft far stiffer than the rim; 'torque': "
            "only its mean motion is held, by the torque and the forces on the shaft, spread over "
            "the bore, so that a thin rim bends (hollow gears, gears on a spline or a thin tube)"
        ),
    ] = "held"
    material: MaterialName = None
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: PitchErrors = ()
    helix_angle_deg: axial.HelixAngle = 0.0
    hand: axial.Hand = None
    face_width_mm: axial.OwnWidth = None
    axial_offset_mm: axial.AxialOffset = 0.0
    lead_crowning_um: axial.LeadCrowning = None
    helix_slope_um: axial.HelixSlope = None
    tooth_helix_slope_um: axial.ToothHelixSlopes = ()
    end_relief_um: axial.EndRelief = None
    end_relief_length_mm: axial.EndReliefLength = None
    end_relief_shape: axial.EndReliefShape = "linear"
    profile_twist_um: axial.ProfileTwist = None
    topography_file: axial.TopographyFile = None
    shaft: axial.OnShaft = None
    web_width_mm: regions.WebWidth = None
    web_outer_diameter_mm: regions.WebOuterDiameter = None
    rim_thickness_mm: regions.RimThickness = None
    web_offset_mm: regions.WebOffset = 0.0
    hub_diameter_mm: regions.HubDiameter = None
    hub_width_mm: regions.HubWidth = None
    hub_offset_mm: regions.HubOffset = 0.0

    def check(self, given: Mapping[str, Any], key: str) -> None:
        """Check the pitch errors, the keys of the tip, along the axis, and the bore."""
        check_pitch_errors(self.pitch_errors_um, self.teeth, self.base_pitch_mm, key)
        check_tip(self, given, key)
        self.check_axial(given, key)
        self.check_regions(key)
        check_bore(self, key)
        _check_support(self, "bore", key)

    @property
    def has_free_bore(self) -> bool:
        """Whether only the mean motion of the bore is held."""
        return self.bore == "torque"


class WidthKeys(ByNormalModule, InvoluteKeys, frozen=True, kw_only=True):
    """Keys of an involute profile and along the axis, for rings and splines."""

    face_width_mm: axial.OwnWidth = None
    axial_offset_mm: axial.AxialOffset = 0.0
    lead_crowning_um: axial.LeadCrowning = None
    helix_slope_um: axial.HelixSlope = None
    tooth_helix_slope_um: axial.ToothHelixSlopes = ()
    end_relief_um: axial.EndRelief = None
    end_relief_length_mm: axial.EndReliefLength = None
    end_relief_shape: axial.EndReliefShape = "linear"


class RingKeys(WidthKeys, BodyTable, frozen=True, kw_only=True):
    """Keys of a body with internal teeth."""

    called: ClassVar[str] = "ring"
    inward: ClassVar[bool | None] = True

    teeth: Annotated[Teeth, about("number of teeth", "-")]
    profile_shift: Annotated[
        Shift,
        about(
            "profile shift in modules, positive outwards: the space is as wide as the tooth of an "
            "external gear with the same profile shift",
            "-",
        ),
    ] = 0.0
    root_diameter_mm: Annotated[
        Length, about("diameter of the root circle", "mm", usual=USUAL_SIZE)
    ]
    outer_diameter_mm: Annotated[
        Length, about("outer diameter of the rim, where the body is held", "mm", usual=USUAL_SIZE)
    ]
    material: MaterialName = None
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: PitchErrors = ()

    def check(self, given: Mapping[str, Any], key: str) -> None:
        """Check pitch errors, the keys of the tip, along the axis, and the order of the circles."""
        check_pitch_errors(self.pitch_errors_um, self.teeth, self.base_pitch_mm, key)
        check_tip(self, given, key, inwards=True)
        self.check_axial(given, key)
        _check_ring(self, key)


class Ring(regions.RingWebKeys, RingKeys, frozen=True, kw_only=True, tag="ring"):
    """An internal spur or helical gear, fixed at the outside of its rim."""

    helix_angle_deg: axial.HelixAngle = 0.0
    hand: axial.Hand = None
    profile_twist_um: axial.ProfileTwist = None
    topography_file: axial.TopographyFile = None
    shaft: axial.OnShaft = None
    root_fillet_radius_mm: Annotated[
        Length | None,
        about(
            "radius of the arc that is tangent to flank and root circle of the transverse "
            "section; absent = the largest, which rounds the whole root",
            "mm",
            usual=USUAL_ROUNDING,
        ),
    ] = None
    web_width_mm: regions.RingWebWidth = None
    web_inner_diameter_mm: regions.WebInnerDiameter = None
    rim_thickness_mm: regions.RimThickness = None
    web_offset_mm: regions.WebOffset = 0.0
    rim: Annotated[
        Support,
        about(
            "'held': no point of the outside of the rim moves, as in a stiff housing; 'torque': "
            "only its mean motion is held, so that a thin rim bends"
        ),
    ] = "held"

    def check(self, given: Mapping[str, Any], key: str) -> None:
        """Check what all rings have in common, and the support of the rim."""
        super().check(given, key)
        self.check_regions(key)
        _check_support(self, "rim", key)

    @property
    def has_free_bore(self) -> bool:
        """Whether only the mean motion of the outside of the rim is held."""
        return self.rim == "torque"


def check_bore(body: Any, key: str) -> None:
    """Check that the bore of a gear or a spline shaft is smaller than its tip, but not a point."""
    if body.bore_diameter_mm < LEAST_BORE * body.tip_diameter_mm:
        expected = f"at least {LEAST_BORE:g} of {key}.tip_diameter_mm "
        expected += f"({LEAST_BORE * body.tip_diameter_mm:g}), since the body is fixed there"
        refuse(f"{key}.bore_diameter_mm", expected, body.bore_diameter_mm)
    if body.bore_diameter_mm >= body.tip_diameter_mm:
        expected = f"less than {key}.tip_diameter_mm ({body.tip_diameter_mm:g})"
        refuse(f"{key}.bore_diameter_mm", expected, body.bore_diameter_mm)


def _check_support(body: Gear | Ring, name: str, key: str) -> None:
    """Check that a bore that bends follows no flexible shaft."""
    if body.has_free_bore and body.shaft is not None and body.shaft.is_flexible:
        expected = (
            f"'held', since {key}.shaft.under_teeth is 'flexible': the bore follows the shaft"
        )
        refuse(f"{key}.{name}", expected, shown(getattr(body, name)))


def _check_ring(ring: RingKeys, key: str) -> None:
    """Check that tip circle, root circle and outside of the rim have increasing diameters."""
    circles = ("tip_diameter_mm", "root_diameter_mm", "outer_diameter_mm")
    for inner, outer in pairwise(circles):
        if getattr(ring, outer) <= getattr(ring, inner):
            expected = f"more than {key}.{inner} ({getattr(ring, inner):g}), since the teeth of "
            expected += f"a {ring.called} point inwards"
            if inner == circles[0] and ring.called == "ring":
                expected += " (kind = 'gear' for teeth that point outwards)"
            refuse(f"{key}.{outer}", expected, getattr(ring, outer))
