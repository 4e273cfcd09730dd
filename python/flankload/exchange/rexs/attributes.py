"""The attributes of REXS that are read, each with its key of a scene, and the units of files.

To read another attribute as it is, add a line to `TABLE` with a plain `how`: the translation walks
the table. Attributes with a rule of their own are read where `how` says; their lines serve the
documentation and the list of the attributes that are not read. The unit of a value is that of the
file, never that of the database.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

GEARS = ("cylindrical_gear", "ring_gear")
#: Type of a stage with a sun, planets and a ring, which has a cylindrical stage for each gear mesh.
PLANETARY = "planetary_stage"
PLAIN = "as it is"
#: By the unit in which a scene counts: factors from the units that a file may name. Spellings are
#: those of the database ("mum", "N / mm^2", "°" up to REXS 1.3) and the usual ones beside them.
FACTORS: dict[str, dict[str, float]] = {
    "": {"": 1.0, "none": 1.0},
    "mm": {"mm": 1.0, "m": 1e3, "cm": 10.0, "mum": 1e-3, "um": 1e-3, "µm": 1e-3, "μm": 1e-3},
    "um": {"mum": 1.0, "um": 1.0, "µm": 1.0, "μm": 1.0, "mm": 1e3, "m": 1e6},
    "deg": {"deg": 1.0, "°": 1.0, "rad": 180.0 / pi},
    "N m": {"N m": 1.0, "Nm": 1.0, "N mm": 1e-3, "kN m": 1e3},
    "N/um": {"N / m": 1e-6, "N/m": 1e-6, "N / mm": 1e-3, "N/mm": 1e-3, "N / mum": 1.0},
    "MPa": {"N / mm^2": 1.0, "N/mm^2": 1.0, "MPa": 1.0, "Pa": 1e-6, "GPa": 1e3},
}
#: Digits of a converted number: 0.023 mm is 23 um, not 23.000000000000004.
DIGITS = 14


@dataclass(frozen=True)
class Entry:
    """An attribute that is read, of components of some types.

    `in_file` is its unit in the database, for attributes to which the file gives no unit; `key` is
    the key of the scene, in which `body` is `body_1` or `body_2`; `how` is `PLAIN`, or the rule.
    """

    types: tuple[str, ...]
    attribute: str
    in_file: str
    key: str
    how: str = PLAIN

    @property
    def unit(self) -> str:
        """Unit of the scene key, as in `FACTORS`."""
        unit = "N/um" if self.key.endswith("_N_per_um") else self.key.rpartition("_")[2]
        return unit if unit in FACTORS else ""


FLANK, TOOL, MATERIAL = ("cylindrical_gear_flank",), ("rack_shaped_tool",), ("material",)
STAGE, OF_GEAR = ("cylindrical_stage",), ("cylindrical_stage_gear_data",)
GEAR, RING = GEARS[:1], GEARS[1:]
TIP, PROFILE, HELIX = ("tip_relief",), ("profile_crowning",), ("helix_crowning",)
ROOT, MADE = ("root_relief",), ("cylindrical_gear_manufacturing_settings",)
LOAD = ("external_load",)
BEARING = (
    *("rolling_bearing_with_catalog_geometry", "rolling_bearing_with_detailed_geometry"),
    "concept_bearing",
)
ENDS = ("end_relief_datum_face", "end_relief_non_datum_face")


def _of(types: tuple[str, ...], *rows: tuple[str, ...]) -> tuple[Entry, ...]:
    """Entries of components of these types from their other fields."""
    return tuple(Entry(types, *row) for row in rows)


TABLE = (
    *_of(GEARS,
        ("number_of_teeth", "", "body.teeth", "of a ring gear without its sign"),
        ("normal_module", "mm", "body.module_mm"),
        ("tip_diameter", "mm", "body.tip_diameter_mm"),
    ),
    *_of(GEAR, ("inner_diameter", "mm", "body.bore_diameter_mm")),
    *_of(RING, ("root_diameter", "mm", "body.root_diameter_mm")),
    *_of(GEAR,
        ("root_diameter", "mm", "body.dedendum_factor",
         "(d - d_f) / (2 m_n) + x, with the reference diameter d"),
    ),
    *_of(GEARS,
        ("helix_angle_reference_diameter", "deg", "body.helix_angle_deg, body.hand",
         "amount, and hand by the sign: positive is right-hand"),
        ("face_width", "mm", "pair.face_width_mm, body.face_width_mm",
         "common width; own width of a gear if it is another"),
        ("support_vector", "mm", "body_2.axial_offset_mm",
         ("distance of the gears along the axis, with u_axis_vector and "
          "reference_component_for_position")),
        ("u_axis_vector", "mm", "body_2.axial_offset_mm", "see support_vector"),
        ("reference_component_for_position", "", "body_2.axial_offset_mm", "see support_vector"),
        ("datum_face_orientation", "", "body.end_relief_um",
         "side of the datum face on the u axis"),
    ),
    *_of(GEAR,
        ("upper_backlash_allowance_referenced_to_span", "mum", "body.tooth_thickness_allowance_um",
         "mean of both over cos of the pressure angle; not with a coefficient after finishing"),
        ("lower_backlash_allowance_referenced_to_span", "mum", "body.tooth_thickness_allowance_um",
         "see the upper one"),
    ),
    *_of(FLANK,
        ("normal_pressure_angle", "deg", "body.pressure_angle_deg"),
        ("addendum_modification_coefficient", "", "body.profile_shift",
         "of a ring gear with the sign that the centre distance requires"),
        ("addendum_modification_coefficient_after_finishing", "", "body.profile_shift",
         "in place of addendum_modification_coefficient"),
        ("addendum_modification", "mm", "body.profile_shift",
         "over the module, if there is no coefficient"),
        ("tooth_tip_chamfer", "mm", "body.tip_chamfer_mm", "if it is not 0"),
    ),
    *_of(TOOL,
        ("addendum_coefficient_reference_profile", "", "body.dedendum_factor",
         "if the gear has no root_diameter"),
        ("tip_radius_factor", "", "body.fillet_radius_factor"),
        ("protuberance_amount", "mm", "body.protuberance_mm", "if it is not 0"),
        ("protuberance_angle", "deg", "body.protuberance_angle_deg", "with a protuberance"),
    ),
    *_of(MADE, ("machining_allowance", "mm", "body.grinding_stock_mm", "with a protuberance")),
    *_of(TIP,
        ("tip_relief_depth", "mm", "body.tip_relief_um",
         "amount at the tip circle, over the roll length if it is given elsewhere"),
        ("tip_relief_datum_diameter", "mm", "body.tip_relief_start_diameter_mm"),
        ("tip_relief_evaluation_reference", "mm", "body.tip_relief_um", "diameter of the amount"),
        ("shape_of_relief", "", "body.tip_relief_shape", "linear, parabolic; no other"),
    ),
    *_of(ROOT,
        ("root_relief_depth", "mm", "body.root_relief_um", "amount at the form circle"),
        ("root_relief_datum_diameter", "mm", "body.root_relief_start_diameter_mm"),
        ("root_relief_evaluation_reference", "mm", "body.root_relief_um",
         "must be the root_form_diameter of the gear"),
        ("shape_of_relief", "", "body.root_relief_shape", "linear, parabolic; no other"),
    ),
    *_of(PROFILE,
        ("profile_crowning_at_tip", "mm", "body.profile_crowning_um", "if both amounts are equal"),
        ("profile_crowning_at_root", "mm", "body.profile_crowning_um", "if both amounts are equal"),
    ),
    *_of(HELIX,
        ("helix_crowning_amount_datum_face", "mm", "body.lead_crowning_um",
         "if both amounts are equal"),
        ("helix_crowning_amount_non_datum_face", "mm", "body.lead_crowning_um",
         "if both amounts are equal"),
        ("coordinate_where_helix_crowning_is_specified_datum_face", "mm", "body.lead_crowning_um",
         "its distance from the other one must be the face width"),
        ("coordinate_where_helix_crowning_is_specified_non_datum_face", "mm",
         "body.lead_crowning_um", "see the other coordinate"),
    ),
    *_of(ENDS[:1],
        ("end_relief_depth_datum_face", "mm", "body.end_relief_um", "at the end of the datum face"),
        ("end_relief_length_datum_face", "mm", "body.end_relief_length_mm",
         "at the end of the datum face"),
        ("end_relief_evaluation_reference_datum_face", "mm", "body.end_relief_um",
         "must be an end of the face width, counted from an end or from the middle"),
    ),
    *_of(ENDS[1:],
        ("end_relief_depth_non_datum_face", "mm", "body.end_relief_um", "at the other end"),
        ("end_relief_length_non_datum_face", "mm", "body.end_relief_length_mm", "at the other end"),
        ("end_relief_evaluation_reference_non_datum_face", "mm", "body.end_relief_um",
         "as at the datum face"),
    ),
    *_of(ENDS,
        ("shape_of_relief", "", "body.end_relief_shape",
         "linear, parabolic; no other, and the same at both ends"),
    ),
    *_of(MATERIAL,
        ("elastic_modulus", "N / mm^2", "body.young_modulus_MPa"),
        ("poisson_ratio", "", "body.poisson_ratio"),
    ),
    *_of(STAGE,
        ("center_distance", "mm", "pair.center_distance_mm", "of a ring gear without its sign"),
        ("common_face_width", "mm", "pair.face_width_mm",
         "otherwise the overlap of both face widths"),
    ),
    *_of(OF_GEAR,
        ("loaded_tooth_flank", "", "",
         "left or right: flank with the profile and its modifications"),
        ("torque", "N m", "load.torque_Nm", "amount; of gear 2 by the ratio of the teeth"),
    ),
    *_of(BEARING,
        ("radial_stiffness", "N / m", "stage.pin_stiffness_N_per_um",
         "of a planet, sum of its bearings"),
        ("radial_bearing_clearance", "mum", "stage.pin_clearance_um",
         "of a planet, before mounting, largest of its bearings"),
    ),
    *_of(LOAD,
        ("torque_around_u_axis", "N m", "load.torque_Nm",
         "amount, if it is the only torque on a shaft with one gear of one stage"),
    ),
)  # fmt: skip

#: Unit of each attribute in the database.
UNITS = {entry.attribute: entry.in_file for entry in TABLE} | {"root_form_diameter": "mm"}

#: Attributes that are not read, by the reason; any other attribute has no key in a scene.
NOT_READ = {
    "position in the gear unit": ("w_axis_vector", "u_coordinate_on_shaft"),
    "follows from the keys of the scene": (
        "axial_module", "axial_pitch", "base_circle_diameter", "gear_ratio",
        "helix_angle_base_circle", "pressure_angle_in_the_transverse_section",
        "reference_circle_diameter", "root_form_diameter", "tooth_depth",
        "sum_of_addendum_modification_coefficients", "transverse_base_pitch", "transverse_module",
        "transverse_circular_pitch_on_reference_circle", "normal_circular_pitch",
        "normal_base_pitch", "virtual_number_of_teeth",
    ),
    "tolerances and allowances are not read": (
        "center_distance_tolerance_field_din_3964_1980", "lower_center_distance_allowance",
        "upper_center_distance_allowance", "single_pitch_deviation",
        "lower_backlash_allowance_balls_or_pins", "upper_backlash_allowance_balls_or_pins",
        "tolerance_class_according_to_iso_1328_2013", "runout_tolerance",
        "tooth_thickness_deviation_tolerance_series_din_3967_1978",
    ),
    "the public database does not define the origin of this coordinate": (
        "facewidth_usable_end", "facewidth_usable_start", "helix_evaluation_end",
        "helix_evaluation_start", "helix_highest_point", "position_of_profile_modification",
    ),
    "the public database does not define its meaning; amounts are taken as metal removed": (
        "is_additive_modification",
    ),
    "the public database does not define its sign": ("helix_slope",),
    "over some um an arc and a parabola are the same": (
        "shape_of_helix_crowning", "shape_of_profile_crowning",
    ),
    "GDE files are not read": ("gde_file",),
    "the start of the relief is read as a diameter": ("tip_relief_datum_length",),
    "body 1 carries the torque in either case": ("is_driving_gear",),
    "no part of the geometry": ("data_source",),
}  # fmt: skip
REASONS = {attribute: why for why, attributes in NOT_READ.items() for attribute in attributes}
NO_KEY = "flankload has no key for it"
#: Reasons for which whole components are not read; any other one is not part of the stage.
REASONS_OF_TYPES = {
    "shaft": "shafts are not read",
    "shaft_section": "shafts are not read",
    "gear_casing": "a scene has no casing",
    "gear_unit": "a scene is one stage",
    "lubricant": "a scene has no lubricant",
}
NOT_OF_STAGE = "not part of this stage"


def reason_for(attribute: str) -> str:
    """The reason for which an attribute is not read."""
    if attribute.startswith("custom_"):
        return "an attribute of the program that wrote the file"
    return REASONS.get(attribute, NO_KEY)


def reason_for_type(kind: str) -> str:
    """The reason for which components of a type are not read."""
    if "bearing" in kind:
        return "only bearings of planets are read"
    return REASONS_OF_TYPES.get(kind, NOT_OF_STAGE)


def converted(value: float, unit: str, wanted: str) -> float | None:
    """A number in the unit of a scene, a key of `FACTORS`; None for another kind of unit."""
    factor = FACTORS[wanted].get(" ".join(unit.split()))
    if factor is None:
        return None
    return value if factor == 1.0 else float(f"{value * factor:.{DIGITS}g}")
