"""Keys that follow from others, as on drawings: tip diameter, centre distance, reliefs."""

from __future__ import annotations

from math import acos, atan, cos, degrees, hypot, pi, radians, sqrt, tan
from pathlib import Path
from typing import Any

import pytest

import flankload as fl
from flankload.cli import main
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.data_sheet import data_sheet
from flankload.pairing.gear_pair import GearGeometry
from flankload.scene.axial import three_dimensional_key
from flankload.scene.plane_section import plane_section
from tests.support.drawing import drawing
from tests.support.gear_scenes import MESH, RING, SCENE
from tests.support.paths import SCENES
from tests.support.tolerances import ROUND_OFF

#: Without elements and load: only the geometry is built.
RIGID = {"rigid": True}
#: An internal pair with profile shifts, of which only the sum of the drawing is known.
PINION = {**SCENE["body_1"], **RIGID, "teeth": 20, "profile_shift": 0.3, "tip_diameter_mm": 99.0}
HOLLOW = {**RING, **RIGID, "profile_shift": 0.45, "tip_diameter_mm": 265}
INTERNAL = {"body_1": PINION, "body_2": HOLLOW, "pair": {"face_width_mm": 14}}


def scene(tables: dict[str, Any]) -> fl.Scene:
    return fl.Scene.from_dict({**tables, "load": {"torque_Nm": 0}})


def geometry(tables: dict[str, Any]) -> GearGeometry:
    found = build_bodies(scene(tables)).pairing.gear_geometry
    assert found is not None
    return found


def external(
    body_1: dict[str, Any] | None = None, body_2: dict[str, Any] | None = None, **pair: Any
) -> dict[str, Any]:
    return drawing(RIGID | (body_1 or {}), RIGID | (body_2 or {}), **pair)


def refused(tables: dict[str, Any]) -> fl.SceneError:
    with pytest.raises(fl.SceneError) as caught:
        build_bodies(scene(tables))
    assert "\n" not in str(caught.value)
    return caught.value


# --- tip diameter ---------------------------------------------------------------------------------
def test_addendum_gives_the_tip_diameter() -> None:
    """d_a = d + 2 m_n (h_aP* + x + k), d = z m_n/cos(beta) (ISO 21771)."""
    found = scene(
        external(
            {"tip_diameter_mm": None, "addendum_factor": 1},
            {"tip_diameter_mm": None, "addendum_factor": 0.98, "tip_alteration_factor": -0.02},
        )
    )
    d_1, d_2 = (z * 2.5 / cos(radians(18)) for z in (23, 71))
    assert found.body_1.tip_diameter_mm == pytest.approx(d_1 + 5 * 1.25, rel=ROUND_OFF)
    assert found.body_2.tip_diameter_mm == pytest.approx(d_2 + 5 * 0.91, rel=ROUND_OFF)
    assert found.derived == {"body_1.tip_diameter_mm", "body_2.tip_diameter_mm"}


def test_addendum_of_internal_teeth_points_inwards() -> None:
    """Their profile shift is positive outwards: d_a = d - 2 m_n (h_aP* - x + k)."""
    ring = {**HOLLOW, "addendum_factor": 0.9, "tip_alteration_factor": -0.1}
    del ring["tip_diameter_mm"]
    found = scene({**INTERNAL, "body_2": ring}).body_2
    assert found.tip_diameter_mm == pytest.approx(60 * 4.5 - 9 * (0.9 - 0.45 - 0.1), rel=ROUND_OFF)


def test_addendum_of_the_profile_of_a_mesh() -> None:
    body = {**MESH, "profile": {"module_mm": 4.5, "addendum_factor": 1}}
    found = scene({**SCENE, "body_1": body})
    assert found.derived == {"body_1.profile.tip_diameter_mm"}
    assert found.body_1.profile.tip_diameter_mm == pytest.approx(81, rel=ROUND_OFF)


