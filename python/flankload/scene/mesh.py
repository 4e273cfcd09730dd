"""The tables of bodies imported from files (mesh, compliance) and the rules of their keys."""

from collections.abc import Mapping
from math import atan, degrees, pi, tan
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene import axial, regions
from flankload.scene.involute import Geometry, check_pitch_errors, check_tip
from flankload.scene.materials import MaterialName
from flankload.scene.refusal import refuse, shown
from flankload.scene.table import (
    USUAL_SIZE,
    BodyTable,
    Length,
    PitchErrors,
    PoissonRatio,
    Rigid,
    Table,
    Teeth,
    Text,
    YoungModulus,
    about,
)


class Profile(Geometry, frozen=True, kw_only=True):
    """The exact profile of a body from a mesh file, with the geometry keys of a gear."""

    kind: Annotated[Literal["gear"], about("kind of the profile")] = "gear"
    teeth: Annotated[
        Teeth | None,
        about("number of teeth, equal to that of the mesh; absent = that of the mesh", "-"),
    ] = None


class MeshBody(
    regions.MeshRegionKeys, axial.AxialKeys, BodyTable, frozen=True, kw_only=True, tag="mesh"
):
    """A body from a mesh file: one sector with cut faces, or the whole body with many flanks."""

    from_file: ClassVar[bool] = True
    inward: ClassVar[bool | None] = None

    file: Annotated[Text, about("mesh file; relative to the folder of the scene file")]
    teeth: Annotated[
        Teeth | None,
        about(
            "number of equal sectors of the body; for a whole body, absent = number of flank_sets",
            "-",
        ),
    ] = None
    flank_set: Annotated[Text, about("set of edges or nodes of the working flank")] = "FLANK"
    flank_sets: Annotated[
        Annotated[tuple[Text, ...], Meta(min_length=1)] | None,
        about(
            "for a whole body: sets of its working flanks, that of pair 0 first; replaces "
            "flank_set and cut_sets"
        ),
    ] = None
    fixed_set: Annotated[Text, about("set of fixed nodes (the bore)")] = "BORE"
    cut_sets: Annotated[tuple[Text, Text], about("sets of the sector's two cut faces")] = (
        "CUT_LEFT",
        "CUT_RIGHT",
    )
    reference_radius_mm: Annotated[
        Length | None,
        about(
            "radius that converts rotation into transmission error; required without profile; "
            "absent = base radius of the profile",
            "mm",
            usual=USUAL_SIZE,
        ),
    ] = None
    profile: Annotated[
        Profile | None,
        about("the exact profile, if known; absent = the flank curve goes through the nodes"),
    ] = None
    one_material: Annotated[
        bool, about("true: element groups of the file are treated as one material")
    ] = False
    material: MaterialName = None
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: PitchErrors = ()
    helix_angle_deg: axial.MeshHelixAngle = 0.0
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
    region_sets: regions.RegionSets = None
    region_widths_mm: regions.RegionWidths = None

    @property
    def number_of_teeth(self) -> int:
        """The key `teeth`, or the number of flank sets."""
        return self.teeth or len(self.flank_sets or ())

    @property
    def helix_radius_mm(self) -> float:
        """Radius of the circle to which the helix angle refers."""
        if self.profile is not None:
            return 0.5 * self.number_of_teeth * self.profile.module_mm
        assert self.reference_radius_mm is not None
        return self.reference_radius_mm

    @property
    def turn_per_mm(self) -> float:
        """Rotation of the section along the axis times half the number of teeth, rad/mm."""
        return 0.5 * self.number_of_teeth * tan(self.helix_rad) / self.helix_radius_mm

    def helix_deg_of(self, turn_per_mm: float) -> float:
        """Helix angle for such a rotation, deg."""
        return degrees(atan(2.0 * self.helix_radius_mm / self.number_of_teeth * turn_per_mm))

    @property
    def helix_tolerance_deg(self) -> float:
        """Larger without a profile, since the reference radius is rounded."""
        return super().helix_tolerance_deg if self.profile else axial.HELIX_TOLERANCE_OF_RADII

    @property
    def flank_keys(self) -> tuple[str, Table | None]:
        """The keys of the flank are those of the profile, if there is one."""
        return "profile.", self.profile

    def check(self, given: Mapping[str, Any], key: str) -> None:
        """Check the named sets, the pitch errors and the profile."""
        _check_sets(self, given, key)
        self.check_axial(given, key)
        self.check_regions(key)
        if self.flank_sets is not None and self.region_sets is not None:
            expected = f"nothing beside {key}.flank_sets: a whole body is as wide as its teeth"
            refuse(f"{key}.region_sets", expected, shown(list(self.region_sets)))
        teeth, profile = self.number_of_teeth, self.profile
        reference = 2 * pi * (self.reference_radius_mm or 0.0) / teeth
        base_pitch = reference if profile is None else profile.base_pitch_mm
        check_pitch_errors(self.pitch_errors_um, teeth, base_pitch, key)
        if profile is None:
            if self.reference_radius_mm is None:
                expected = f"a number > 0, since there is no {key}.profile that determines it"
                refuse(f"{key}.reference_radius_mm", expected, "nothing")
            return
        check_tip(profile, given["profile"], f"{key}.profile")
        if profile.teeth not in (None, teeth):
            refuse(f"{key}.profile.teeth", f"{teeth} as in {key}.teeth, or nothing", profile.teeth)


class ComplianceBody(axial.AxialKeys, BodyTable, frozen=True, kw_only=True, tag="compliance"):
    """A body with flank and compliance from a file of flankload or of another program."""

    from_file: ClassVar[bool] = True
    brings_compliance: ClassVar[bool] = True
    inward: ClassVar[bool | None] = None

    file: Annotated[
        Text, about("compliance file (.npz, .csv); relative to the folder of the scene file")
    ]
    rigid: Rigid = False
    pitch_errors_um: Annotated[PitchErrors, about("absent = those of the file", "um")] = ()
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

    @property
    def number_of_teeth(self) -> int:
        """0: the file has it."""
        return 0

    def check(self, given: Mapping[str, Any], key: str) -> None:
        """Check the keys along the axis."""
        self.check_axial(given, key)


def _check_sets(body: MeshBody, given: Mapping[str, Any], key: str) -> None:
    """Check that a sector has two cut faces and a whole body one set per flank."""
    if body.flank_sets is None:
        if body.teeth is None:
            expected = f"an integer >= 3, since there is no {key}.flank_sets to count"
            refuse(f"{key}.teeth", expected, "nothing")
        if body.cut_sets[0] == body.cut_sets[1]:
            refuse(f"{key}.cut_sets", "two different names", shown(list(body.cut_sets)))
        return
    for name in ("cut_sets", "flank_set"):
        if name in given:
            expected = f"nothing beside {key}.flank_sets: those are of a whole body"
            refuse(f"{key}.{name}", expected, shown(given[name]))
    for k, name in enumerate(body.flank_sets):
        if name in body.flank_sets[:k]:
            refuse(f"{key}.flank_sets[{k}]", "each set once", shown(name))
    count = len(body.flank_sets)
    if body.teeth is None and count < 3:
        refuse(f"{key}.teeth", "an integer >= 3, since few flanks are named", "nothing")
    if body.teeth is not None and body.teeth < count:
        refuse(f"{key}.teeth", f"at least {count}, as many as in {key}.flank_sets", f"{body.teeth}")
