"""The tables of a cam and its follower."""

from typing import Annotated, Literal

from msgspec import Meta

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

#: One row of a cam's table.
ProfileRow = tuple[
    Annotated[float, Meta(ge=-360, le=720)],
    Annotated[float, Meta(ge=1e-3, le=1e5)],
]


class CamKeys(EvenBody, frozen=True, kw_only=True):
    """What a cam and its follower have in common."""

    bore_diameter_mm: Annotated[
        Length, about("mm", "diameter of the bore, which is fixed", usual=USUAL_SIZE)
    ]
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False

    @property
    def number_of_teeth(self) -> int:
        """One flank all around."""
        return 1


class Cam(CamKeys, frozen=True, kw_only=True, tag="cam"):
    """A disc cam by the table of its profile, held at its bore."""

    profile: Annotated[
        tuple[ProfileRow, ...] | None,
        about(
            "",
            "rows [angle in deg, radius in mm] around the cam, counter-clockwise; a smooth closed "
            "curve goes through them (periodic cubic spline). At position 0 angle 0 points from "
            "the cam's axis to that of the follower",
        ),
    ] = None
    profile_file: Annotated[
        Text | None,
        about(
            "",
            "the same as a .csv file with two columns, angle_deg and radius_mm; relative to the "
            "folder of the scene file",
        ),
    ] = None
    sense: Annotated[
        Literal["clockwise", "counter_clockwise"],
        about(
            "",
            "how the cam turns; clockwise: at position a its angle a points to the follower's "
            "axis. The follower is pressed onto the cam counter-clockwise",
        ),
    ] = "clockwise"


Place = Annotated[float, Meta(ge=-1e5, le=1e5)]


class Follower(CamKeys, frozen=True, kw_only=True, tag="follower"):
    """A lever that turns about its own axis and follows a cam with a roller or a flat."""

    arm_mm: Annotated[
        Length | None,
        about("mm", "distance of the roller's centre from the follower's axis", usual=USUAL_SIZE),
    ] = None
    roller_radius_mm: Annotated[
        Length | None,
        about("mm", "radius of the roller, which is one piece with its arm", usual=USUAL_SIZE),
    ] = None
    flat_offset_mm: Annotated[
        Place | None,
        about(
            "mm",
            "distance of the flat's line from the follower's axis, positive towards the cam",
        ),
    ] = None
    flat_from_mm: Annotated[
        Length | None,
        about("mm", "where the flat begins, along its line from the foot of the axis"),
    ] = None
    flat_to_mm: Annotated[Length | None, about("mm", "where it ends")] = None
    arm_width_mm: Annotated[
        Length | None,
        about(
            "mm",
            "width of the arm; absent = the roller's radius, or a fifth of the flat's end "
            "(flat_to_mm)",
        ),
    ] = None
    hub_diameter_mm: Annotated[
        Length | None,
        about("mm", "outside of the hub; absent = as large as bore and arm need it"),
    ] = None

    @property
    def has_roller(self) -> bool:
        """Whether it follows with a roller, not with a flat."""
        return self.roller_radius_mm is not None
