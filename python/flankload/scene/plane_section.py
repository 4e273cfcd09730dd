"""The plane section of a three-dimensional scene, and a plane scene in three dimensions."""

from __future__ import annotations

from dataclasses import replace
from math import cos, degrees
from typing import TYPE_CHECKING, Any

from msgspec import structs

from flankload.scene.axial import LEAD_KEYS, MISALIGNMENTS, STAGE_KEYS, AxialKeys, common_range
from flankload.scene.derived import WIDTH
from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.gear import Gear, Ring
from flankload.scene.stage import Stage

if TYPE_CHECKING:
    from flankload.scene.scene import Scene

#: Keys of [accuracy] of three-dimensional and of plane contact.
OF_SLICES = ("slices", "axial_degree", "load_degree_z")
OF_CELLS = ("strips_per_half_width", "corner_strips_per_half_width", "zone_half_widths")
#: Defaults of the keys of a stage.
DEFAULTS = {field.name: field.default for field in structs.fields(Stage)}
#: Keys of a body along its axis, which a plane section lacks.
ALONG_AXIS = (
    "helix_angle_deg", "hand", "face_width_mm", "axial_offset_mm", *LEAD_KEYS,
    "end_relief_length_mm", "end_relief_shape", "shaft", "web_width_mm", "web_outer_diameter_mm",
    "web_inner_diameter_mm", "rim_thickness_mm", "web_offset_mm", "hub_diameter_mm",
    "hub_width_mm", "hub_offset_mm", "region_sets", "region_widths_mm",
)  # fmt: skip


def plane_section(scene: Scene) -> Scene:
    """The transverse section of a scene: spur teeth on rigid parallel axes.

    The width, also of webs and hubs, is the common face width. The rack of a helical gear has the
    keys of its transverse section, so that flanks are unchanged; the root fillet differs, since the
    tip of that rack is a circle instead of an ellipse.
    """
    one, two = scene.body_1, scene.body_2
    assert isinstance(one, AxialKeys)
    assert isinstance(two, AxialKeys)
    low, high = common_range(one, two, scene.pair.face_width_mm)
    contact = scene.effects.contact if "contact" in scene.named_effects else EffectsAsked().contact
    stage = scene.stage
    if stage is not None:
        stage = structs.replace(stage, **{name: DEFAULTS[name] for name in STAGE_KEYS})
    return replace(
        scene,
        body_1=_straight(scene.body_1),
        planet=None if scene.planet is None else _straight(scene.planet),
        body_2=_straight(scene.body_2),
        stage=stage,
        pair=structs.replace(
            scene.pair, face_width_mm=high - low, **dict.fromkeys(MISALIGNMENTS, 0.0)
        ),
        effects=structs.replace(scene.effects, dimension=None, contact=contact),
        accuracy=structs.replace(scene.accuracy, **dict.fromkeys(OF_SLICES)),
        derived=scene.derived - {WIDTH},
        named_effects=scene.named_effects - {"dimension"},
        named_discretization_keys=scene.named_discretization_keys
        - {f"accuracy.{key}" for key in OF_SLICES},
    )


def in_three_dimensions(scene: Scene) -> Scene:
    """A plane scene in three dimensions, with contact in slices."""
    return replace(
        scene,
        effects=structs.replace(scene.effects, dimension=3, contact="lumped"),
        accuracy=structs.replace(scene.accuracy, **dict.fromkeys(OF_CELLS)),
        named_effects=scene.named_effects | {"dimension"},
        named_discretization_keys=scene.named_discretization_keys
        - {f"accuracy.{key}" for key in OF_CELLS},
    )


def _straight(body: Any) -> Any:
    """A body without keys along its axis, and with the rack of its transverse section."""
    fields = structs.fields(body)
    keys = {field.name: field.default for field in fields if field.name in ALONG_AXIS}
    if getattr(body, "region_sets", None):  # element groups are regions, not materials
        keys["one_material"] = True
    if isinstance(body, Gear | Ring) and body.helix_angle_deg:
        c = cos(body.helix_rad)
        keys |= {
            "module_mm": body.module_mm / c,
            "pressure_angle_deg": degrees(body.transverse_angle_rad),
            "profile_shift": body.profile_shift * c,
        }
    if isinstance(body, Gear) and body.helix_angle_deg:
        keys |= {
            "dedendum_factor": body.dedendum_factor * c,
            "fillet_radius_factor": body.fillet_radius_factor * c,
        }
    return structs.replace(body, **keys)