# --- centre distance ------------------------------------------------------------------------------
def test_the_centre_distance_without_backlash() -> None:
    """inv(a_wt) = inv(a_t) + 2 tan(a_n) (x_1 + x_2)/(z_1 + z_2), a = a_d cos(a_t)/cos(a_wt)."""
    found = scene(external(center_distance_mm=None))
    transverse = atan(tan(radians(20)) / cos(radians(18)))
    distance = found.pair.center_distance_mm
    assert distance is not None
    nominal = 94 * 2.5 / cos(radians(18)) / 2
    working = acos(nominal * cos(transverse) / distance)
    expected = tan(transverse) - transverse + 2 * tan(radians(20)) * 0.2 / 94
    assert tan(working) - working == pytest.approx(expected, rel=1e-12)
    assert distance == pytest.approx(124.0402, abs=5e-5)
    assert found.derived == {"pair.center_distance_mm"}


def test_allowances_leave_their_backlash() -> None:
    """The distance is that of the profile shifts; the gap of both flanks is E_sn cos(a_n)."""
    thin = {"tooth_thickness_allowance_um": -60}
    found = geometry(external(thin, thin, center_distance_mm=None))
    assert found.normal_backlash_mm == pytest.approx(0.12 * cos(radians(20)), rel=1e-9)


@pytest.mark.parametrize(
    "tables",
    [
        external(center_distance_mm=None),
        external({"tooth_thickness_allowance_um": -60}, center_distance_mm=None),
        external({"span_measurement_mm": 27.15, "span_teeth": 4}, center_distance_mm=None),
        INTERNAL,
        {**INTERNAL, "body_2": {**HOLLOW, "tooth_thickness_allowance_um": -50}},
    ],
)
def test_the_centre_distance_with_a_normal_backlash(tables: dict[str, Any]) -> None:
    pair = {**tables["pair"], "normal_backlash_um": 80}
    found = geometry({**tables, "pair": pair})
    assert found.normal_backlash_mm == pytest.approx(0.08, rel=1e-9)


def test_an_internal_pair_without_backlash() -> None:
    found = geometry(INTERNAL)
    assert found.backlash_mm == pytest.approx(0.0, abs=1e-12)
    assert found.pressure_angle_rad > radians(20)  # x_2 > x_1 moves the axes apart


# --- starts of reliefs ----------------------------------------------------------------------------
BOTH = {"tip_relief_um": 20, "root_relief_um": 10}


def starts(found: fl.Scene) -> dict[str, float]:
    return {
        f"{name}{end}": getattr(getattr(found, name), f"{end}_relief_start_diameter_mm")
        for name in ("body_1", "body_2")
        for end in ("tip", "root")
    }


@pytest.mark.parametrize("internal", [False, True], ids=["external", "internal"])
def test_long_reliefs_begin_at_the_points_of_single_contact(internal: bool) -> None:
    """As the report lists them: body 1 is relieved beyond D and before B, body 2 vice versa."""
    long = {**BOTH, "tip_relief_length": "long", "root_relief_length": "long"}
    tables = external(long, long)
    if internal:
        tables = {**INTERNAL, "body_1": PINION | long, "body_2": HOLLOW | long}

    found = scene(tables)
    plain = found.replace(
        {f"body_{z}.{end}_relief_um": 0 for z in (1, 2) for end in ("tip", "root")}
    )
    points = {point.name: point.diameters_mm for point in data_sheet(plain).path}
    (b_1, b_2), (d_1, d_2) = points["B"], points["D"]
    expected = {"body_1tip": d_1, "body_1root": b_1, "body_2tip": b_2, "body_2root": d_2}
    assert starts(found) == pytest.approx(expected, rel=1e-12)


def test_short_reliefs_have_half_the_length_on_the_path_of_contact() -> None:
    def lengths(extent: str) -> list[float]:
        found = scene(external({"tip_relief_um": 20, "tip_relief_length": extent}))
        return [rolled(found, 66.70), rolled(found, found.body_1.tip_relief_start_diameter_mm)]

    tip, long = lengths("long")
    assert tip - lengths("short")[1] == pytest.approx(0.5 * (tip - long), rel=1e-12)


