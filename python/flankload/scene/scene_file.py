"""The tables of a whole scene file, put together from those of its parts.

The reader (`form`) and the JSON schema are both made from what stands in these rooms, every key
once with its type, range, unit and meaning.
"""

from typing import Annotated, Literal

from msgspec import Meta

from flankload.scene.belt_tables import Belt, Pulley
from flankload.scene.cam_tables import Cam, Follower
from flankload.scene.chain_tables import Chain, Sprocket
from flankload.scene.effect_tables import EffectsAsked
from flankload.scene.gear_tables import Gear, Ring, SplineHub, SplineShaft
from flankload.scene.mesh_tables import ComplianceBody, MeshBody
from flankload.scene.pair_tables import Load, Pair, Positions
from flankload.scene.table import Length, Strips, Table, Text, about

Body1 = Gear | SplineShaft | Follower | Sprocket | Pulley | MeshBody | ComplianceBody
Body2 = Gear | Ring | SplineHub | Cam | Chain | Belt | MeshBody | ComplianceBody
BodySpec = Body1 | Body2


class Accuracy(Table, frozen=True, kw_only=True):
    """How exact, and with which knobs; a knob that is absent follows from the tolerance."""

    tolerance: Annotated[
        Annotated[float, Meta(ge=1e-4, le=0.1)],
        about(
            "-",
            "wanted relative error of transmission error, load share, peak pressure off sharp "
            "corners and secant stiffness; named, it decides on the knobs that are not",
        ),
    ] = 0.01
    plane: Annotated[
        Literal["strain", "stress"], about("", "plane strain (wide gears) or plane stress (discs)")
    ] = "strain"
    estimate: Annotated[bool, about("", "false skips the error estimate")] = True
    flank_element_mm: Annotated[
        Length | None, about("mm", "length of the finite elements along the flank")
    ] = None
    modes: Annotated[
        Annotated[int, Meta(ge=3, le=12)] | None, about("-", "pressure modes per flank")
    ] = None
    strips_per_half_width: Annotated[
        Strips | None, about("-", "contact strips per Hertz half-width")
    ] = None
    corner_strips_per_half_width: Annotated[
        Strips | None, about("-", "the same where a sharp tip corner carries")
    ] = None
    zone_half_widths: Annotated[
        Annotated[float, Meta(gt=1, le=20)] | None,
        about("-", "half-width of the strips' zone in Hertz half-widths"),
    ] = None


class SceneFile(Table, frozen=True, kw_only=True):
    """A whole scene file."""

    name: Annotated[Text | None, about("", "name of the scene; absent = name of the file")] = None
    body_1: Annotated[Body1, about("", "free to turn, carries the torque")]
    body_2: Annotated[Body2, about("", "stands at its kinematic angle")]
    pair: Annotated[
        Pair | None, about("", "needed, but for chains and belts, which know none of it")
    ] = None
    load: Load
    positions: Positions = Positions()
    effects: EffectsAsked = EffectsAsked()
    accuracy: Accuracy = Accuracy()
