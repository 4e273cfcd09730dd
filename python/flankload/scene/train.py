"""The table [train]: three external gears in two meshes, an idler or two pinions on one wheel.

The axis of body 1 is at the origin. One gear, the common one, is in both meshes: an idler (body 3)
is driven by body 1 and drives body 2; a wheel (body 1) drives two pinions (bodies 2 and 3).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene.axial import three_dimensional_key
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.gear import Gear
from flankload.scene.mates import check_base_pitches
from flankload.scene.refusal import refuse, shown
from flankload.scene.stage import USUAL_STIFFNESS, WITHOUT, Stiffness
from flankload.scene.table import USUAL_ERRORS, Deviation, Length, Table, about

if TYPE_CHECKING:
    from flankload.scene.scene import SceneFile

#: Effects that a train may have; others act on a pair of bodies.
EFFECTS = frozenset({"contact", "tooth_coupling", "mesh_coupling", "tip_contact", "beyond_limits"})
#: Bodies of both meshes, the driving one first, by the kind of train; the common gear is in both.
MESHES: dict[str, tuple[tuple[str, str], tuple[str, str]]] = {
    "idler": (("body_1", "body_3"), ("body_3", "body_2")),
    "two_pinions": (("body_1", "body_2"), ("body_1", "body_3")),
}


class Train(Table, frozen=True, kw_only=True):
    """Three external gears: an idler between two gears, or two pinions on one wheel."""

    instead_of: ClassVar[Mapping[str, tuple[str, ...]]] = {"center_distance_2_mm": ()}

    kind: Annotated[
        Literal["idler", "two_pinions"],
        about(
            "'idler' = body 1 drives body 3, which turns freely and drives body 2; 'two_pinions' = "
            "body 1 is a wheel, which drives bodies 2 and 3"
        ),
    ]
    angle_deg: Annotated[
        Annotated[float, Meta(gt=0, lt=360)],
        about(
            "angle at the axis of the common gear (the idler, or the wheel) between its two mates, "
            "counter-clockwise from the mate in the first mesh; 180 = all axes in a line",
            "deg",
        ),
    ] = 180.0
    center_distance_2_mm: Annotated[
        Length | None,
        about(
            "centre distance of the second mesh: of bodies 3 and 2 with an idler, of bodies 1 and "
            "3 with two pinions; absent = without backlash; pair.center_distance_mm is that of the "
            "first mesh",
            "mm",
        ),
    ] = None
    bearing_stiffness_N_per_um: Annotated[
        Stiffness | None,
        about(
            "radial stiffness of the bearings of the common gear; absent = rigid",
            "N/um",
            usual=USUAL_STIFFNESS,
        ),
    ] = None
    floating: Annotated[
        bool,
        about(
            "the wheel between two pinions moves along the line of action without resistance, so "
            "that both carry alike; only with angle_deg = 180"
        ),
    ] = False
    timing_error_um: Annotated[
        Deviation,
        about(
            "rotation of the second pinion from its place, on its base circle; positive: its "
            "flanks are in contact earlier and carry more",
            "um",
            usual=USUAL_ERRORS,
        ),
    ] = 0.0

    @property
    def meshes(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Tables of the bodies of both meshes."""
        return MESHES[self.kind]

    @property
    def bearing_N_per_mm(self) -> float | None:
        """Radial stiffness of the bearings of the common gear, N/mm; None if they are rigid."""
        stiffness = self.bearing_stiffness_N_per_um
        return None if stiffness is None else 1000.0 * stiffness

    def check(self) -> None:
        """Check the rules between the keys of this table."""
        if self.kind == "idler":
            for name in ("floating", "timing_error_um"):
                if getattr(self, name):
                    expected = "nothing with train.kind = 'idler'"
                    refuse(f"train.{name}", expected, shown(getattr(self, name)))
        if self.floating and self.angle_deg != 180.0:
            expected = "180 with train.floating: otherwise no position balances both pushes"
            refuse("train.angle_deg", expected, self.angle_deg)
        if self.floating and self.bearing_stiffness_N_per_um is not None:
            expected = "nothing with train.floating"
            refuse("train.bearing_stiffness_N_per_um", expected, self.bearing_stiffness_N_per_um)


def check_train(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Check the tables of a train together; `given`: scene as in the file."""
    train, third = asked.train, asked.body_3
    if train is None or third is None:
        for there, missing in (("train", "body_3"), ("body_3", "train")):
            if getattr(asked, there) is not None:
                refuse(missing, f"a table, beside [{there}]", None)
        return
    if asked.stage is not None:
        refuse("train", "nothing beside [stage]", "a table")
    for name in ("body_1", "body_2"):
        body = getattr(asked, name)
        if not isinstance(body, Gear):
            refuse(f"{name}.kind", "'gear' with [train]", f"'{body.kind}'")
    train.check()
    for names in train.meshes:
        one, two = (getattr(asked, name) for name in names)
        check_base_pitches(one, two, names)
        if one.rigid and two.rigid:
            refuse(f"{names[1]}.rigid", f"false, since {names[0]}.rigid is true", shown(True))
    varying = three_dimensional_key(asked)
    if varying is not None:
        expected = "nothing with [train]: this version has plane trains, without helix and width"
        refuse(varying.removesuffix(" = 3"), expected, "a value")
    plain = EffectsAsked()
    for key, value in given.get("effects", {}).items():
        if key not in EFFECTS and value != getattr(plain, key):
            why = WITHOUT.get(key, "this version has it for two bodies")
            refuse(f"effects.{key}", f"nothing with [train]: {why}", shown(value))
    if asked.positions.adaptive:
        expected = "false with [train]: this version has it for two bodies"
        refuse("positions.adaptive", expected, shown(True))
