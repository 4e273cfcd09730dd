"""The scene of a REXS stage: geometry, modifications, flanks, positions, load, omissions."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from flankload.errors import SceneError
from flankload.exchange.rexs import Choices, Translation, read_model, scene_of_stage
from flankload.exchange.rexs.attributes import TABLE
from flankload.scene import read_scene, scene_paths
from tests.support.paths import DOCS, SCENES
from tests.support.rexs_files import (
    EXAMPLE,
    TEXT,
    added,
    attribute_line,
    changed,
    in_json,
    spur,
    without,
    written,
    zipped,
)

RING = {"body_2.outer_diameter_mm": 220}


def made(folder: Path, text: str = TEXT, stage: int = 21, **choices: Any) -> Translation:
    model = read_model(written(folder, text))
    return scene_of_stage(model, Choices(stage=stage, **choices))


def keys(translation: Translation) -> dict[str, Any]:
    return translation.scene.to_dict()


def refused(folder: Path, text: str, stage: int = 21, **choices: Any) -> str:
    with pytest.raises(SceneError) as caught:
        made(folder, text, stage, **choices)
    line = str(caught.value)
    assert line.startswith(f"{folder / 'box.rexs'}: ")
    assert "\n" not in line
    return line.removeprefix(f"{folder / 'box.rexs'}: ")


def of_example(name: str) -> dict[str, Any]:
    return read_scene(SCENES / f"{name}.toml").to_dict()


# --- the three kinds of stages --------------------------------------------------------------------
def test_a_helical_stage_is_the_scene_of_its_values(tmp_path: Path) -> None:
    wanted = of_example("helical_gear")
    del wanted["positions"]
    wanted["name"] = "helical stage"
    wanted["body_1"] |= {"end_relief_um": [6.0, 0.0], "end_relief_length_mm": [3.0, 3.0]}
    assert keys(made(tmp_path)) == wanted


def test_an_internal_stage_is_the_scene_of_its_values(tmp_path: Path) -> None:
    wanted = of_example("internal_gear")
    del wanted["positions"]
    wanted["name"] = "planet and ring"
    for body in ("body_1", "body_2"):
        del wanted[body]["tip_radius_mm"]
    wanted["body_2"]["face_width_mm"] = 22.0
    assert keys(made(tmp_path, stage=22, settings=RING)) == wanted


def test_a_spur_stage_in_the_names_of_older_versions(tmp_path: Path) -> None:
    wanted = of_example("external_gear")
    del wanted["positions"]
    made_up = keys(made(tmp_path, spur(), stage=9))
    assert made_up == wanted
    assert keys(made(tmp_path, spur("-302000", "N mm"), stage=9)) == wanted


def test_xml_json_and_archives_of_one_model_give_the_same_scene(tmp_path: Path) -> None:
    forms = {
        "box.rexs": EXAMPLE.read_bytes(),
        "box.rexsj": in_json(TEXT).encode(),
        "marked.rexs": b"\xef\xbb\xbf" + EXAMPLE.read_bytes(),
        "box.rexsz": zipped(box_rexs=TEXT, mesh_inp="*NODE"),
        "box.rexs.zip": zipped(box_rexsj=in_json(TEXT)),
    }
    found = [
        scene_of_stage(read_model(written(tmp_path, content, name)), Choices(stage=21))
        for name, content in forms.items()
    ]
    assert len({repr(one.scene.to_dict()) for one in found}) == 1
    assert len({one.lines for one in found}) == 1


def test_a_namespace_changes_nothing(tmp_path: Path) -> None:
    spaced = TEXT.replace("<model ", '<model xmlns="http://www.rexs.info" ', 1)
    assert keys(made(tmp_path, spaced)) == keys(made(tmp_path))


def test_the_gear_that_is_a_ring_is_the_second_body(tmp_path: Path) -> None:
    swapped = TEXT.replace('id="13" role="gear_1"', 'id="14" role="gear_1"', 1)
    swapped = swapped.replace('id="14" role="gear_2"', 'id="13" role="gear_2"', 1)
    assert swapped != TEXT
    there = keys(made(tmp_path, stage=22, settings=RING))
    assert keys(made(tmp_path, swapped, stage=22, settings=RING)) == there


# --- units and signs ------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("attribute", "component", "value", "unit"),
    [
        ("normal_module", 11, "0.003", "m"),
        ("tip_diameter", 11, "84800", "mum"),
        ("helix_angle_reference_diameter", 11, "0.2617993877991494", "rad"),
        ("helix_angle_reference_diameter", 12, "-15", "°"),
        ("tip_relief_depth", 51, "20", "um"),
        ("tip_relief_depth", 51, "20", "mum"),
        ("helix_crowning_amount_datum_face", 52, "4e-06", "m"),
        ("torque_around_u_axis", 81, "0.25", "kN m"),
        ("elastic_modulus", 72, "206", "GPa"),
        ("center_distance", 21, "13.2", "cm"),
    ],
)
def test_numbers_are_in_the_unit_of_the_file(
    tmp_path: Path, attribute: str, component: int, value: str, unit: str
) -> None:
    line = f'<attribute id="{attribute}" unit="{unit}">{value}</attribute>'
    assert keys(made(tmp_path, changed(attribute, component, line))) == keys(made(tmp_path))


def test_an_attribute_without_unit_has_that_of_the_database(tmp_path: Path) -> None:
    text = re.sub(r' unit="[^"]*"', "", TEXT)
    assert keys(made(tmp_path, text)) == keys(made(tmp_path))


def test_an_empty_unit_is_none(tmp_path: Path) -> None:
    assert keys(made(tmp_path, TEXT.replace('unit="none"', 'unit=""'))) == keys(made(tmp_path))


def test_the_sign_of_the_helix_angle_is_its_hand(tmp_path: Path) -> None:
    other = TEXT.replace(">15<", ">+<").replace(">-15<", ">15<").replace(">+<", ">-15<")
    found = keys(made(tmp_path, other))
    assert (found["body_1"]["hand"], found["body_2"]["hand"]) == ("left", "right")
    assert found["body_1"]["helix_angle_deg"] == 15


@pytest.mark.parametrize("sign", [1, -1])
def test_a_ring_may_have_any_sign(tmp_path: Path, sign: int) -> None:
    """Teeth, profile shift and centre distance of a ring are negative in some programs."""
    text = TEXT
    for number in (47, 48):
        shift = "addendum_modification_coefficient"
        text = changed(shift, number, attribute_line(shift, "none", 0.3 * sign), text)
    if sign < 0:
        line = '<attribute id="number_of_teeth" unit="none">-60</attribute>'
        text = changed("number_of_teeth", 14, line, text)
        line = '<attribute id="center_distance" unit="mm">-53.93</attribute>'
        text = changed("center_distance", 22, line, text)
    body = keys(made(tmp_path, text, 22, settings=RING))["body_2"]
    assert (body["teeth"], body["profile_shift"]) == (60, 0.3)


def test_a_shift_of_a_ring_whose_sign_is_open_is_refused(tmp_path: Path) -> None:
    text = TEXT.replace(">0.3<", ">0<").replace(">53.93<", ">54<")
    line = refused(tmp_path, text, 22, settings=RING)
    assert line.startswith("ring_gear 14: addendum_modification_coefficient: expected ")


def test_a_ring_without_a_helix_angle_is_spur(tmp_path: Path) -> None:
    text = without("helix_angle_reference_diameter", 14)
    wanted = keys(made(tmp_path, stage=22, settings=RING))
    assert keys(made(tmp_path, text, 22, settings=RING)) == wanted


@pytest.mark.parametrize("sign", [1, -1])
def test_a_helical_ring_has_the_hand_of_its_planet(tmp_path: Path, sign: int) -> None:
    """The sign of its profile shift follows from the transverse section."""
    name, shift = "helix_angle_reference_diameter", "addendum_modification_coefficient"
    text = TEXT.replace(">53.93<", ">55.84<")
    for number in (13, 14):
        text = changed(name, number, attribute_line(name, "deg", 15), text)
    for number in (47, 48):
        text = changed(shift, number, attribute_line(shift, "none", 0.3 * sign), text)
    found = keys(made(tmp_path, text, 22, settings=RING))
    for body in ("body_1", "body_2"):
        assert (found[body]["helix_angle_deg"], found[body]["hand"]) == (15.0, "right")
    assert found["body_2"]["profile_shift"] == 0.3


def test_a_ring_of_the_other_hand_is_refused(tmp_path: Path) -> None:
    name, text = "helix_angle_reference_diameter", TEXT
    for number, angle in ((13, 15), (14, -15)):
        text = changed(name, number, attribute_line(name, "deg", angle), text)
    found = refused(tmp_path, text.replace(">53.93<", ">55.84<"), 22, settings=RING)
    assert found.startswith("body_2.hand: expected 'right', as body_1.hand")


# --- root, profile, material ----------------------------------------------------------------------
def test_the_root_diameter_goes_before_the_tool(tmp_path: Path) -> None:
    # d = 25 * 3 / cos 15 deg; depth of a rack of 1.4 modules below the shifted reference line
    root = 25 * 3 / 0.9659258262890683 - 2 * 3 * (1.4 - 0.2)
    text = added(11, f'<attribute id="root_diameter" unit="mm">{root}</attribute>')
    found = made(tmp_path, text)
    assert keys(found)["body_1"]["dedendum_factor"] == pytest.approx(1.4, rel=1e-9)
    assert any("rack_shaped_tool 71: addendum_coefficient" in line for line in found.lines)


def test_the_tool_determines_the_root(tmp_path: Path) -> None:
    text = TEXT.replace(">1.25<", ">1.4<").replace(">0.38<", ">0.25<")
    body = keys(made(tmp_path, text))["body_2"]
    assert (body["dedendum_factor"], body["fillet_radius_factor"]) == (1.4, 0.25)


def test_defaults_of_a_scene_are_named(tmp_path: Path) -> None:
    lines = made(tmp_path, spur(), stage=9).lines
    for key in ("dedendum_factor", "fillet_radius_factor", "young_modulus_MPa", "poisson_ratio"):
        assert sum(f"default of {key}: " in line for line in lines) == 2


def test_material_and_finished_profile(tmp_path: Path) -> None:
    text = TEXT.replace(">206000<", ">110000<").replace(">0.3</attribute>", ">0.25</attribute>")
    more = attribute_line("addendum_modification_coefficient_after_finishing", "none", 0.19)
    text = added(42, more, text=text)
    text = changed(
        "tooth_tip_chamfer", 42, '<attribute id="tooth_tip_chamfer" unit="mm">0.2</attribute>', text
    )
    found = made(tmp_path, text)
    body = keys(found)["body_1"]
    assert (body["young_modulus_MPa"], body["poisson_ratio"]) == (110000, 0.25)
    assert (body["profile_shift"], body["tip_chamfer_mm"]) == (0.19, 0.2)
    assert any("the coefficient after finishing is taken" in line for line in found.lines)


def test_the_middle_of_the_tolerance_is_the_thickness(tmp_path: Path) -> None:
    """The root keeps its diameter: the rack is as much less deep as the teeth are thinner."""
    name = "_backlash_allowance_referenced_to_span"
    lines = [
        attribute_line(f"{end}{name}", "mum", at) for end, at in (("upper", -60), ("lower", -100))
    ]
    text = added(11, *lines)
    body = keys(made(tmp_path, text))["body_1"]
    cosine, tangent = 0.9396926207859084, 0.36397023426620234
    assert body["tooth_thickness_allowance_um"] == pytest.approx(-80 / cosine, rel=1e-9)
    root = 25 * 3 / 0.9659258262890683 - 2 * 3 * (1.4 - 0.2)
    text = added(11, attribute_line("root_diameter", "mm", root), text=text)
    body = keys(made(tmp_path, text))["body_1"]
    wanted = 1.4 - 0.08 / cosine / (2 * 3 * tangent)
    assert body["dedendum_factor"] == pytest.approx(wanted, rel=1e-9)
    finished = attribute_line("addendum_modification_coefficient_after_finishing", "none", 0.19)
    assert (
        "tooth_thickness_allowance_um"
        not in keys(made(tmp_path, added(42, finished, text=text)))["body_1"]
    )


def test_a_protuberance_with_its_stock(tmp_path: Path) -> None:
    text = added(71, attribute_line("protuberance_amount", "mm", 0.2),
                 attribute_line("protuberance_angle", "deg", 10))  # fmt: skip
    body = keys(made(tmp_path, text))["body_1"]
    assert (body["protuberance_mm"], body["protuberance_angle_deg"]) == (0.2, 10)
    assert "grinding_stock_mm" not in body
    settings = (
        '<component id="73" type="cylindrical_gear_manufacturing_settings">'
        '<attribute id="machining_allowance" unit="mm">STOCK</attribute></component></components>'
    )
    role = '<ref id="71" role="tool" hint="rack_shaped_tool"/>'
    text = text.replace(role, role + '<ref id="73" role="manufacturing_step"/>', 1)
    ground = text.replace("</components>", settings.replace("STOCK", "0.12"))
    found = keys(made(tmp_path, ground))
    assert found["body_1"]["grinding_stock_mm"] == 0.12
    assert "grinding_stock_mm" not in found["body_2"]
    whole = made(tmp_path, text.replace("</components>", settings.replace("STOCK", "0.2")))
    assert "protuberance_mm" not in keys(whole)["body_1"]
    assert any("not more than the machining allowance of 0.2 mm" in line for line in whole.lines)


# --- modifications --------------------------------------------------------------------------------
@pytest.mark.parametrize(("shape", "power"), [("linear", 1), ("parabolic", 2)])
def test_a_tip_relief_that_is_given_below_the_tip(tmp_path: Path, shape: str, power: int) -> None:
    """The relief grows with the roll length, linear or as its square."""
    text = TEXT.replace(">parabolic<", f">{shape}<")
    text = added(
        51, '<attribute id="tip_relief_evaluation_reference" unit="mm">84</attribute>', text=text
    )
    # base circle of 25 teeth of 3 mm at 20 deg and 15 deg: tan(a_t) = tan(20 deg) / cos(15 deg)
    base = 72.6583829
    low, there, tip = (0.5 * (d**2 - base**2) ** 0.5 for d in (82.4, 84.0, 84.8))
    wanted = 20 * ((tip - low) / (there - low)) ** power
    body = keys(made(tmp_path, text))["body_1"]
    assert body["tip_relief_um"] == pytest.approx(wanted, rel=1e-6)
    assert body.get("tip_relief_shape", "linear") == shape


@pytest.mark.parametrize(
    ("component", "attribute", "value", "key", "reason"),
    [
        (51, "shape_of_relief", "logarithmic", "tip_relief_um", "no logarithmic one of 20 um"),
        (51, "tip_relief_depth", "-0.02", "tip_relief_um", "of -20 um"),
        (51, "tip_relief_datum_diameter", "", "tip_relief_um", "it has no tip_relief_depth or"),
        (52, "helix_crowning_amount_datum_face", "0.005", "lead_crowning_um", "the same helix"),
        (53, "shape_of_relief", "exponential", "end_relief_um", "linear or parabolic end"),
        (53, "end_relief_length_datum_face", "", "end_relief_um", "an amount >= 0 and a length"),
        (11, "datum_face_orientation", "", "end_relief_um", "no datum_face_orientation"),
    ],
)
def test_modifications_that_do_not_fit_are_left_out_and_named(
    tmp_path: Path, component: int, attribute: str, value: str, key: str, reason: str
) -> None:
    unit = "none" if value.isalpha() else "mm"
    line = f'<attribute id="{attribute}" unit="{unit}">{value}</attribute>' if value else None
    found = made(tmp_path, changed(attribute, component, line))
    assert key not in keys(found)["body_1"]
    assert any(line.startswith("not taken: ") and reason in line for line in found.lines)


@pytest.mark.parametrize(
    ("component", "lines", "key", "taken"),
    [
        (52, {"coordinate_where_helix_crowning_is_specified_datum_face": 0,
              "coordinate_where_helix_crowning_is_specified_non_datum_face": 25},
         "lead_crowning_um", True),
        (52, {"coordinate_where_helix_crowning_is_specified_datum_face": 1,
              "coordinate_where_helix_crowning_is_specified_non_datum_face": 24},
         "lead_crowning_um", False),
        (53, {"end_relief_evaluation_reference_datum_face": -12.5}, "end_relief_um", True),
        (53, {"end_relief_evaluation_reference_datum_face": 1}, "end_relief_um", False),
    ],
)  # fmt: skip
def test_amounts_along_the_axis_hold_at_the_ends(
    tmp_path: Path, component: int, lines: dict[str, float], key: str, taken: bool
) -> None:
    more = [f'<attribute id="{name}" unit="mm">{at}</attribute>' for name, at in lines.items()]
    assert (key in keys(made(tmp_path, added(component, *more)))["body_1"]) is taken


def test_profile_crowning_and_the_other_end(tmp_path: Path) -> None:
    text = TEXT.replace("end_relief_depth_datum_face", "end_relief_depth_non_datum_face")
    text = text.replace("end_relief_length_datum_face", "end_relief_length_non_datum_face")
    text = text.replace('"end_relief_datum_face"', '"end_relief_non_datum_face"')
    text = text.replace('type="helix_crowning"', 'type="profile_crowning"')
    text = text.replace("helix_crowning_amount_datum_face", "profile_crowning_at_tip")
    text = text.replace("helix_crowning_amount_non_datum_face", "profile_crowning_at_root")
    body = keys(made(tmp_path, text))["body_1"]
    assert body["end_relief_um"] == [0.0, 6.0]
    assert (body["profile_crowning_um"], body.get("lead_crowning_um")) == (4.0, None)


def with_root_relief(*lines: str) -> str:
    part = (
        '<component id="59" type="root_relief"><attribute id="root_relief_depth" unit="mm">0.01'
        '</attribute><attribute id="root_relief_datum_diameter" unit="mm">75</attribute>'
        f"{''.join(lines)}</component></components>"
    )
    relation = '<relation id="900" type="assembly"><ref id="42" role="assembly"/>'
    relation += '<ref id="59" role="part"/>'
    text = TEXT.replace('id="59"', 'id="60"')
    text = text.replace("</relations>", f"{relation}</relation></relations>")
    return text.replace("</components>", part)


def test_root_relief(tmp_path: Path) -> None:
    body = keys(made(tmp_path, with_root_relief()))["body_1"]
    assert (body["root_relief_um"], body["root_relief_start_diameter_mm"]) == (10, 75)
    at = attribute_line("root_relief_evaluation_reference", "mm", 72.9)
    found = made(tmp_path, with_root_relief(at))
    assert "root_relief_um" not in keys(found)["body_1"]
    assert any("not given at the root_form_diameter" in line for line in found.lines)
    other = attribute_line("root_form_diameter", "mm", 73.4)
    text = added(11, other, text=with_root_relief(at))
    assert "root_relief_um" not in keys(made(tmp_path, text))["body_1"]
    form = attribute_line("root_form_diameter", "mm", 72.9)
    shape = attribute_line("shape_of_relief", "none", "parabolic")
    body = keys(made(tmp_path, added(11, form, text=with_root_relief(at, shape))))["body_1"]
    assert (body["root_relief_um"], body["root_relief_shape"]) == (10, "parabolic")


def test_a_modification_with_two_relations_is_one(tmp_path: Path) -> None:
    relation = (
        '<relation id="900" type="reference"><ref id="42" role="origin"/>'
        '<ref id="51" role="referenced"/></relation></relations>'
    )
    assert made(tmp_path, TEXT.replace("</relations>", relation)).lines == made(tmp_path).lines


# --- flanks ---------------------------------------------------------------------------------------
def test_the_loaded_flank_has_the_profile(tmp_path: Path) -> None:
    left = TEXT.replace(">right<", ">left<")
    body = keys(made(tmp_path, left))["body_1"]
    assert "tip_relief_um" not in body
    assert "lead_crowning_um" not in body


def test_flanks_that_differ_need_a_loaded_one(tmp_path: Path) -> None:
    text = without("loaded_tooth_flank", 31)
    line = refused(tmp_path, text)
    assert line.startswith("cylindrical_gear 11: loaded_tooth_flank: expected left or right")
    assert keys(made(tmp_path, text, flank="right")) == keys(made(tmp_path))


# --- positions and widths -------------------------------------------------------------------------
def shifted(wheel: str, axis: str = "<c>1</c><c>0</c><c>0</c>") -> str:
    text = changed(
        "support_vector", 12,
        f'<attribute id="support_vector" unit="mm"><array>{wheel}</array></attribute>',
    )  # fmt: skip
    return changed(
        "u_axis_vector", 12,
        f'<attribute id="u_axis_vector" unit="mm"><array>{axis}</array></attribute>', text,
    )  # fmt: skip


@pytest.mark.parametrize("offset", [2, -2])
def test_positions_along_the_axis(tmp_path: Path, offset: int) -> None:
    """Each gear may end before the other, at either side."""
    text = shifted(f"<c>{40 + offset}</c><c>0</c><c>-132</c>")
    assert keys(made(tmp_path, text))["body_2"]["axial_offset_mm"] == offset
    found = keys(made(tmp_path, without("common_face_width", 21, text)))
    assert found["pair"]["face_width_mm"] == 23
    assert [found[body]["face_width_mm"] for body in ("body_1", "body_2")] == [25, 25]


def test_a_gear_that_points_the_other_way_has_its_datum_face_there(tmp_path: Path) -> None:
    text = shifted("<c>40</c><c>0</c><c>-132</c>", "<c>-1</c><c>0</c><c>0</c>")
    relation = (
        '<relation id="900" type="assembly"><ref id="44" role="assembly"/>'
        '<ref id="53" role="part"/></relation></relations>'
    )
    found = keys(made(tmp_path, text.replace("</relations>", relation)))
    assert found["body_1"]["end_relief_um"] == [6.0, 0.0]
    assert found["body_2"]["end_relief_um"] == [0.0, 6.0]


@pytest.mark.parametrize(
    ("wheel", "axis", "why"),
    [
        ("<c>42</c><c>0</c><c>-130</c>", "<c>1</c><c>0</c><c>0</c>", "positions 130 mm apart"),
        ("<c>42</c><c>0</c><c>-132</c>", "<c>1</c><c>0.1</c><c>0</c>", "are not parallel"),
        ("<c>42</c><c>0</c>", "<c>1</c><c>0</c><c>0</c>", "no positions"),
    ],
)
def test_positions_that_do_not_fit_are_named(
    tmp_path: Path, wheel: str, axis: str, why: str
) -> None:
    found = made(tmp_path, shifted(wheel, axis))
    assert "axial_offset_mm" not in keys(found)["body_2"]
    assert any(
        line.startswith("assumed: cylindrical_stage 21") and why in line for line in found.lines
    )


def test_widths_that_do_not_overlap_are_refused(tmp_path: Path) -> None:
    text = without("common_face_width", 21, shifted("<c>66</c><c>0</c><c>-132</c>"))
    assert refused(tmp_path, text).startswith("cylindrical_stage 21: common_face_width: expected ")


# --- load -----------------------------------------------------------------------------------------
def with_cases(text: str, **torques: float) -> str:
    cases = "".join(
        f'<load_case id="{name[1:]}"><component id="81" type="external_load">'
        f"{attribute_line('torque_around_u_axis', 'N m', torque)}</component></load_case>"
        for name, torque in torques.items()
    )
    return text.replace("</model>", f'<load_spectrum id="1">{cases}</load_spectrum></model>')


def test_torques_of_load_cases(tmp_path: Path) -> None:
    master = without("torque_around_u_axis", 81)
    assert keys(made(tmp_path, with_cases(master, c7=120)))["load"] == {"torque_Nm": 120}
    two = with_cases(master, c7=120, c8=-130)
    assert keys(made(tmp_path, two, load_case=8))["load"] == {"torque_Nm": 130}
    line = refused(tmp_path, two)
    assert line == "--load-case: expected the id of a load_case: 7, 8, found nothing"
    assert refused(tmp_path, two, load_case=9).endswith("7, 8, found 9")
    given = made(tmp_path, two, settings={"load.torque_Nm": 5})
    assert keys(given)["load"] == {"torque_Nm": 5}
    assert "not taken: load_case 7, 8: another load" in given.lines


def test_a_torque_of_gear_2_has_the_ratio_of_the_teeth(tmp_path: Path) -> None:
    text = without("torque_around_u_axis", 81)
    text = added(32, '<attribute id="torque" unit="N m">-600</attribute>', text=text)
    assert keys(made(tmp_path, text))["load"] == {"torque_Nm": 250}


@pytest.mark.parametrize(
    "relation",
    [
        # a second gear on the shaft; a coupling to another shaft
        'type="assembly"><ref id="2" role="assembly"/><ref id="13" role="part"/>',
        'type="side"><ref id="1" role="assembly"/><ref id="2" role="inner_part"/>',
    ],
)
def test_a_torque_that_is_not_that_of_the_stage_is_not_taken(tmp_path: Path, relation: str) -> None:
    text = TEXT.replace("</relations>", f'<relation id="900" {relation}</relation></relations>')
    line = refused(tmp_path, text)
    assert line.startswith("cylindrical_stage 21: expected --torque-Nm, since the file has none")


# --- missing or omitted ---------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("attribute", "component", "key"),
    [
        ("number_of_teeth", 11, "body_1.teeth"),
        ("normal_module", 12, "body_2.module_mm"),
        ("tip_diameter", 11, "body_1.tip_diameter_mm"),
        ("inner_diameter", 12, "body_2.bore_diameter_mm"),
        ("normal_pressure_angle", 42, "body_1.pressure_angle_deg"),
        ("addendum_modification_coefficient", 44, "body_2.profile_shift"),
        ("helix_angle_reference_diameter", 11, "body_1.helix_angle_deg"),
        ("center_distance", 21, "pair.center_distance_mm"),
    ],
)
def test_a_missing_attribute_is_named_with_its_component(
    tmp_path: Path, attribute: str, component: int, key: str
) -> None:
    line = refused(tmp_path, without(attribute, component))
    assert re.fullmatch(
        rf"\w+ {component}: {attribute}: "
        rf"expected a value, or --set {re.escape(key)}=…, found nothing",
        line,
    )
    table, name = key.split(".")
    settings = {key: keys(made(tmp_path))[table].get(name, 20)}
    if name == "helix_angle_deg":
        settings["body_1.hand"] = "right"
    found = made(tmp_path, without(attribute, component), settings=settings)
    assert keys(found) == keys(made(tmp_path))


def test_a_setting_replaces_a_value_of_the_file(tmp_path: Path) -> None:
    found = made(
        tmp_path,
        settings={
            "body_2.profile_shift": -0.25,
            "pair.center_distance_mm": 132.1,
            "load.torque_Nm": 9,
        },
    )
    assert keys(found)["body_2"]["profile_shift"] == -0.25
    lines = [line for line in found.lines if "replaced by" in line]
    assert len(lines) == 3
    assert "not taken: body_2.profile_shift = -0.23 of the file: replaced by -0.25" in lines


def test_a_rule_of_scenes_names_the_file(tmp_path: Path) -> None:
    line = refused(tmp_path, TEXT.replace(">-15<", ">-16<"))
    assert line.startswith("body_2.helix_angle_deg: expected 15")


def test_each_attribute_is_read_or_listed(tmp_path: Path) -> None:
    """Attributes of the stage are in the table of attributes, or have a line with a reason."""
    read = {(kind, entry.attribute) for entry in TABLE for kind in entry.types}
    model = read_model(written(tmp_path, TEXT))
    lines = scene_of_stage(model, Choices(stage=21)).lines
    for component in model.components.values():
        whole = any(
            re.match(rf"not taken: {component.type} [\d, ]*\b{component.id}\b[\d, ]*: ", line)
            and f"{component.id}: {name}:" not in line
            for line in lines
            for name in list(component.attributes) or ["?"]
        )
        for attribute in component.attributes:
            listed = f"not taken: {component.type} {component.id}: {attribute}: "
            assert (
                whole
                or (component.type, attribute) in read
                or any(line.startswith(listed) for line in lines)
            ), (component, attribute)


def test_the_guide_has_the_table_of_what_is_read() -> None:
    text = (DOCS / "guide" / "rexs.md").read_text(encoding="utf-8")
    table = text.partition("| component | attribute |")[2].partition("\n\n")[0]
    assert table.splitlines()[2:] == [
        f"| {', '.join(f'`{kind}`' for kind in entry.types)} | `{entry.attribute}` "
        f"| {', '.join(f'`{key}`' for key in entry.key.split(', ') if key)} | {entry.how} |"
        for entry in TABLE
    ]


def test_each_key_of_the_table_is_one_of_a_scene() -> None:
    paths = {
        found.path.replace("body_1.", "body.").replace("body_2.", "body.")
        for found in scene_paths()
    }
    for entry in TABLE:
        for key in filter(None, entry.key.split(", ")):
            assert key.replace("body_2.", "body.") in paths


def test_the_scene_reads_back_from_its_text(tmp_path: Path) -> None:
    scene = made(tmp_path).scene
    again = read_scene(written(tmp_path, scene.to_toml(), "pair.toml"))
    assert again.to_dict() == scene.to_dict()
    assert tomllib.loads(scene.to_toml())["name"] == "helical stage"


def test_backlash_in_place_of_the_centre_distance_of_the_model(tmp_path: Path) -> None:
    """Regression: "pair.center_distance_mm: expected a number, found None"."""
    settings = {"pair.center_distance_mm": None, "pair.normal_backlash_um": 50}
    scene = made(tmp_path, stage=21, settings=settings).scene
    assert scene.pair is not None
    assert (scene.pair.normal_backlash_um, "pair.center_distance_mm" in scene.derived) == (50, True)
