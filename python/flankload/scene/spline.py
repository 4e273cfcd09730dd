"""The tables of splines and toothed couplings and the rules of their keys."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from msgspec import Meta

from flankload.scene.gear import RingKeys, WidthKeys, check_bore
from flankload.scene.involute import check_pitch_errors, check_tip
from flankload.scene.materials import MaterialName
from flankload.scene.refusal import refuse
from flankload.scene.table import (
    USUAL_ERRORS,
    USUAL_ROUNDING,
    USUAL_SIZE,
    BodyTable,
    Deviation,
    Length,
    PoissonRatio,
    Rigid,
    Teeth,
    YoungModulus,
    about,
)

SplineAngle = Annotated[float, Meta(ge=5, le=45), about("pressure angle of the basic rack", "deg")]
IndexErrors = Annotated[
    tuple[Deviation, ...],
    about(
        "one deviation per tooth along the base tangent, positive = excess material, early "
        "contact; entry j is tooth j, counted in the sense of the torque from the tooth of pair 0",
        "um",
        usual=USUAL_ERRORS,
    ),
]
#: Keys with which flanks of splines do not conform over their height.
PROFILE_MODIFICATIONS = ("tip_relief_um", "root_relief_um", "profile_crowning_um")
#: Root fillet radius of splines in modules: that of DIN 5480 for hobbed shafts.
SPLINE_FILLET = 0.16


class SplineKeys:
    """Mixin of splines."""

    __slots__ = ()

    def check_solid(self, key: str, why: str) -> None:
        """Refuse profile modifications in three dimensions."""
        for name in PROFILE_MODIFICATIONS:
            if value := getattr(self, name):
                expected = f"nothing, since {why} requires three dimensions: flanks of splines "
                expected += "conform over their height there (lead modifications vary along it)"
                refuse(f"{key}.{name}", expected, value)


class SplineShaft(SplineKeys, WidthKeys, BodyTable, frozen=True, kw_only=True, tag="spline_shaft"):
    """An involute spline on a shaft, fixed at its bore; its root is cut by a generating rack."""

    partner: ClassVar[str | None] = "spline_hub"
    conforms: ClassVar[bool] = True

    teeth: Annotated[Teeth, about("number of teeth", "-")]
    pressure_angle_deg: SplineAngle = 30.0
    root_diameter_mm: Annotated[
        Length,
        about(
            "diameter of the root circle; determines the depth of the rack", "mm", usual=USUAL_SIZE
        ),
    ]
    fillet_radius_factor: Annotated[
        float,
        Meta(ge=0, le=2.0),
        about("tip radius of the generating rack in modules; determines the root fillet", "-"),
    ] = SPLINE_FILLET
    bore_diameter_mm: Annotated[
        Length, about("diameter of the bore, where the body is fixed", "mm", usual=USUAL_SIZE)
    ]
    material: MaterialName = None
    young_modulus_MPa: YoungModulus = 206000.0
    poisson_ratio: PoissonRatio = 0.3
    rigid: Rigid = False
    pitch_errors_um: IndexErrors = ()

    def check(self, given: Mapping[str, Any], key: str) -> None:
        """Check the pitch errors, the keys of the tip, along the axis, and the bore."""
        check_pitch_errors(self.pitch_errors_um, self.teeth, self.base_pitch_mm, key)
        check_tip(self, given, key)
        self.check_axial(given, key)
        check_bore(self, key)

    @property
    def dedendum_factor(self) -> float:
        """Dedendum, in modules, of the rack that cuts the given root circle."""
        return 0.5 * (self.teeth - self.root_diameter_mm / self.module_mm) + self.profile_shift


class SplineHub(SplineKeys, RingKeys, frozen=True, kw_only=True, tag="spline_hub"):
    """An involute spline in a hub, fixed at the outside of its rim."""

    partner: ClassVar[str | None] = "spline_shaft"
    called: ClassVar[str] = "hub"
    conforms: ClassVar[bool] = True

    pressure_angle_deg: SplineAngle = 30.0
    root_fillet_radius_mm: Annotated[
        Length | None,
        about(
            f"radius of the arc that touches flank and root circle; absent = {SPLINE_FILLET} "
            "modules",
            "mm",
            usual=USUAL_ROUNDING,
        ),
    ] = None
    pitch_errors_um: IndexErrors = ()