def rolled(found: fl.Scene, diameter_mm: float) -> float:
    """Length of roll of body 1 at a diameter, mm."""
    base = 0.5 * 23 * found.body_1.base_pitch_mm / pi
    return sqrt((0.5 * diameter_mm) ** 2 - base**2)


def test_length_and_roll_angle_give_the_start() -> None:
    found = scene(external({"tip_relief_um": 20, "tip_relief_length_mm": 3}))
    start = found.body_1.tip_relief_start_diameter_mm
    assert rolled(found, 66.70) - rolled(found, start) == pytest.approx(3.0, rel=1e-12)
    base = 0.5 * 23 * found.body_1.base_pitch_mm / pi
    angle = degrees(rolled(found, start) / base)
    by_angle = scene(external({"tip_relief_um": 20, "tip_relief_start_roll_angle_deg": angle}))
    assert by_angle.body_1.tip_relief_start_diameter_mm == pytest.approx(start, rel=1e-12)
    root = scene(external({"root_relief_um": 9, "root_relief_start_roll_angle_deg": 20.0}))
    expected = 2 * base * hypot(1.0, radians(20.0))
    assert root.body_1.root_relief_start_diameter_mm == pytest.approx(expected, rel=1e-12)


def test_a_length_from_the_tip_of_a_ring_goes_outwards() -> None:
    relief = {"tip_relief_um": 20, "tip_relief_length_mm": 3}
    found = scene({**INTERNAL, "body_2": HOLLOW | relief}).body_2
    base = 135 * cos(radians(20))
    reach = [sqrt((0.5 * d) ** 2 - base**2) for d in (265, found.tip_relief_start_diameter_mm)]
    assert reach[1] - reach[0] == pytest.approx(3.0, rel=1e-12)


# --- common face width ----------------------------------------------------------------------------
def with_widths(one: float | None, two: float | None, offset_mm: float = 0.0) -> dict[str, Any]:
    """An external pair without `pair.face_width_mm`; None: a body without a width of its own."""
    keys = ({} if width is None else {"face_width_mm": width} for width in (one, two))
    bodies = [RIGID | own for own in keys]
    bodies[1] |= {"axial_offset_mm": offset_mm}
    return drawing(*bodies, face_width_mm=None)


@pytest.mark.parametrize(("offset_mm", "width_mm"), [(0.0, 22.0), (-2.0, 22.0), (5.0, 19.0)])
def test_the_common_face_width_is_the_overlap(offset_mm: float, width_mm: float) -> None:
    found = scene(with_widths(26, 22, offset_mm))
    assert found.pair.face_width_mm == width_mm
    assert found.derived == {"pair.face_width_mm"}
    assert "face_width_mm" not in found.to_dict()["pair"]
    assert fl.Scene.from_dict(found.to_dict()) == found
    wider = found.replace({"body_2.face_width_mm": 60})
    assert wider.pair.face_width_mm == 26
    section = plane_section(found)
    assert section.replace({"positions.count": 8}).pair.face_width_mm == width_mm


def test_equal_widths_need_no_third_one_in_the_plane() -> None:
    table = {**SCENE["pair"]}
    width = table.pop("face_width_mm")
    bodies = {name: {**SCENE[name], "face_width_mm": width} for name in ("body_1", "body_2")}
    found = scene({**SCENE, **bodies, "pair": table})
    assert found.pair == scene(SCENE).pair
    assert three_dimensional_key(found) is None


def test_a_table_of_derived_keys_may_be_absent() -> None:
    tables = with_widths(26, 22)
    del tables["pair"]
    found = scene(tables)
    assert found.derived == {"pair.face_width_mm", "pair.center_distance_mm"}
    assert "pair" not in found.to_dict()


