"""The tables of timing belts and their pulleys."""

from typing import Annotated, Literal

from msgspec import Meta

from flankload.scene.table import (
    USUAL_SIZE,
    Deviation,
    EvenBody,
    Force,
    Length,
    Modulus,
    PoissonRatio,
    YoungModulus,
    about,
)

Pitch = Annotated[Length, about("mm", "pitch", usual=(0.5, 500.0))]
FlankAngle = Annotated[float, Meta(ge=0, le=45)]


class Pulley(EvenBody, frozen=True, kw_only=True, tag="pulley"):
    """A pulley for timing belts: rigid, or a ring that is held at its bore."""

    teeth: Annotated[
        Annotated[int, Meta(ge=6, le=1000)],
        about("-", "number of grooves"),
    ]
    pitch_mm: Pitch
    profile: Annotated[
        Literal["T", "HTD"],
        about(
            "",
            "teeth of the belt and grooves: 'T' are trapezoids, 'HTD' are round at the tip, their "
            "sides straight where they are higher than half as wide",
        ),
    ] = "T"
    groove_width_mm: Annotated[
        Length | None,
        about(
            "mm",
            "width of the grooves at the land; what it is more than that of the belt's teeth is "
            "clearance; absent = none",
        ),
    ] = None
    groove_depth_mm: Annotated[
        Length | None,
        about(
            "mm", "depth of the grooves; absent = any that is enough; elastic: as the belt's teeth"
        ),
    ] = None
    groove_angle_deg: Annotated[
        FlankAngle | None,
        about("deg", "between flank and centre line of a groove, 'T' only; absent = as the belt's"),
    ] = None
    rigid: Annotated[
        bool,
        about(
            "",
            "true: the pulley does not yield; false: it does, needs bore_diameter_mm; per mm of "
            "width, as wide as the belt",
        ),
    ] = True
    bore_diameter_mm: Annotated[
        Length | None,
        about(
            "mm", "diameter of the bore, which is fixed; elastic pulleys need it", usual=USUAL_SIZE
        ),
    ] = None
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3

    @property
    def number_of_teeth(self) -> int:
        """Teeth, as every kind of body has them."""
        return self.teeth


class Belt(EvenBody, frozen=True, kw_only=True, tag="belt"):
    """A timing belt around a pulley, its tight strand held."""

    pitch_mm: Pitch
    wrapped_teeth: Annotated[
        Annotated[int, Meta(ge=1, le=200)],
        about("-", "teeth of the belt that lie in grooves"),
    ]
    width_mm: Annotated[Length, about("mm", "width of the belt", usual=(0.5, 5000.0))]
    cord_stiffness_N_per_mm: Annotated[
        Annotated[float, Meta(ge=1e-3, le=1e9)],
        about("N/mm", "tension of the cord over its strain, per mm of width"),
    ]
    land_distance_mm: Annotated[
        Length, about("mm", "from the land between the teeth to the pitch line, where the cord is")
    ]
    back_mm: Annotated[Length, about("mm", "thickness from the land to the back")]
    tooth_height_mm: Annotated[Length, about("mm", "height of the teeth over the land")]
    tooth_width_mm: Annotated[
        Length, about("mm", "width of the teeth at the land; 'HTD': diameter of the round")
    ]
    flank_angle_deg: Annotated[
        FlankAngle | None,
        about("deg", "between flank and centre line of a tooth, 'T' only, needed there"),
    ] = None
    young_modulus_MPa: Annotated[
        Modulus,
        # from soft rubber to filled polyurethane
        about("MPa", "Young's modulus of the belt's material", usual=(1.0, 2e4)),
    ]
    poisson_ratio: Annotated[Annotated[float, Meta(ge=0, lt=0.5)], about("-", "Poisson ratio")] = (
        0.45
    )
    pitch_difference_um: Annotated[
        Deviation,
        about("um", "pitch of the belt without load, minus body_1.pitch_mm", usual=(0.1, 2000.0)),
    ] = 0.0
    prestress_N: Annotated[
        Force,
        about(
            "N",
            "mean tension of the cord, which holds it straight; half of tight and slack tension "
            "together is a good one",
        ),
    ] = 0.0

    @property
    def rigid(self) -> bool:
        """A belt yields."""
        return False


LandFriction = Annotated[
    Annotated[float, Meta(ge=-1, le=1)],
    about(
        "-",
        "coefficient of friction between the lands of a belt and its pulley, all of them sliding; "
        "positive: helps the teeth, negative: opposes them",
    ),
]
LandLift = Annotated[
    bool, about("", "true: the lands of a belt may lift off its pulley; needs body_2.prestress_N")
]
