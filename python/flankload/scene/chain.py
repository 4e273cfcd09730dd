"""The tables of roller chains and their sprockets and the rules between their keys."""

from collections.abc import Mapping
from math import degrees, pi
from typing import Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene.chain_sizes import ChainName
from flankload.scene.drive import DriveTable, WrappedTable
from flankload.scene.refusal import refuse
from flankload.scene.table import BY_NAME, BodyTable, Length, Toothed, about

Pitch = Annotated[Length, about("pitch", "mm", usual=(0.5, 500.0))]
RollerDiameter = Annotated[Length, about("diameter of the rollers", "mm", usual=(0.2, 200.0))]


class Sprocket(Toothed, DriveTable, frozen=True, kw_only=True, tag="sprocket"):
    """A rigid sprocket for roller chains, ISO 606."""

    partner: ClassVar[str | None] = "chain"

    teeth: Annotated[int, Meta(ge=6, le=1000), about("number of teeth", "-")]
    pitch_mm: Pitch = BY_NAME
    roller_diameter_mm: RollerDiameter = BY_NAME
    seat: Annotated[
        Literal["tight", "wide"],
        about(
            "tooth form at the limits of ISO 606: 'tight' has the smallest roller seat and flank "
            "radius, 'wide' the largest; the following keys replace single values"
        ),
    ] = "wide"
    roller_seat_radius_mm: Annotated[
        Length | None, about("radius of the arc that seats a roller", "mm")
    ] = None
    flank_radius_mm: Annotated[
        Length | None, about("radius of the tooth flank that follows the seat", "mm")
    ] = None
    seating_angle_deg: Annotated[
        Annotated[float, Meta(ge=60, lt=180)] | None,
        about("angle of the seat arc; absent = 120 - 90/teeth", "deg"),
    ] = None
    tip_diameter_mm: Annotated[
        Length | None,
        about(
            "tip diameter; absent = the middle of the limits of ISO 606, at most where the flanks "
            "of a tooth meet",
            "mm",
        ),
    ] = None

    @property
    def rigid(self) -> bool:
        """A sprocket is always rigid; the contact stiffness belongs to the chain."""
        return True


class Chain(WrappedTable, frozen=True, kw_only=True, tag="chain"):
    """A roller chain around a sprocket; the end of its tight strand is fixed."""

    partner: ClassVar[str | None] = "sprocket"
    known: ClassVar[Mapping[str, frozenset[str]]] = {
        "positions": frozenset({"count", "angles_deg", "pitches"}),
        "accuracy": frozenset({"tolerance", "estimate"}),
    }
    no_pair: ClassVar[str] = (
        "a chain lies on its sprocket, with the contact stiffness body_2.contact_stiffness_N_per_mm"
    )

    chain: Annotated[
        ChainName | None,
        about(
            "name of the chain (docs/guide/catalogues.md): series B of ISO 606, or number of ASME "
            "B29.1; gives the keys of chain and sprocket that the scene does not set"
        ),
    ] = None
    pitch_mm: Pitch = BY_NAME
    roller_diameter_mm: RollerDiameter = BY_NAME
    wrap_angle_deg: Annotated[
        float,
        Meta(gt=0, le=360),
        about("angle around the sprocket between the points where the strands leave it", "deg"),
    ]
    link_stiffness_N: Annotated[
        float, Meta(ge=1e-3, le=1e12), about("tension of the chain per unit of strain", "N")
    ] = BY_NAME
    contact_stiffness_N_per_mm: Annotated[
        float,
        Meta(ge=1e-3, le=1e12),
        about("force of a roller on its pocket per mm of local deformation", "N/mm"),
    ] = BY_NAME
    elongation: Annotated[
        float, Meta(ge=0, le=0.05), about("relative elongation of every link by wear", "-")
    ] = 0.0
    span_length_mm: Annotated[
        Length | None,
        about(
            "length of the free strands, whose tension supports the outer rollers laterally; "
            "absent = 40 pitches",
            "mm",
        ),
    ] = None

    @property
    def rigid(self) -> bool:
        """A chain is always elastic."""
        return False

    def check_around(self, body_1: BodyTable, given: Mapping[str, Any]) -> None:
        """Check that pitch and roller fit the sprocket, and that the strands do not meet."""
        assert isinstance(body_1, Sprocket)
        for key in ("pitch_mm", "roller_diameter_mm"):
            own, other = getattr(body_1, key), getattr(self, key)
            if own != other:
                expected = f"{own:g} as in body_1.{key} (wear goes into body_2.elongation)"
                refuse(f"body_2.{key}", expected, f"{other:g}")
        most = degrees(2 * pi) * (1 - 1 / body_1.teeth)
        if self.wrap_angle_deg > most:
            expected = f"at most {most:g}: all teeth of body_1 but one"
            refuse("body_2.wrap_angle_deg", expected, f"{self.wrap_angle_deg:g}")