@pytest.mark.parametrize(
    ("tables", "line"),
    [
        (
            with_widths(None, None),
            "pair.face_width_mm: expected a number from 0.001 to 100000, found nothing",
        ),
        (
            with_widths(26, None),
            (
                "pair.face_width_mm: expected a number from 0.001 to 100000 or "
                "body_2.face_width_mm, found nothing"
            ),
        ),
        (
            with_widths(26, 22, 24.0),
            (
                "body_2.axial_offset_mm: expected an offset at which the face widths overlap: "
                "body_1 extends from -13 to 13 mm, found 24, where body_2 extends from 13 to 35 mm"
            ),
        ),
    ],
)
def test_without_a_common_face_width(tables: dict[str, Any], line: str) -> None:
    assert str(refused(tables)) == line


# --- changes, files -------------------------------------------------------------------------------
def test_derived_keys_follow_changes_and_are_not_written() -> None:
    short = {"tip_diameter_mm": None, "addendum_factor": 1, **BOTH}
    short |= {"tip_relief_length": "short", "root_relief_length": "long"}
    found = scene(external(short, center_distance_mm=None))
    assert {path.rpartition(".")[2] for path in found.derived} == {
        *("tip_diameter_mm", "tip_relief_start_diameter_mm", "root_relief_start_diameter_mm"),
        "center_distance_mm",
    }
    tree = found.to_dict()
    assert not [path for path in found.derived if path.rpartition(".")[2] in str(tree["body_1"])]
    assert "center_distance_mm" not in tree["pair"]
    assert fl.Scene.from_dict(tree) == found
    other = found.replace({"body_1.profile_shift": 0.35})
    for path in found.derived:
        part, _, key = path.partition(".")
        assert getattr(getattr(other, part), key) > getattr(getattr(found, part), key)
    assert other.replace({"pair.center_distance_mm": 125}).pair.center_distance_mm == 125


def test_typed_tables_take_the_keys_of_a_drawing() -> None:
    gear = {"module_mm": 4.5, "addendum_factor": 1}
    pair = fl.GearPair(
        fl.Gear(teeth=16, profile_shift=0.182, bore_diameter_mm=30, **gear),
        fl.Gear(teeth=24, profile_shift=0.171, bore_diameter_mm=40, **gear),
        normal_backlash_um=100,
        face_width_mm=14,
        torque_Nm=302,
    )
    found = pair.to_scene()
    assert found.body_1.tip_diameter_mm == pytest.approx(82.638, rel=1e-9)
    assert len(found.derived) == 3


