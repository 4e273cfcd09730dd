"""The tables of what stands between two bodies: axes, load, positions."""

from typing import Annotated, Literal

from msgspec import Meta

from flankload.scene.table import USUAL_SIZE, Angles, Length, Table, Torque, Torques, about


class Pair(Table, frozen=True, kw_only=True):
    """How the bodies stand to each other."""

    center_distance_mm: Annotated[
        Length | None,
        about(
            "mm",
            "distance of the two axes as they stand: a centre-distance error is part of it, while "
            "teeth and flanks stay what they are; needed, but for splines",
            usual=USUAL_SIZE,
        ),
    ] = None
    center_offset_mm: Annotated[
        Annotated[float, Meta(ge=0, le=1e5)] | None,
        about(
            "mm",
            "distance of a spline's two axes; absent = 0, they are one",
            # a hundredth is usual, ten are what was meant as um
            usual=(1e-5, 2.0),
        ),
    ] = None
    face_width_mm: Annotated[
        Length, about("mm", "width over which the flanks touch", usual=(0.05, 5000.0))
    ]

    @property
    def axes_apart_mm(self) -> float:
        """Distance of the two axes."""
        return self.center_distance_mm or self.center_offset_mm or 0.0


class Load(Table, frozen=True, kw_only=True):
    """What body 1 carries."""

    torque_Nm: Annotated[
        Torque | Torques,
        about(
            "N m", "torque on body 1, or a list: one result per torque; 0 is the unloaded motion"
        ),
    ]
    slack_tension_N: Annotated[
        Annotated[float, Meta(gt=0, le=1e9)] | None,
        about("N", "tension of the slack strand of a chain or a belt"),
    ] = None


class Positions(Table, frozen=True, kw_only=True):
    """Where the pair is looked at."""

    count: Annotated[
        Annotated[int, Meta(ge=1, le=100000)],
        about(
            "-",
            "positions per tooth pitch of body 1 (per turn of a cam), equally spaced; with "
            "adaptive those to begin with; concentric splines have one",
        ),
    ] = 32
    angles_deg: Annotated[
        Angles | None,
        about(
            "deg", "angles of body 1 (of a cam: of the cam) from position zero, instead of count"
        ),
    ] = None
    pitches: Annotated[
        Annotated[int, Meta(ge=1, le=10000)] | Literal["hunting"],
        about(
            "-",
            "tooth pitches of body 1 that the positions run over; 'hunting' = until all repeats: "
            "with pitch errors on both bodies the least common multiple of their tooth numbers, "
            "without any one pitch",
        ),
    ] = 1
    adaptive: Annotated[
        bool,
        about(
            "",
            "true: more positions where the transmission error bends, the same for all torques, "
            "until its harmonics 1 to 3 and its peak to peak are known to the tolerance",
        ),
    ] = False
    tolerance: Annotated[
        Annotated[float, Meta(ge=1e-5, le=0.1)] | None,
        about(
            "-",
            "with adaptive: what the positions may leave in doubt of a harmonic (of a tenth of "
            "the largest, where it is smaller) and of the peak to peak; absent = 0.3 of "
            "accuracy.tolerance",
        ),
    ] = None
    max_count: Annotated[
        Annotated[int, Meta(ge=1, le=100000)] | None,
        about(
            "-",
            "with adaptive: most positions per tooth pitch; where they do not suffice a warning "
            "says what is left in doubt; absent = 8 count",
        ),
    ] = None
    driver: Annotated[
        Literal["body_1", "body_2"], about("", "the driving body; decides the sliding direction")
    ] = "body_1"

    @property
    def most_per_pitch(self) -> int:
        """Most adaptive positions per tooth pitch."""
        return self.max_count or 8 * self.count
