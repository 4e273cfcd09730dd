"""The tables of bodies with involute teeth: gears, rings, splines."""

from typing import Annotated, Literal

from msgspec import Meta

from flankload.scene.table import (
    USUAL_ERRORS,
    USUAL_MODIFICATION,
    USUAL_ROUNDING,
    USUAL_SIZE,
    BodyTable,
    Deviation,
    Length,
    PitchErrors,
    PoissonRatio,
    Relief,
    Rigid,
    Shift,
    Table,
    Teeth,
    YoungModulus,
    about,
)


class InvoluteKeys(Table, frozen=True, kw_only=True):
    """Keys of an involute profile, transverse section, whatever makes its root."""

    module_mm: Annotated[Length, about("mm", "module", usual=(0.02, 100.0))]
    pressure_angle_deg: Annotated[
        Annotated[float, Meta(ge=5, le=45)], about("deg", "pressure angle of the basic rack")
    ] = 20.0
    profile_shift: Annotated[Shift, about("-", "profile shift in modules")] = 0.0
    tip_diameter_mm: Annotated[Length, about("mm", "diameter of the tip circle", usual=USUAL_SIZE)]
    tip_relief_um: Annotated[
        Relief | None,
        about(
            "um",
            "tip relief at the tip circle, normal to the involute",
            usual=USUAL_MODIFICATION,
        ),
    ] = None
    tip_relief_start_diameter_mm: Annotated[
        Length | None,
        about("mm", "diameter at which the tip relief begins", usual=USUAL_SIZE),
    ] = None
    tip_relief_shape: Annotated[
        Literal["linear", "parabolic"],
        about(
            "",
            "shape of the tip relief over the roll angle: 'linear', as drawings have it, begins "
            "with a kink, which is a sharp corner; 'parabolic' without",
        ),
    ] = "linear"
    tip_radius_mm: Annotated[
        Length | None,
        about("mm", "radius of the arc between flank and tip circle", usual=USUAL_ROUNDING),
    ] = None
    tip_chamfer_mm: Annotated[
        Length | None,
        about(
            "mm",
            "radial height of the chamfer between flank and tip circle",
            usual=USUAL_ROUNDING,
        ),
    ] = None
    profile_crowning_um: Annotated[
        Relief | None,
        about("um", "profile crowning, normal to the involute", usual=USUAL_MODIFICATION),
    ] = None


class Geometry(InvoluteKeys, frozen=True, kw_only=True):
    """Keys of the profile of an external gear: its root is that of a generating rack."""

    dedendum_factor: Annotated[
        Annotated[float, Meta(gt=0, le=5)], about("-", "dedendum of the basic rack in modules")
    ] = 1.25
    fillet_radius_factor: Annotated[
        Annotated[float, Meta(ge=0, le=2)],
        about("-", "tip radius of the generating rack in modules; it makes the root fillet"),
    ] = 0.38


class Gear(Geometry, BodyTable, frozen=True, kw_only=True, tag="gear"):
    """An external spur gear with a generated root fillet, held at its bore."""

    teeth: Annotated[Teeth, about("-", "number of teeth")]
    bore_diameter_mm: Annotated[
        Length, about("mm", "diameter of the bore, which is fixed", usual=USUAL_SIZE)
    ]
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: PitchErrors = ()

    @property
    def number_of_teeth(self) -> int:
        """Teeth, as every kind of body has them."""
        return self.teeth


class RingKeys(InvoluteKeys, BodyTable, frozen=True, kw_only=True):
    """Keys of a body whose teeth stand inwards."""

    teeth: Annotated[Teeth, about("-", "number of teeth")]
    profile_shift: Annotated[
        Shift,
        about(
            "-",
            "profile shift in modules, positive outwards: the space is as wide as the tooth of an "
            "external gear with the same shift",
        ),
    ] = 0.0
    root_diameter_mm: Annotated[
        Length, about("mm", "diameter of the root circle", usual=USUAL_SIZE)
    ]
    outer_diameter_mm: Annotated[
        Length, about("mm", "outside of the rim, which is fixed", usual=USUAL_SIZE)
    ]
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: PitchErrors = ()

    @property
    def number_of_teeth(self) -> int:
        """Teeth, as every kind of body has them."""
        return self.teeth


class Ring(RingKeys, frozen=True, kw_only=True, tag="ring"):
    """An internal spur gear, held at the outside of its rim."""

    root_fillet_radius_mm: Annotated[
        Length | None,
        about(
            "mm",
            "radius of the arc that touches flank and root circle; absent = the largest, which "
            "rounds the whole root",
            usual=USUAL_ROUNDING,
        ),
    ] = None


SplineAngle = Annotated[
    Annotated[float, Meta(ge=5, le=45)], about("deg", "pressure angle of the basic rack")
]
IndexErrors = Annotated[
    tuple[Deviation, ...],
    about(
        "um",
        "one deviation per tooth along the base tangent, positive = metal that touches early; "
        "entry j is tooth j, counted in the sense of the torque from the tooth of pair 0",
        usual=USUAL_ERRORS,
    ),
]
#: Root fillet of splines in modules, that of DIN 5480 for hobbed shafts.
SPLINE_FILLET = 0.16


class SplineShaft(InvoluteKeys, BodyTable, frozen=True, kw_only=True, tag="spline_shaft"):
    """An involute spline on a shaft, held at its bore; its root is that of a generating rack."""

    teeth: Annotated[Teeth, about("-", "number of teeth")]
    pressure_angle_deg: SplineAngle = 30.0
    root_diameter_mm: Annotated[
        Length,
        about(
            "mm",
            "diameter of the root circle, which says how deep the rack cuts",
            usual=USUAL_SIZE,
        ),
    ]
    fillet_radius_factor: Annotated[
        Annotated[float, Meta(ge=0, le=2)],
        about("-", "tip radius of the generating rack in modules; it makes the root fillet"),
    ] = SPLINE_FILLET
    bore_diameter_mm: Annotated[
        Length, about("mm", "diameter of the bore, which is fixed", usual=USUAL_SIZE)
    ]
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: IndexErrors = ()

    @property
    def number_of_teeth(self) -> int:
        """Teeth, as every kind of body has them."""
        return self.teeth

    @property
    def dedendum_factor(self) -> float:
        """Dedendum, in modules, of the rack that cuts this root circle."""
        return 0.5 * (self.teeth - self.root_diameter_mm / self.module_mm) + self.profile_shift


class SplineHub(RingKeys, frozen=True, kw_only=True, tag="spline_hub"):
    """An involute spline in a hub, held at the outside of its rim."""

    pressure_angle_deg: SplineAngle = 30.0
    root_fillet_radius_mm: Annotated[
        Length | None,
        about(
            "mm",
            f"radius of the arc that touches flank and root circle; absent = {SPLINE_FILLET} "
            "modules",
            usual=USUAL_ROUNDING,
        ),
    ] = None
    pitch_errors_um: IndexErrors = ()
