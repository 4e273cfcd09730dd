"""The tables of a cam and its follower and the rules of their keys."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene.materials import MaterialName
from flankload.scene.refusal import refuse
from flankload.scene.table import (
    USUAL_SIZE,
    EvenBody,
    Length,
    PoissonRatio,
    Rigid,
    Text,
    YoungModulus,
    about,
)

ROLLER = ("arm_mm", "roller_radius_mm")
FLAT = ("flat_offset_mm", "flat_from_mm", "flat_to_mm")
#: One row of a cam's profile table: angle in degrees, radius in mm.
ProfileRow = tuple[Annotated[float, Meta(ge=-360, le=720)], Annotated[float, Meta(ge=1e-3, le=1e5)]]


class CamKeys(EvenBody, frozen=True, kw_only=True):
    """Keys that a cam and its follower have in common."""

    has_teeth: ClassVar[bool] = False

    bore_diameter_mm: Annotated[
        Length, about("diameter of the bore, where the body is fixed", "mm", usual=USUAL_SIZE)
    ]
    material: MaterialName = None
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False

    @property
    def number_of_teeth(self) -> int:
        """A cam and a follower have one flank each."""
        return 1


class Cam(CamKeys, frozen=True, kw_only=True, tag="cam"):
    """A disc cam defined by a table of its profile, fixed at its bore."""

    partner: ClassVar[str | None] = "follower"

    profile: Annotated[
        tuple[ProfileRow, ...] | None,
        about(
            "rows [angle in deg, radius in mm] around the cam, counter-clockwise, interpolated by "
            "a smooth closed curve (periodic cubic spline). At position 0, angle 0 points from "
            "the cam's axis to that of the follower"
        ),
    ] = None
    profile_file: Annotated[
        Text | None,
        about(
            "the same table as a .csv file with the columns angle_deg and radius_mm; relative to "
            "the folder of the scene file"
        ),
    ] = None
    sense: Annotated[
        Literal["clockwise", "counter_clockwise"],
        about(
            "sense of rotation of the cam; clockwise: at position a, its angle a points to the "
            "follower's axis. The follower is pressed onto the cam counter-clockwise"
        ),
    ] = "clockwise"

    def check(self, given: Mapping[str, Any], key: str) -> None:
        """Check that the cam has exactly one profile table."""
        tables = [name for name in ("profile", "profile_file") if getattr(self, name) is not None]
        if len(tables) != 1:
            expected = f"a table of angles and radii, here or in {key}.profile_file"
            refuse(f"{key}.profile", expected, "both" if tables else "nothing")


Place = Annotated[float, Meta(ge=-1e5, le=1e5)]


class Follower(CamKeys, frozen=True, kw_only=True, tag="follower"):
    """A lever that rotates about its own axis and follows a cam with a roller or a flat."""

    partner: ClassVar[str | None] = "cam"

    arm_mm: Annotated[
        Length | None,
        about("distance of the roller's centre from the follower's axis", "mm", usual=USUAL_SIZE),
    ] = None
    roller_radius_mm: Annotated[
        Length | None,
        about("radius of the roller, which does not rotate on its arm", "mm", usual=USUAL_SIZE),
    ] = None
    flat_offset_mm: Annotated[
        Place | None,
        about(
            "distance of the flat's line from the follower's axis, positive towards the cam", "mm"
        ),
    ] = None
    flat_from_mm: Annotated[
        Length | None,
        about(
            "beginning of the flat, along its line from the foot of the perpendicular from the "
            "axis",
            "mm",
        ),
    ] = None
    flat_to_mm: Annotated[
        Length | None, about("end of the flat, measured in the same way", "mm")
    ] = None
    arm_width_mm: Annotated[
        Length | None,
        about("width of the arm; absent = the roller's radius, or a fifth of flat_to_mm", "mm"),
    ] = None
    hub_diameter_mm: Annotated[
        Length | None,
        about("outer diameter of the hub; absent = as large as bore and arm require", "mm"),
    ] = None

    @property
    def has_roller(self) -> bool:
        """Whether the follower has a roller, not a flat face."""
        return self.roller_radius_mm is not None

    def check(self, given: Mapping[str, Any], key: str) -> None:
        """Check that there is either a roller or a flat face, and that the sizes are consistent."""
        present = [name for name in (*ROLLER, *FLAT) if getattr(self, name) is not None]
        wanted = ROLLER if self.has_roller or "arm_mm" in present else FLAT
        for name in wanted:
            if name not in present:
                heads = f"a roller ({', '.join(ROLLER)}) or a flat ({', '.join(FLAT)})"
                refuse(f"{key}.{name}", f"a number: a follower has {heads}", "nothing")
        for name in present:
            if name not in wanted:
                expected = f"nothing beside {key}.{wanted[0]}: a follower has a roller or a flat"
                refuse(f"{key}.{name}", expected, f"{getattr(self, name):g}")
        sizes = ("roller_radius_mm", "arm_mm") if wanted is ROLLER else FLAT[1:]
        for small, large in (("bore_diameter_mm", "hub_diameter_mm"), sizes):
            less, more = getattr(self, small), getattr(self, large)
            if more is not None and more <= less:
                refuse(f"{key}.{large}", f"more than {key}.{small} ({less:g})", f"{more:g}")
