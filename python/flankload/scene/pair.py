"""The tables [pair], [load] and [positions] and their rules."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene.axial import MISALIGNMENTS
from flankload.scene.involute import InvoluteKeys
from flankload.scene.refusal import refuse
from flankload.scene.table import (
    BY_OTHERS,
    LARGEST_TILT,
    USUAL_MODIFICATION,
    USUAL_SIZE,
    Angle,
    Angles,
    BodyTable,
    Length,
    Relief,
    Table,
    Torque,
    Torques,
    about,
)

#: Least number of initial positions; fewer miss pairs of teeth in contact during part of a pitch.
LEAST_INITIAL_COUNT = 8


OF_SPLINES = MISALIGNMENTS[-1]

Misalignment = Annotated[float, Meta(ge=-100, le=100)]
#: Usual misalignments, um/mm: from 1 um per metre of width.
USUAL_MISALIGNMENT = (1e-3, LARGEST_TILT)


class Pair(Table, frozen=True, kw_only=True):
    """Relative position of the bodies."""

    instead_of: ClassVar[Mapping[str, tuple[str, ...]]] = {
        "center_distance_mm": ("normal_backlash_um",)
    }

    center_distance_mm: Annotated[
        Length | None,
        about(
            "actual distance of the two axes, including a centre distance error, which does not "
            "change the teeth; absent = from normal_backlash_um, or that without backlash for the "
            "profile shifts; required for cams and compliance files; not for splines",
            "mm",
            usual=USUAL_SIZE,
        ),
    ] = None
    normal_backlash_um: Annotated[
        Relief | None,
        about(
            "normal backlash of the finished teeth (j_bn), in place of center_distance_mm",
            "um",
            usual=USUAL_MODIFICATION,
        ),
    ] = None
    center_offset_mm: Annotated[
        Annotated[float, Meta(ge=0, le=1e5)] | None,
        about(
            "distance of the two axes of a spline; absent = 0 (common axis)",
            "mm",
            # usual: 0.01 mm; 10 probably means 10 um
            usual=(1e-5, 2.0),
        ),
    ] = None
    face_width_mm: Annotated[
        Length,
        about(
            "common width of the flanks in contact; absent = the overlap of the face widths of "
            "both bodies, which are then required",
            "mm",
            usual=(0.05, 5000.0),
        ),
    ] = BY_OTHERS

    inclination_um_per_mm: Annotated[
        Misalignment,
        about(
            "misalignment of axis 2 in the plane of both axes, f_Sigma_delta; positive: the gap "
            "grows with z",
            "um/mm",
            usual=USUAL_MISALIGNMENT,
        ),
    ] = 0.0
    deviation_um_per_mm: Annotated[
        Misalignment,
        about(
            "misalignment of axis 2 across the plane of both axes, f_Sigma_beta; positive: the "
            "gap grows with z",
            "um/mm",
            usual=USUAL_MISALIGNMENT,
        ),
    ] = 0.0

    misalignment_mrad: Annotated[
        float,
        Meta(ge=0, le=100),
        about(
            "angle between the axes of a spline: the hub leans about the middle of the common "
            "face width",
            "mrad",
            usual=(1e-3, 50.0),
        ),
    ] = 0.0
    misalignment_direction_deg: Annotated[
        Angle,
        about(
            "direction in which the hub's axis leans towards larger z, counter-clockwise from "
            "that of center_offset_mm",
            "deg",
        ),
    ] = 0.0

    @property
    def axes_coincide(self) -> bool:
        """Whether both axes of a spline coincide."""
        return not self.axes_apart_mm and not self.misalignment_mrad

    @property
    def axes_apart_mm(self) -> float:
        """Distance of the two axes, mm."""
        return self.center_distance_mm or self.center_offset_mm or 0.0

    def check(self, body_1: BodyTable, body_2: BodyTable) -> None:
        """Check that splines have their offset and misalignment, other bodies a centre distance."""
        distance, offset = self.center_distance_mm, self.center_offset_mm
        if body_1.conforms and distance is not None:
            expected = "nothing: splines have pair.center_offset_mm (absent = 0)"
            refuse("pair.center_distance_mm", expected, distance)
        if not body_1.conforms and offset is not None:
            expected = f"nothing: a {body_1.kind} and a {body_2.kind} have "
            expected += "pair.center_distance_mm, only splines an offset"
            refuse("pair.center_offset_mm", expected, offset)
        if body_1.conforms and self.normal_backlash_um is not None:
            expected = "nothing: splines have pair.center_offset_mm (absent = 0)"
            refuse("pair.normal_backlash_um", expected, self.normal_backlash_um)
        known = all(isinstance(body.flank_keys[1], InvoluteKeys) for body in (body_1, body_2))
        if not body_1.conforms and distance is None and not known:
            expected = "a number from 0.001 to 100000, since not both bodies have the keys of an "
            refuse("pair.center_distance_mm", expected + "involute profile", "nothing")
        for name in MISALIGNMENTS:
            if getattr(self, name) and body_1.conforms == (name != OF_SPLINES):
                here = OF_SPLINES if body_1.conforms else " and ".join(MISALIGNMENTS[:2])
                expected = f"nothing: a {body_1.kind} and a {body_2.kind} have pair.{here}"
                refuse(f"pair.{name}", expected, getattr(self, name))
        if self.misalignment_direction_deg and not self.misalignment_mrad:
            expected = f"nothing, unless pair.{OF_SPLINES} is > 0"
            refuse("pair.misalignment_direction_deg", expected, self.misalignment_direction_deg)


TorqueOrTorques = Annotated[
    Torque | Torques,
    about("torque on body 1, or a list with one result per torque; 0 = motion without load", "N m"),
]
SlackTension = Annotated[
    Annotated[float, Meta(gt=0, le=1e9)] | None,
    about("tension of the slack strand of a chain or a belt", "N"),
]


class Load(Table, frozen=True, kw_only=True):
    """Load on body 1."""

    torque_Nm: TorqueOrTorques
    slack_tension_N: SlackTension = None

    @property
    def torques_Nm(self) -> tuple[float, ...]:
        """All torques, N m."""
        torque = self.torque_Nm
        return torque if isinstance(torque, tuple) else (float(torque),)


class Positions(Table, frozen=True, kw_only=True):
    """Positions at which the pair is solved."""

    count: Annotated[
        int,
        Meta(ge=1, le=100000),
        about(
            "equally spaced positions per tooth pitch of body 1 (per turn of a cam); with "
            "adaptive, the initial positions; concentric splines have one position",
            "-",
        ),
    ] = 32
    angles_deg: Annotated[
        Angles | None,
        about("angles of body 1 (with a cam: of the cam) from position 0, instead of count", "deg"),
    ] = None
    pitches: Annotated[
        Annotated[int, Meta(ge=1, le=10000)] | Literal["hunting"],
        about(
            "tooth pitches of body 1 that the positions cover; 'hunting' = the whole period: with "
            "pitch errors on both bodies the least common multiple of their tooth numbers, "
            "without pitch errors one pitch",
            "-",
        ),
    ] = 1
    adaptive: Annotated[
        bool,
        about(
            "true: positions are added where the transmission error is curved, the same for all "
            "torques, until its harmonics 1 to 3 and its peak to peak meet the tolerance"
        ),
    ] = False
    tolerance: Annotated[
        Annotated[float, Meta(ge=1e-5, le=0.1)] | None,
        about(
            "with adaptive: relative uncertainty that the positions may leave in a harmonic (for "
            "small ones, relative to a tenth of the largest) and in the peak to peak; absent = "
            "0.3 of accuracy.tolerance",
            "-",
        ),
    ] = None
    max_count: Annotated[
        Annotated[int, Meta(ge=1, le=100000)] | None,
        about(
            "with adaptive: largest number of positions per tooth pitch; if it does not suffice, "
            "a warning gives the remaining uncertainty; absent = 8 count",
            "-",
        ),
    ] = None
    driver: Annotated[
        Literal["body_1", "body_2"], about("the driving body; determines the direction of sliding")
    ] = "body_1"

    @property
    def most_per_pitch(self) -> int:
        """Largest number of adaptive positions per tooth pitch."""
        return self.max_count or 8 * self.count

    def check(self, given: Mapping[str, Any]) -> None:
        """Refuse keys beside explicit angles, and keys of adaptive positions without `adaptive`."""
        if self.angles_deg is not None:
            for key in ("count", "pitches", "adaptive", "tolerance", "max_count"):
                if key in given:
                    expected = f"nothing beside positions.{key}: one of the two"
                    refuse("positions.angles_deg", expected, self.angles_deg)
        if not self.adaptive:
            for key in ("tolerance", "max_count"):
                if key in given:
                    refuse(
                        f"positions.{key}", "nothing, unless positions.adaptive is true", given[key]
                    )
            return
        if self.count < LEAST_INITIAL_COUNT:
            expected = f"at least {LEAST_INITIAL_COUNT} to begin adaptive positions with"
            refuse("positions.count", expected, self.count)
        if self.max_count is not None and self.max_count < self.count:
            expected = f"at least positions.count ({self.count})"
            refuse("positions.max_count", expected, self.max_count)


def check_partners(body_1: BodyTable, body_2: BodyTable) -> None:
    """Refuse bodies whose kind requires a partner of another kind."""
    kinds = body_1.kind, body_2.kind
    for wanted in ((body_1.kind, body_1.partner), (body_2.partner, body_2.kind)):
        if None not in wanted and kinds != wanted:
            refuse(
                "body_2.kind",
                "'{1}' with body_1.kind '{0}': the two go together and with no other".format(
                    *wanted
                ),
                f"'{body_2.kind}' with body_1.kind '{body_1.kind}'",
            )
