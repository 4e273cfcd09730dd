"""Groups of the keys of a body, in the order of a design: schema, reference and scene files."""

from msgspec import UNSET
from msgspec.structs import FieldInfo

#: Keys of each group in their order. A name that ends in an underscore matches all keys that begin
#: with it, in the order of their table.
GROUPS = {
    "Basic data": (
        "teeth",
        "module_mm",
        "pressure_angle_deg",
        "profile_shift",
        "helix_angle_deg",
        "hand",
    ),
    "Tooth thickness": (
        "tooth_thickness_allowance_um",
        "span_measurement_mm",
        "span_teeth",
        "ball_measurement_mm",
        "measuring_ball_mm",
    ),
    "Tip": (
        "tip_diameter_mm",
        "addendum_factor",
        "tip_alteration_factor",
        "tip_radius_mm",
        "tip_chamfer_mm",
    ),
    "Root": (
        "root_diameter_mm",
        "dedendum_factor",
        "fillet_radius_factor",
        "root_fillet_radius_mm",
        "protuberance_",
        "grinding_stock_mm",
    ),
    "Modifications": (
        "tip_relief_",
        "root_relief_",
        "profile_crowning_",
        "lead_crowning_",
        "helix_slope_",
        "end_relief_",
        "profile_twist_",
        "topography_",
    ),
    "Deviations of single teeth": ("pitch_errors_um", "tooth_helix_slope_um"),
    "Width": ("face_width_mm", "axial_offset_mm"),
    "Bore, shaft, rim, web and hub": (
        "bore_",
        "bore",
        "outer_diameter_mm",
        "rim",
        "shaft",
        "rim_",
        "web_",
        "hub_",
        "region_",
    ),
    "Material": ("material", "young_modulus_MPa", "poisson_ratio", "one_material", "rigid"),
}


def group_of(name: str) -> str | None:
    """Group of a key of a body; None if it has none."""
    place = _place_of(name)
    return None if place is None else list(GROUPS)[place[0]]


def in_groups(fields: dict[str, FieldInfo]) -> dict[str, FieldInfo]:
    """Keys of a body in the order of a design: required ones, then group by group.

    Keys without a group, which few kinds of body have, follow the basic data.
    """

    def rank(name: str) -> tuple[bool, int, int]:
        field = fields[name]
        required = field.required or field.default is UNSET  # from other keys
        return (not required, *(_place_of(name) or (0, len(fields))))

    return {name: fields[name] for name in sorted(fields, key=rank)}


def _place_of(name: str) -> tuple[int, int] | None:
    """Number of the group of a key, and its place in the group."""
    for group, members in enumerate(GROUPS.values()):
        for place, member in enumerate(members):
            if name == member or (member.endswith("_") and name.startswith(member)):
                return group, place
    return None