def test_check_prints_what_was_derived(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    settings = ["body_1.tip_diameter_mm=", "body_1.addendum_factor=.96", "body_1.rigid=true"]
    settings += ["pair.center_distance_mm=", "pair.normal_backlash_um=50", "body_2.rigid=true"]
    settings += ["load.torque_Nm=0"]
    argv = [word for text in settings for word in ("--set", text)]
    assert main(["check", str(SCENES / "external_gear.toml"), *argv]) == 0
    derived = capsys.readouterr().out.partition("derived from other keys\n")[2].splitlines()
    assert derived[0].split() == (
        ["body_1.tip_diameter_mm", "82.2780", "mm,", "by", "addendum_factor", "=", "0.96"]
    )
    assert derived[1].split()[0] == "pair.center_distance_mm"
    assert derived[1].endswith(" mm, by normal_backlash_um = 50")
    assert derived[2] == ""
    assert main(["check", str(SCENES / "crowned_coupling.toml")]) == 0
    row = "pair.face_width_mm 16.0000 mm, by the overlap of both face widths"
    assert row in " ".join(capsys.readouterr().out.split())


# --- error lines ----------------------------------------------------------------------------------
LONG = {"tip_relief_um": 20, "tip_relief_length": "long"}


@pytest.mark.parametrize(
    ("tables", "key", "expected", "found"),
    [
        (
            external({"addendum_factor": 1}),
            "body_1.addendum_factor",
            "nothing beside body_1.tip_diameter_mm: one of the two",
            "1",
        ),
        (
            external({"tip_diameter_mm": None}),
            "body_1.tip_diameter_mm",
            "a number from 0.001 to 100000 or addendum_factor",
            "nothing",
        ),
        (
            external({"tip_alteration_factor": -0.1}),
            "body_1.addendum_factor",
            "a number > 0, since there is a body_1.tip_alteration_factor",
            "nothing",
        ),
        (
            external(normal_backlash_um=80),
            "pair.normal_backlash_um",
            "nothing beside pair.center_distance_mm: one of the two",
            "80",
        ),
        (
            external({**LONG, "tip_relief_length_mm": 3}),
            "body_1.tip_relief_length",
            "nothing beside body_1.tip_relief_length_mm: one of the two",
            "'long'",
        ),
        (
            external({"tip_relief_length": "long"}),
            "body_1.tip_relief_um",
            "a number >= 0, since there is a body_1.tip_relief_length",
            "nothing",
        ),
        (
            external({"profile_shift": -2.5}, center_distance_mm=None),
            "pair.center_distance_mm",
            "a number: with these profile shifts the teeth fit at no centre distance",
            "nothing",
        ),
        (
            external({"tip_relief_um": 20, "tip_relief_length_mm": 18}),
            "body_1.tip_relief_length_mm",
            "less than 17.7521, the length of roll at the tip",
            "18.0",
        ),
        (
            external(LONG, center_distance_mm=110),
            "pair.center_distance_mm",
            "more than the sum of the base radii, 115.3857 mm",
            "110.0",
        ),
        (
            {**INTERNAL, "body_1": {**PINION, "teeth": 60}},
            "body_1.teeth",
            "fewer than the 60 teeth of body_2, inside which it turns",
            "60",
        ),
    ],
)
def test_impossible_keys_get_one_line(
    tables: dict[str, Any], key: str, expected: str, found: str
) -> None:
    error = refused(tables)
    assert (error.key, error.expected, error.found) == (key, expected, found)


def test_a_long_relief_needs_one_pair_alone() -> None:
    error = refused(external(LONG, center_distance_mm=126.5))
    assert error.key == "body_1.tip_relief_length"
    assert error.expected == "nothing, unless the contact ratio is between 1 and 2"
    assert error.found.startswith("'long' with a contact ratio of 0.")
    spline = fl.read_scene(SCENES / "spline.toml").to_dict()
    spline["body_1"] |= LONG
    assert refused(spline).expected.startswith("nothing: it refers to the path of contact of two ")


@pytest.mark.parametrize(
    ("keys", "origin"),
    [
        ({"center_distance_mm": 140.0}, ""),
        (
            {"center_distance_mm": None, "normal_backlash_um": 2e4},
            ", by normal_backlash_um = 20000",
        ),
    ],
)
def test_tips_apart_blame_the_distance_and_no_relief(
    keys: dict[str, float | None], origin: str
) -> None:
    """Regression: the relief was refused with a contact ratio of -3.6."""
    error = refused(external(LONG, **keys))
    assert error.key == "pair.center_distance_mm"
    assert error.expected == "a distance at which the tips reach each other"
    assert f"mm apart{origin}" in error.found


def test_errors_name_the_origin_of_derived_values() -> None:
    error = refused(external({"tip_diameter_mm": None, "addendum_factor": 2.5}))
    assert error.key == "body_1.tip_diameter_mm"
    assert error.found.endswith(", by addendum_factor = 2.5")
    error = refused(external({"tip_relief_um": 20, "tip_relief_length_mm": 13}))
    assert error.key == "body_1.tip_relief_start_diameter_mm"
    assert error.found.endswith(", by tip_relief_length_mm = 13")


def test_a_cam_requires_its_centre_distance() -> None:
    cam = fl.read_scene(SCENES / "cam.toml").to_dict()
    del cam["pair"]["center_distance_mm"]
    error = refused(cam)
    assert (error.key, error.found) == ("pair.center_distance_mm", "nothing")
    spline = fl.read_scene(SCENES / "spline.toml").to_dict()
    spline["pair"]["normal_backlash_um"] = 50
    assert refused(spline).key == "pair.normal_backlash_um"
