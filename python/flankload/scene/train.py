"""The table [train]: external gears in two meshes.

The axis of body 1 is at the origin. An idler (body 3) is driven by body 1 and drives body 2; a
wheel (body 1) drives two pinions (bodies 2 and 3): one gear, the common one, is in both meshes. The
meshes of a double helical pinion (body 1) and its wheel (body 2) are those of their halves.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from msgspec import Meta

from flankload.scene.axial import MISALIGNMENTS
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.form import fields_of
from flankload.scene.gear import Gear
from flankload.scene.mates import check_base_pitches
from flankload.scene.refusal import refuse, shown
from flankload.scene.stage import (
    USUAL_STIFFNESS,
    USUAL_TILTING,
    WITHOUT,
    WITHOUT_IN_BODIES,
    Stiffness,
)
from flankload.scene.table import BODIES, USUAL_ERRORS, USUAL_SIZE, Deviation, Length, Table, about

if TYPE_CHECKING:
    from flankload.scene.scene import SceneFile

#: Effects that a train may have; others act on a pair of bodies.
EFFECTS = frozenset(
    {
        *("contact", "tooth_coupling", "mesh_coupling", "tip_contact", "beyond_limits"),
        "dimension",
    }
)
#: Bodies of both meshes, the driving one first, by the kind of train; the common gear is in both.
MESHES: dict[str, tuple[tuple[str, str], tuple[str, str]]] = {
    "idler": (("body_1", "body_3"), ("body_3", "body_2")),
    "two_pinions": (("body_1", "body_2"), ("body_1", "body_3")),
    "double_helical": (("body_1", "body_2"), ("body_1", "body_2")),
}
#: Keys that other kinds of train have, by the kind.
WITHOUT_IN_KIND = {
    "idler": (
        *("floating", "timing_error_um"),
        *("groove_width_mm", "groove_diameter_mm", "axial_stiffness_N_per_um"),
    ),
    "two_pinions": ("groove_width_mm", "groove_diameter_mm", "axial_stiffness_N_per_um"),
    "double_helical": ("floating", "angle_deg", "center_distance_2_mm"),
}


class Train(Table, frozen=True, kw_only=True):
    """External gears in two meshes: an idler, two pinions on one wheel, or double helical gears."""

    instead_of: ClassVar[Mapping[str, tuple[str, ...]]] = {"center_distance_2_mm": ()}

    kind: Annotated[
        Literal["idler", "two_pinions", "double_helical"],
        about(
            "'idler' = body 1 drives body 3, which turns freely and drives body 2; 'two_pinions' = "
            "body 1 is a wheel, which drives bodies 2 and 3; 'double_helical' = bodies 1 and 2 "
            "have a second half each, the mirror image of the first one at smaller z"
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
            "radial stiffness of the bearings of the common gear, or of a double helical body 1; "
            "absent = rigid",
            "N/um",
            usual=USUAL_STIFFNESS,
        ),
    ] = None
    bearing_tilt_stiffness_Nm_per_mrad: Annotated[
        Stiffness | None,
        about(
            "tilting stiffness of these bearings; absent = rigid",
            "N m/mrad",
            usual=USUAL_TILTING,
        ),
    ] = None
    axial_stiffness_N_per_um: Annotated[
        Stiffness | None,
        about(
            "axial stiffness of the bearings of a double helical body 1; absent = it moves along "
            "its axis without resistance",
            "N/um",
            usual=USUAL_STIFFNESS,
        ),
    ] = None
    groove_width_mm: Annotated[
        Length | None,
        about(
            "distance of both halves of double helical gears, whose bodies are described by the "
            "half of larger z; required for these",
            "mm",
            usual=USUAL_SIZE,
        ),
    ] = None
    groove_diameter_mm: Annotated[
        Length | None,
        about(
            "diameter of a double helical body 1 in the groove, where it bends and twists; its "
            "torque comes in at the half of larger z; absent = both halves are one rigid body",
            "mm",
            usual=USUAL_SIZE,
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
            "rotation of the second pinion, or of half 2 of a double helical one, from its place, "
            "on its base circle; positive: its flanks are in contact earlier and carry more",
            "um",
            usual=USUAL_ERRORS,
        ),
    ] = 0.0

    @property
    def meshes(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """Tables of the bodies of both meshes."""
        return MESHES[self.kind]

    @property
    def is_double_helical(self) -> bool:
        """Whether the meshes are the halves of one pair."""
        return self.kind == "double_helical"

    @property
    def lacks_distance(self) -> bool:
        """Whether the centre distance of the second mesh follows from other keys."""
        return self.center_distance_2_mm is None and not self.is_double_helical

    @property
    def stiffnesses(self) -> dict[str, float | None]:
        """Stiffnesses of the bearings, radial, tilting, axial, in N and mm; None without."""
        keys = {
            "bearing_N_per_mm": (self.bearing_stiffness_N_per_um, 1e3),
            "tilt_Nmm_per_rad": (self.bearing_tilt_stiffness_Nm_per_mrad, 1e6),
            "axial_N_per_mm": (self.axial_stiffness_N_per_um, 1e3),
        }
        return {name: None if k is None else unit * k for name, (k, unit) in keys.items()}

    def check(self) -> None:
        """Check the rules between the keys of this table."""
        plain = fields_of(type(self))
        for name in WITHOUT_IN_KIND[self.kind]:
            if getattr(self, name) != plain[name].default:
                expected = f"nothing with train.kind = '{self.kind}'"
                refuse(f"train.{name}", expected, shown(getattr(self, name)))
        if self.is_double_helical and self.groove_width_mm is None:
            refuse("train.groove_width_mm", "a value with train.kind = 'double_helical'", None)
        if self.floating and self.angle_deg != 180.0:
            expected = "180 with train.floating: otherwise no position balances both pushes"
            refuse("train.angle_deg", expected, self.angle_deg)
        if self.floating and self.bearing_stiffness_N_per_um is not None:
            expected = "nothing with train.floating"
            refuse("train.bearing_stiffness_N_per_um", expected, self.bearing_stiffness_N_per_um)


def check_train(asked: SceneFile, given: Mapping[str, Any]) -> None:
    """Check the tables of a train together; `given`: scene as in the file."""
    train, third = asked.train, asked.body_3
    if train is None:
        if third is not None:
            refuse("train", "a table, beside [body_3]", None)
        return
    if train.is_double_helical and third is not None:
        refuse("body_3", "nothing with train.kind = 'double_helical'", "a table")
    if not train.is_double_helical and third is None:
        refuse("body_3", "a table, beside [train]", None)
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
    _check_width(asked, train)
    plain = EffectsAsked()
    for key, value in given.get("effects", {}).items():
        if key not in EFFECTS and value != getattr(plain, key):
            why = WITHOUT.get(key, "this version has it for two bodies")
            refuse(f"effects.{key}", f"nothing with [train]: {why}", shown(value))
    if asked.positions.adaptive:
        expected = "false with [train]: this version has it for two bodies"
        refuse("positions.adaptive", expected, shown(True))


def _check_width(asked: SceneFile, train: Train) -> None:
    """Check the keys along the axis: double helical gears have a helix."""
    assert asked.pair is not None
    instead = {**WITHOUT_IN_BODIES, "shaft": "bearings are those of [train]"}
    for body in BODIES:
        for name, why in instead.items():
            if getattr(getattr(asked, body), name, None):
                refuse(f"{body}.{name}", f"nothing with [train]: {why}", "a value")
    for name in MISALIGNMENTS:
        if getattr(asked.pair, name) and not train.is_double_helical:
            expected = "nothing with this [train], which has several axes"
            refuse(f"pair.{name}", expected, getattr(asked.pair, name))
    if not train.is_double_helical:
        return
    for name in ("body_1", "body_2"):
        gear = getattr(asked, name)
        if not gear.helix_angle_deg:
            expected = "a number > 0 with train.kind = 'double_helical'"
            refuse(f"{name}.helix_angle_deg", expected, gear.helix_angle_deg)
        if gear.axial_offset_mm:
            expected = "0 with train.kind = 'double_helical': train.groove_width_mm places halves"
            refuse(f"{name}.axial_offset_mm", expected, gear.axial_offset_mm)
