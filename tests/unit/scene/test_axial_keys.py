"""Keys along the axis: a three-dimensional scene is recognized, and contradictions are refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.scene.effects import effects_of, switches_of
from flankload.scene.plane_section import plane_section
from tests.support.gear_scenes import RING, changed, one_line
from tests.support.three_dimensional import tree_of

HELICAL = {
    "body_1__helix_angle_deg": 15,
    "body_1__hand": "right",
    "body_2__helix_angle_deg": 15,
    "body_2__hand": "left",
}
WEB = {"web_width_mm": 4, "rim_thickness_mm": 5}
HUB = {"hub_width_mm": 20, "hub_diameter_mm": 38}


@pytest.mark.parametrize(
    ("changes", "because"),
    [
        (HELICAL, "body_1.helix_angle_deg"),
        ({"effects__dimension": 3}, "effects.dimension = 3"),
        ({"body_2__lead_crowning_um": 5}, "body_2.lead_crowning_um"),
        ({"body_1__helix_slope_um": -5}, "body_1.helix_slope_um"),
        (
            {"body_1__end_relief_um": [0, 5], "body_1__end_relief_length_mm": [2, 2]},
            "body_1.end_relief_um",
        ),
        ({"body_1__profile_twist_um": -5}, "body_1.profile_twist_um"),
        ({"body_2__topography_file": "flank.csv"}, "body_2.topography_file"),
        (
            {"body_1__tooth_helix_slope_um": [0.0] * 15 + [-1.0]},
            "body_1.tooth_helix_slope_um",
        ),
        ({"body_1__face_width_mm": 15}, "body_1.face_width_mm"),
        ({"body_1__axial_offset_mm": 1}, "body_1.axial_offset_mm"),
        ({f"body_1__{key}": value for key, value in WEB.items()}, "body_1.web_width_mm"),
        ({f"body_2__{key}": value for key, value in HUB.items()}, "body_2.hub_width_mm"),
        ({"pair__inclination_um_per_mm": 0.1}, "pair.inclination_um_per_mm"),
        ({"pair__deviation_um_per_mm": -0.1}, "pair.deviation_um_per_mm"),
    ],
)
def test_a_key_along_the_axis_requires_three_dimensions(
    changes: dict[str, Any], because: str
) -> None:
    scene = fl.Scene.from_dict(changed(**changes))
    assert effects_of(scene).three_dimensions
    assert switches_of(scene)["three_dimensions"].because == because
    assert scene.effects.contact == "lumped"
    assert not effects_of(plane_section(scene)).three_dimensions


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"effects__dimension": 2},
        {"body_1__helix_angle_deg": 0, "body_1__lead_crowning_um": 0, "body_2__helix_slope_um": 0},
        {"body_1__face_width_mm": 14, "body_2__face_width_mm": 14},
        {"body_1__end_relief_um": [0, 0], "body_1__end_relief_length_mm": [2, 2]},
        {"body_1__profile_twist_um": 0, "body_2__tooth_helix_slope_um": [0.0] * 16},
    ],
)
def test_a_scene_without_variation_along_the_axis_is_plane(changes: dict[str, Any]) -> None:
    scene = fl.Scene.from_dict(changed(**changes))
    assert not effects_of(scene).three_dimensions
    assert scene.effects.contact == "pairs"


REGIONS = {"region_sets": ["WEB", "HUB"], "region_widths_mm": [4, 20]}
WHOLE = {"kind": "mesh", "file": "a.msh", "flank_sets": ["A", "B", "C"], "reference_radius_mm": 50}
SECTOR = {"kind": "mesh", "file": "a.msh", "teeth": 24, "reference_radius_mm": 50.743}
#: Its transverse section is that of the gears with a helix of 15 degrees.
PROFILED = {
    "kind": "mesh",
    "file": "a.msh",
    "teeth": 24,
    "profile": {
        "module_mm": 4.5 / float(np.cos(np.radians(15))),
        "pressure_angle_deg": float(np.degrees(np.arctan(np.tan(np.pi / 9) / np.cos(np.pi / 12)))),
        "tip_diameter_mm": 118.36,
    },
}


def test_helices_of_gears_and_meshes_have_one_lead_per_tooth() -> None:
    on_base = float(np.degrees(np.arctan(np.sin(np.radians(15)) / 4.5 * 50.743 / 12)))
    for wheel in (SECTOR | {"helix_angle_deg": on_base}, PROFILED | {"helix_angle_deg": 15.0}):
        scene = fl.Scene.from_dict(changed(**HELICAL | {"body_2": wheel | {"hand": "left"}}))
        assert effects_of(scene).three_dimensions


CROWNED = {"body_1__lead_crowning_um": 5}


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        (
            {"body_1__helix_angle_deg": 15},
            "body_1.hand",
            "'right' or 'left', since there is a body_1.helix_angle_deg",
            "nothing",
        ),
        (
            {"body_1__hand": "right"},
            "body_1.hand",
            "nothing, unless body_1.helix_angle_deg is > 0",
            "'right'",
        ),
        ({"body_1__helix_angle_deg": 41}, "body_1.helix_angle_deg", "a number from 0 to 40", "41"),
        (
            {**HELICAL, "body_2__hand": "right"},
            "body_2.hand",
            "'left', the opposite of body_1.hand",
            "'right'",
        ),
        (
            {**HELICAL, "body_2__helix_angle_deg": 16},
            "body_2.helix_angle_deg",
            "15, as in body_1.helix_angle_deg (parallel axes)",
            "16.0",
        ),
        (
            {"body_2__axial_offset_mm": 14},
            "body_2.axial_offset_mm",
            "an offset at which the face widths overlap: body_1 extends from -7 to 7 mm",
            "14, where body_2 extends from 7 to 21 mm",
        ),
        (
            {"body_1__end_relief_um": [5, 5]},
            "body_1.end_relief_length_mm",
            "a list of 2 numbers, since there is a body_1.end_relief_um",
            "nothing",
        ),
        (
            {"body_1__end_relief_um": [5, 5], "body_1__end_relief_length_mm": [2, 15]},
            "body_1.end_relief_length_mm[1]",
            "at most the face width of the body, 14",
            "15.0",
        ),
        (
            {"body_1__tooth_helix_slope_um": [1, 2]},
            "body_1.tooth_helix_slope_um",
            "one entry per tooth: 16, as in body_1.teeth",
            "2 entries",
        ),
        (
            {"body_2": SECTOR | {"tooth_helix_slope_um": [1, 2]}},
            "body_2.tooth_helix_slope_um",
            "one entry per tooth: 24, as in body_2.teeth",
            "2 entries",
        ),
        (
            {"body_1__tooth_helix_slope_um": [[1.0]] * 16},
            "body_1.tooth_helix_slope_um[0]",
            "a number from -1e+06 to 1e+06",
            "[1.0]",
        ),
        (
            {"body_1__profile_twist_um": "much"},
            "body_1.profile_twist_um",
            "a number from -1e+06 to 1e+06",
            "'much'",
        ),
        (
            {"body_1__topography_file": ""},
            "body_1.topography_file",
            "a non-empty string",
            "''",
        ),
        (
            {"body_1__topography_file": "flank.csv", "effects__dimension": 2},
            "effects.dimension",
            "3 or nothing, since there is a body_1.topography_file",
            "2",
        ),
        (
            {**CROWNED, "effects__dimension": 2},
            "effects.dimension",
            "3 or nothing, since there is a body_1.lead_crowning_um",
            "2",
        ),
        (
            {"accuracy__slices": 10},
            "accuracy.slices",
            "nothing in a plane scene (effects.dimension = 3 makes it three-dimensional)",
            "10",
        ),
        (
            {**CROWNED, "accuracy__load_degree_z": 5},
            "accuracy.load_degree_z",
            "at most 4, 4 less than accuracy.axial_degree (8)",
            "5",
        ),
        (
            {"effects__dimension": 3, "effects__root_stress": True, "body_2": WHOLE},
            "effects.root_stress",
            (
                "false, since effects.dimension = 3 requires three dimensions, where body_2 needs "
                "the mesh of a sector for it (body_2.flank_sets names the flanks of a whole body)"
            ),
            "true",
        ),
        (
            {"body_2": WHOLE | REGIONS},
            "body_2.region_sets",
            "nothing beside body_2.flank_sets: a whole body is as wide as its teeth",
            "['WEB', 'HUB']",
        ),
        (
            {**HELICAL, "body_2": SECTOR | {"hand": "left", "helix_angle_deg": 15}},
            "body_2.helix_angle_deg",
            (
                "13.669423, which on its reference circle has the lead per tooth of body_1 "
                "(parallel axes)"
            ),
            "15.0",
        ),
        (
            {"body_1": SECTOR | {"helix_angle_deg": 10}},
            "body_1.hand",
            "'right' or 'left', since there is a body_1.helix_angle_deg",
            "nothing",
        ),
    ],
)
def test_contradictions_get_one_line(
    changes: dict[str, Any], key: str, expected: str, found: str
) -> None:
    one_line(changes, key, expected, found)


WEBBED = {f"body_1__{key}": value for key, value in WEB.items()}
WITH_HUB = WEBBED | {f"body_1__{key}": value for key, value in HUB.items()}


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        (
            {**WEBBED, "body_1__web_outer_diameter_mm": 50},
            "body_1.rim_thickness_mm",
            "nothing beside body_1.web_outer_diameter_mm",
            "5.0",
        ),
        (
            {"body_1__web_width_mm": 4},
            "body_1.web_outer_diameter_mm",
            "a number > 0, since there is a body_1.web_width_mm",
            "nothing",
        ),
        (
            {"body_1__rim_thickness_mm": 4},
            "body_1.web_width_mm",
            "a number > 0, since there is a body_1.rim_thickness_mm",
            "nothing",
        ),
        (
            {"body_1__web_offset_mm": 1},
            "body_1.web_width_mm",
            "a number > 0, since there is a body_1.web_offset_mm",
            "nothing",
        ),
        (
            {"body_1__hub_width_mm": 4},
            "body_1.hub_diameter_mm",
            "a number > 0, since there is a body_1.hub_width_mm",
            "nothing",
        ),
        (
            {"body_1__hub_diameter_mm": 40},
            "body_1.hub_width_mm",
            "a number > 0, since there is a body_1.hub_diameter_mm",
            "nothing",
        ),
        (
            {**WEBBED, "body_1__web_width_mm": 0},
            "body_1.web_width_mm",
            "a number from 0.001 to 100000",
            "0",
        ),
        (
            {**WEBBED, "body_1__web_width_mm": 15},
            "body_1.web_width_mm",
            "a web within the face width (from -7 to 7 mm)",
            "15 (from -7.5 to 7.5 mm)",
        ),
        (
            {**WEBBED, "body_1__web_offset_mm": -5.5, "body_1__axial_offset_mm": 1},
            "body_1.web_width_mm",
            "a web within the face width (from -6 to 8 mm)",
            "4 (from -6.5 to -2.5 mm)",
        ),
        (
            {**WITH_HUB, "body_1__hub_offset_mm": 9},
            "body_1.hub_width_mm",
            "a hub that contains or is within the web (from -2 to 2 mm)",
            "20 (from -1 to 19 mm)",
        ),
        (
            {**WEBBED, "effects__dimension": 2},
            "effects.dimension",
            "3 or nothing, since there is a body_1.web_width_mm",
            "2",
        ),
        (
            {"body_2": RING | {"hub_width_mm": 3}, "pair__center_distance_mm": 99},
            "body_2.hub_width_mm",
            "no such key, since this version does not simulate webs and hubs of these bodies",
            "3",
        ),
        (
            {"body_2": RING | {"web_width_mm": 3}, "pair__center_distance_mm": 99},
            "body_2.web_inner_diameter_mm",
            "a number > 0, since there is a body_2.web_width_mm",
            "nothing",
        ),
        (
            {
                "body_2": RING | {"web_width_mm": 14, "rim_thickness_mm": 5, "web_offset_mm": 1},
                "pair__center_distance_mm": 99,
            },
            "body_2.web_width_mm",
            "a web that contains or is within the face width (from -7 to 7 mm)",
            "14 (from -6 to 8 mm)",
        ),
        (
            {"body_1": SECTOR | REGIONS | {"region_widths_mm": [4]}},
            "body_1.region_widths_mm",
            "a list of 2 numbers, one for each of body_1.region_sets",
            "[4.0]",
        ),
        (
            {"body_1": SECTOR | {"region_widths_mm": [4]}},
            "body_1.region_sets",
            "a list of names, since there is a body_1.region_widths_mm",
            "nothing",
        ),
        (
            {"body_1": SECTOR | REGIONS | {"region_sets": ["WEB", "WEB"]}},
            "body_1.region_sets[1]",
            "each set once",
            "'WEB'",
        ),
    ],
)
def test_webs_and_hubs_that_cannot_be_get_one_line(
    changes: dict[str, Any], key: str, expected: str, found: str
) -> None:
    one_line(changes, key, expected, found)


def test_cams_are_plane() -> None:
    with pytest.raises(fl.SceneError) as caught:
        fl.Scene.from_dict(tree_of("cam", {"effects__dimension": 3}))
    assert caught.value.key == "body_1.kind"
    assert caught.value.expected.startswith("'gear', 'ring', 'mesh', 'compliance' or a spline")


def test_webs_and_hubs_have_places_along_the_axis() -> None:
    scene = fl.Scene.from_dict(
        changed(**WITH_HUB, body_1__web_offset_mm=5, body_1__hub_offset_mm=-1)
    )
    gear = scene.body_1
    assert gear.regions_of((-7.0, 7.0)) == (("web", (3.0, 7.0)), ("hub", (-11.0, 9.0)))
    assert gear.regions_of((3.0, 17.0)) == (("web", (13.0, 17.0)), ("hub", (-1.0, 19.0)))
    # from outside, regions as wide as the teeth belong to the rim; inside they do not
    wide = fl.Scene.from_dict(changed(**(WITH_HUB | {"body_1__web_width_mm": 14}))).body_1
    assert wide.regions_of((-7.0, 7.0)) == (("hub", (-10.0, 10.0)),)
    assert wide.regions_of((0.1, 14.1)) == (("hub", (7.1 - 10.0, 7.1 + 10.0)),)
    between = fl.Scene.from_dict(changed(**(WITH_HUB | {"body_1__hub_width_mm": 14}))).body_1
    assert between.regions_of((-7.0, 7.0)) == (("web", (-2.0, 2.0)), ("hub", (-7.0, 7.0)))
