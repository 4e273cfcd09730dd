"""A timing belt on its pulley as a scene: refused scenes, results, files."""

from __future__ import annotations

import csv
import io
import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.cli import main
from flankload.mechanisms.belt.contact import lands_in_words
from flankload.mechanisms.belt.estimate import EXTRAPOLATION_ERROR, between_places
from flankload.plot import PICTURES, pictures_of
from flankload.result.drives import BeltDrive
from tests.support.belt_scenes import EXAMPLE, POSITIONS, SMALL, tables
from tests.support.tolerances import SOLVER

PLASTIC = EXAMPLE.with_name("belt_plastic_pulley.toml")
#: An elastic pulley.
ELASTIC: dict[str, Any] = {"rigid": False, "bore_diameter_mm": 20}
#: Results by the changes of their scenes.
SOLVED: dict[str, fl.Result] = {}


def solved(**changes: dict[str, Any]) -> fl.Result:
    """Result of the small scene with changes; each is solved once."""
    text = json.dumps(changes, sort_keys=True)
    if text not in SOLVED:
        merged = {
            table: {**SMALL.get(table, {}), **changes.get(table, {})}
            for table in {**SMALL, **changes}
        }
        found = fl.solve(fl.Scene.from_dict(tables(**merged)))
        assert isinstance(found, fl.Result)
        SOLVED[text] = found
    return SOLVED[text]


def drive_of(result: fl.Result) -> BeltDrive:
    assert isinstance(result.drive, BeltDrive)
    return result.drive


REFUSED = [
    (
        {"body_2": {"wrapped_teeth": 24}},
        "body_2.wrapped_teeth: expected less than body_1.teeth (24)",
    ),
    ({"body_2": {"pitch_mm": 10.3}}, "body_2.pitch_mm: expected body_1.pitch_mm (10) to 2 %"),
    (
        {"body_2": {"pitch_mm": 9.9, "pitch_difference_um": -150}},
        "body_2.pitch_difference_um: expected at most 2 % of body_1.pitch_mm (10), found -150",
    ),
    (
        {"body_2": {"land_distance_mm": 2}},
        "body_2.land_distance_mm: expected less than body_2.back",
    ),
    ({"body_2": {"tooth_height_mm": 20}}, "body_2.tooth_height_mm: expected less than half of the"),
    ({"body_2": {"tooth_width_mm": 9.5}}, "body_2.tooth_width_mm: expected at most 8.764: lands"),
    (
        {"body_2": {"flank_angle_deg": None}},
        "body_2.flank_angle_deg: expected a number with body_1",
    ),
    ({"body_2": {"flank_angle_deg": 45}}, "body_2.flank_angle_deg: expected so small that a tooth"),
    (
        {"body_1": {"profile": "HTD"}},
        "body_2.flank_angle_deg: expected nothing with body_1.profile",
    ),
    (
        {"body_1": {"profile": "HTD"}, "body_2": {"flank_angle_deg": None, "tooth_height_mm": 2}},
        "body_2.tooth_height_mm: expected at least 0.4 of body_2.tooth_width_mm (5.3)",
    ),
    (
        {"body_1": {"groove_width_mm": 5}},
        "body_1.groove_width_mm: expected at least body_2.tooth_width_mm (5.3), found 5",
    ),
    (
        {"body_1": {"groove_depth_mm": 2}},
        "body_1.groove_depth_mm: expected at least body_2.tooth_height_mm (2.5), found 2",
    ),
    ({"body_2": {"poisson_ratio": 0.5}}, "body_2.poisson_ratio: expected a number"),
    ({"load": {"slack_tension_N": 0}}, "load.slack_tension_N: expected a number > 0"),
    (
        {"load": {"slack_tension_N": None}},
        "load.slack_tension_N: expected a number > 0: the tension",
    ),
    ({"pair": {"face_width_mm": 5}}, "pair: expected nothing: a belt has body_2.width_mm"),
    (
        {"positions": {"adaptive": True}},
        "positions.adaptive: expected nothing: it does not apply to a belt",
    ),
    (
        {"accuracy": {"modes": 5}},
        "accuracy.modes: expected nothing: it does not apply to a belt and",
    ),
    ({"effects": {"friction_coefficient": 0.1}}, "effects.friction_coefficient: expected nothing"),
    (
        {"effects": {"land_friction": 0.1, "land_lift": True}},
        "effects.land_lift: expected false with effects.land_friction",
    ),
    (
        {"effects": {"land_lift": True}, "body_2": {"prestress_N": 0}},
        "body_2.prestress_N: expected a number > 0 with effects.land_lift",
    ),
    (
        {"body_1": {"bore_diameter_mm": 20}},
        "body_1.rigid: expected true or false beside body_1.bore_diameter_mm, found nothing",
    ),
    (
        {"body_1": {"young_modulus_MPa": 3000}},
        "body_1.rigid: expected true or false beside body_1.young_modulus_MPa, found nothing",
    ),
    (
        {"body_1": {"rigid": False}},
        "body_1.bore_diameter_mm: expected a number with body_1.rigid = false, found nothing",
    ),
    (
        {"body_1": ELASTIC | {"bore_diameter_mm": 70}},
        "body_1.bore_diameter_mm: expected less than the diameter below the grooves (69.21)",
    ),
    (
        {"body_1": ELASTIC | {"groove_depth_mm": 5.2}},
        "body_1.groove_depth_mm: expected so small that a groove keeps a tenth of its width",
    ),
    (
        {"body_1": ELASTIC | {"groove_width_mm": 9}},
        "body_1.groove_width_mm: expected at most 8.764: teeth between, found 9",
    ),
    ({"body_1": ELASTIC | {"poisson_ratio": 0.5}}, "body_1.poisson_ratio: expected a number"),
    ({"body_1": ELASTIC | {"young_modulus_MPa": 0}}, "body_1.young_modulus_MPa: expected a"),
    (
        {"accuracy": {"plane": "stress"}},
        "accuracy.plane: expected nothing: it does not apply to a belt",
    ),
]


@pytest.mark.parametrize(("changes", "line"), REFUSED, ids=[line[:60] for _, line in REFUSED])
def test_scene_is_refused(changes: dict[str, Any], line: str) -> None:
    with pytest.raises(fl.SceneError) as found:
        fl.Scene.from_dict(tables(**changes))
    assert str(found.value).startswith(line)


def test_pulley_and_belt_go_together() -> None:
    scene = tables()
    scene["body_2"] = {"kind": "compliance", "file": "x.npz"}
    del scene["load"]["slack_tension_N"]
    scene["pair"] = {"center_distance_mm": 50, "face_width_mm": 5}
    with pytest.raises(fl.SceneError, match=r"body_2.kind: expected 'belt' with body_1.kind"):
        fl.Scene.from_dict(scene)


@pytest.mark.parametrize(
    "effect",
    [{"land_friction": 0.1}, {"land_friction": 0}, {"land_lift": True}, {"land_lift": False}],
)
def test_other_pairs_know_no_lands(effect: dict[str, Any]) -> None:
    gear = tomllib.loads((EXAMPLE.parent / "external_gear.toml").read_text())
    gear["effects"] = effect
    with pytest.raises(fl.SceneError, match=r"expected nothing, unless body_2.kind is 'belt'"):
        fl.Scene.from_dict(gear)


def test_result_has_teeth_strands_and_lands() -> None:
    result = solved()
    drive = drive_of(result)
    force = 1000.0 * result.torque_Nm / result.reference_radius_mm
    assert result.sites.tolist() == list(range(5))
    assert result.warnings == ()
    np.testing.assert_allclose(result.site_force_N.sum(), force, rtol=SOLVER, atol=0.0)
    np.testing.assert_allclose(drive.tight_tension_N, 320.0 + force, rtol=SOLVER, atol=0.0)
    np.testing.assert_allclose(drive.tension_behind_N[:, 0], 320.0 + force, rtol=SOLVER, atol=0)
    np.testing.assert_allclose(
        -np.diff(np.append(drive.tension_behind_N, 320.0)),
        result.site_force_N[0],
        rtol=SOLVER,
        atol=SOLVER * force,
    )
    assert (np.diff(result.load_share[0]) < 0).all()
    assert not drive.lifting.any()
    pairs = result.pairs(0)
    pushed = (pairs.force_N * np.hypot(pairs.normal_x, pairs.normal_y)).sum()
    assert pushed > force
    # the forces of the pairs turn the pulley back
    moment = pairs.force_N @ (pairs.x_mm * pairs.normal_y - pairs.y_mm * pairs.normal_x)
    np.testing.assert_allclose(moment, 1000.0 * result.torque_Nm, rtol=2e-3, atol=0.0)


def test_width_does_not_change_the_load_per_millimetre() -> None:
    wide, narrow = (
        solved(),
        solved(
            body_2={"wrapped_teeth": 5, "width_mm": 8, "prestress_N": 320},
            load={"torque_Nm": 12.223, "slack_tension_N": 160},
        ),
    )
    np.testing.assert_allclose(narrow.rotation_rad, wide.rotation_rad, rtol=SOLVER, atol=0.0)
    np.testing.assert_allclose(2 * narrow.site_force_N, wide.site_force_N, rtol=SOLVER, atol=1e-6)
    ratio = drive_of(wide).tooth_stiffness_N_per_mm / drive_of(narrow).tooth_stiffness_N_per_mm
    np.testing.assert_allclose(ratio, 2.0, rtol=SOLVER, atol=0.0)


def test_stiffness_is_the_growth_of_the_rotation() -> None:
    least, middle, most = (
        solved(load={"torque_Nm": torque}) for torque in (24.4459, 24.446, 24.4461)
    )
    growth = 2e-4 / (most.rotation_rad - least.rotation_rad)
    np.testing.assert_allclose(middle.stiffness_tangent_Nm_per_rad, growth, rtol=1e-6, atol=0.0)


def test_torques_share_the_elements_and_one_may_be_none() -> None:
    found = fl.solve(fl.Scene.from_dict(tables(**{**SMALL, "load": {"torque_Nm": [0, 10]}})))
    free, loaded = found.by_torque
    assert free.site_force_N.max() == 0.0
    np.testing.assert_allclose(drive_of(free).tight_tension_N, 320.0, rtol=SOLVER, atol=0.0)
    assert loaded.rotation_rad[0] > free.rotation_rad[0]
    assert loaded.cost["fe_factorisations"] == 3
    assert loaded.cost["stages"]["sweep"]["counters"]["states"] == 2


def test_estimate_is_the_change_by_finer_elements() -> None:
    """The estimate is of the order of the change by elements half as long."""
    changes = {"accuracy": {"flank_element_mm": 0.625, "estimate": True}}
    result = solved(**changes)
    finer = solved(accuracy={"flank_element_mm": 0.3125, "estimate": False})
    off = np.abs(finer.load_share - result.load_share).max()
    assert result.estimate is not None
    assert 0.5 * off < result.estimate["load_share"] < 10 * off
    assert "estimate" not in solved().cost["stages"]


def positions_of(count: int, **keys: Any) -> fl.Result:
    return solved(positions={"count": count}, accuracy={"flank_element_mm": 0.833, **keys})


PER_POSITION = {
    "transmission_error_mean": lambda r: r.transmission_error_um,
    "stiffness_secant": lambda r: r.stiffness_secant_Nm_per_rad,
    "stiffness_tangent": lambda r: r.stiffness_tangent_Nm_per_rad,
}


@pytest.mark.parametrize("difference", [0.0, -20.0])
def test_positions_estimate_their_error_of_the_saw(difference: float) -> None:
    """Compared with positions within 1/64 pitch on both sides of the jump."""
    belt = {"wrapped_teeth": 5, "pitch_difference_um": difference}
    fine = solved(body_2=belt, positions={"count": 64})
    for count in (4, 8):
        result = solved(body_2=belt, positions={"count": count}, accuracy={"estimate": True})
        assert result.estimate is not None
        estimated = result.estimate["by_source"]["positions"]
        missed = np.ptp(fine.transmission_error_um) / np.ptp(result.transmission_error_um) - 1
        assert missed > 0.1
        assert missed < estimated["transmission_error_peak_to_peak"] < 10 * missed
        for quantity, values in PER_POSITION.items():
            missed = abs(values(fine).mean() / values(result).mean() - 1)
            assert 0.8 * missed < estimated[quantity] < 10 * missed
        assert result.estimate["dominant_source"]["transmission_error_peak_to_peak"] == "positions"


def test_positions_of_a_straight_saw_have_a_known_error() -> None:
    """Even positions of y = 2 + x from -1/2 to 1/2: peak to peak 1, mean 2."""
    for count in (3, 4, 9):
        at = (np.arange(count) + 0.5 * (count % 2)) / count - 0.5
        estimated = between_places(at, 2 + at, 1 / (2 + at))
        span = 1 - 1 / count
        part = (1 - span) / span
        assert estimated["transmission_error_peak_to_peak"] == pytest.approx(
            part * (1 + EXTRAPOLATION_ERROR), rel=SOLVER
        )
        missed = abs(at.mean()) / (2 + at.mean())
        assert estimated["transmission_error_mean"] == pytest.approx(
            (1 + EXTRAPOLATION_ERROR) * missed, abs=SOLVER
        )


def test_a_further_pitch_adds_nothing() -> None:
    one = positions_of(4, estimate=True)
    two = solved(
        positions={"count": 4, "pitches": 2},
        accuracy={"flank_element_mm": 0.833, "estimate": True},
    )
    assert one.estimate is not None
    assert two.estimate is not None
    for quantity in ("transmission_error_mean", "transmission_error_peak_to_peak"):
        np.testing.assert_allclose(
            two.estimate[quantity], one.estimate[quantity], rtol=1e-6, atol=0.0
        )


def test_nothing_is_claimed_between_single_angles_and_beside_one() -> None:
    one = solved(accuracy={"estimate": True})
    some = solved(positions={"angles_deg": [0, 5]}, accuracy={"estimate": True})
    assert one.estimate is not None
    assert some.estimate is not None
    assert "transmission_error_peak_to_peak" not in one.estimate
    assert set(some.estimate["by_source"]) == {"elements"}
    assert some.estimate["transmission_error_peak_to_peak"] > 0


def test_estimate_of_elements_is_at_least_their_error() -> None:
    """Regression: equal rows over the lands in the coarser mesh hid part of the error."""
    keys: dict[str, Any] = {"body_1": {"profile": "HTD"}}
    keys["body_2"] = {"wrapped_teeth": 5, "flank_angle_deg": None}
    plain = {"flank_element_mm": None, "estimate": True}
    result = solved(**keys, positions={"count": 2}, accuracy=plain)
    fine = solved(**keys, positions={"count": 2}, accuracy={"flank_element_mm": 0.2})
    assert result.estimate is not None
    estimated = result.estimate["by_source"]["elements"]
    turned = fine.rotation_rad - result.rotation_rad
    missed = np.abs(turned).max() / fine.rotation_rad.max()
    assert missed < estimated["transmission_error"] < 4 * missed
    missed = abs(fine.rotation_rad.mean() / result.rotation_rad.mean() - 1)
    assert missed < estimated["transmission_error_mean"] < 4 * missed
    missed = np.abs(fine.load_share - result.load_share).max()
    assert missed < estimated["load_share"] < 10 * missed
    missed = abs(np.ptp(fine.rotation_rad) / np.ptp(result.rotation_rad) - 1)
    assert missed < estimated["transmission_error_peak_to_peak"]


def test_wider_groove_turns_the_pulley_further() -> None:
    plain, wide = solved(), solved(body_1={"groove_width_mm": 5.7})
    clearance = 0.2 / np.sqrt((120 / np.pi - 1) ** 2 - 2.65**2)
    np.testing.assert_allclose(
        wide.rotation_rad - plain.rotation_rad, clearance, rtol=SOLVER, atol=0.0
    )
    np.testing.assert_allclose(wide.site_force_N, plain.site_force_N, rtol=SOLVER, atol=1e-6)


def test_friction_of_the_lands_helps_or_opposes() -> None:
    for coefficient in (0.1, -0.1):
        result = solved(effects={"land_friction": coefficient})
        drive = drive_of(result)
        assert drive.land_friction_N[0] * coefficient > 0
        whole = result.site_force_N.sum() + drive.land_friction_N[0]
        np.testing.assert_allclose(whole, drive.tight_tension_N[0] - 320.0, rtol=SOLVER, atol=0)
        assert "friction of the lands carries" in result.table()


def test_land_that_would_lift_is_named_and_may_lift() -> None:
    held = solved(load={"slack_tension_N": 2})
    # five teeth, 0 to 4: the land that lifts last is behind the last of them, before no tooth
    assert "the land lifts here: before tooth 4 and behind tooth 4 (of 0 to 4)" in held.warnings[0]
    assert "the land lifts here" in held.table()
    assert drive_of(held).last_land_N[0] < 0
    free = solved(load={"slack_tension_N": 2}, effects={"land_lift": True})
    assert free.warnings == ()
    assert drive_of(free).last_land_lift_um[0] > 0
    assert drive_of(free).lands_N.min() > -1e-6


def test_lands_are_named_by_teeth_that_there_are() -> None:
    """A tooth 12 was named on a belt with teeth -1 to 11: the land behind the last one."""
    sites, some = np.arange(-1, 12), np.zeros(14, dtype=bool)
    some[[0, 12, 13]] = True
    assert lands_in_words(sites, some) == "before tooth -1, 11 and behind tooth 11"
    assert lands_in_words(sites, np.arange(14) == 13) == "behind tooth 11"
    assert lands_in_words(sites, np.arange(14) == 12) == "before tooth 11"


def test_belt_jumps_below_the_limit_that_is_named() -> None:
    lifts = {"effects": {"land_lift": True}}
    with pytest.raises(fl.NoContactState, match="the teeth; this belt jumps") as found:
        solved(load={"torque_Nm": 60, "slack_tension_N": 8}, **lifts)
    line = str(found.value)
    assert line.startswith("60 N m, slack strand 8 N: the land behind tooth 4 lifts 3.94 mm")
    limit = float(line.rpartition("about ")[2].removesuffix(" N"))
    held = solved(load={"torque_Nm": 60, "slack_tension_N": 1.01 * limit}, **lifts)
    assert 2000 < drive_of(held).last_land_lift_um[0] < 2500
    with pytest.raises(fl.NoContactState):
        solved(load={"torque_Nm": 60, "slack_tension_N": 0.99 * limit}, **lifts)


def test_lands_that_rub_more_than_the_torque_say_so() -> None:
    with pytest.raises(fl.NoContactState, match=r"= 0.9, sliding lands alone carry .* N m"):
        solved(effects={"land_friction": 0.9}, load={"torque_Nm": 0.5})


def test_round_teeth() -> None:
    result = solved(
        body_1={"profile": "HTD", "pitch_mm": 8, "groove_width_mm": 5.3},
        body_2={
            "wrapped_teeth": 5,
            "pitch_mm": 8,
            "tooth_height_mm": 3.38,
            "tooth_width_mm": 5.15,
            "flank_angle_deg": None,
            "back_mm": 2.2,
            "land_distance_mm": 0.686,
        },
    )
    assert (result.site_force_N[0] > 0).any()
    # arcs of a wider groove meet those of the teeth where they run along the radius
    assert result.rotation_rad[0] * result.reference_radius_mm > 0.075


def test_elastic_pulley() -> None:
    """Its twist and its grooves add to the rotation; teeth share more evenly; estimates by body."""
    rigid = solved(body_1={"rigid": True, "bore_diameter_mm": 20}, accuracy={"estimate": True})
    assert np.array_equal(rigid.rotation_rad, solved().rotation_rad)
    assert drive_of(rigid).pulley_coupling_um_per_N.size == 0
    assert "compliance body 1" not in rigid.cost["stages"]
    plastic = solved(
        body_1=ELASTIC | {"young_modulus_MPa": 1000, "poisson_ratio": 0.35},
        accuracy={"estimate": True},
    )
    assert plastic.rotation_rad > 1.5 * rigid.rotation_rad
    assert plastic.load_share.max() < rigid.load_share.max()
    drive = drive_of(plastic)
    np.testing.assert_allclose(
        drive.tight_tension_N, drive_of(rigid).tight_tension_N, rtol=SOLVER, atol=0.0
    )
    assert drive.tooth_stiffness_N_per_mm < drive_of(rigid).tooth_stiffness_N_per_mm
    assert (np.diff(drive.pulley_coupling_um_per_N) < 0).all()
    assert plastic.estimate is not None
    assert set(plastic.estimate["by_source"]) == {"elements body 1", "elements body 2"}
    assert set(rigid.estimate["by_source"] if rigid.estimate else ()) == {"elements"}
    assert plastic.cost["degrees_of_freedom"] > rigid.cost["degrees_of_freedom"]
    # stresses that may leave the plane leave the pulley softer
    thin = solved(body_1=ELASTIC | {"young_modulus_MPa": 1000}, accuracy={"plane": "stress"})
    wide = solved(body_1=ELASTIC | {"young_modulus_MPa": 1000})
    assert thin.rotation_rad > wide.rotation_rad


def test_estimate_knows_strands_over_grooves() -> None:
    """The contact that holds a belt at the edge of a land is no shorter with shorter elements."""
    wrap = {"body_2": {"wrapped_teeth": 5}, "positions": {"angles_deg": [7.5]}}
    size = {"flank_element_mm": None, "estimate": True}
    result = solved(**wrap, accuracy=size)
    finer = solved(**wrap, accuracy={"flank_element_mm": 0.208, "estimate": False})
    assert result.estimate is not None
    off = np.abs(result.rotation_rad / finer.rotation_rad - 1).max()
    assert off < result.estimate["transmission_error"] < 10 * off


def test_estimate_of_an_elastic_pulley_is_the_change_by_finer_elements() -> None:
    body = ELASTIC | {"young_modulus_MPa": 1000}
    result = solved(body_1=body, accuracy={"flank_element_mm": 0.625, "estimate": True})
    finer = solved(body_1=body, accuracy={"flank_element_mm": 0.208, "estimate": False})
    assert result.estimate is not None
    off = abs(float(finer.rotation_rad[0] / result.rotation_rad[0]) - 1)
    assert 0.5 * off < result.estimate["transmission_error"] < 10 * off


def test_lands_rub_on_an_elastic_pulley_and_lift_off_it() -> None:
    body = ELASTIC | {"young_modulus_MPa": 1000}
    for coefficient in (0.1, -0.1):
        result = solved(body_1=body, effects={"land_friction": coefficient})
        drive = drive_of(result)
        assert drive.land_friction_N[0] * coefficient > 0
        whole = result.site_force_N.sum() + drive.land_friction_N[0]
        np.testing.assert_allclose(whole, drive.tight_tension_N[0] - 320.0, rtol=SOLVER, atol=0)
    free = drive_of(solved(body_1=body, load={"slack_tension_N": 2}, effects={"land_lift": True}))
    assert free.last_land_lift_um[0] > 0
    assert free.lands_N.min() > -1e-6


def test_check_and_mesh_show_an_elastic_pulley(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(PLASTIC)]) == 0
    said = capsys.readouterr().out
    assert "20.0000 mm, fixed" in said
    assert "1000 MPa, plane strain" in said
    assert main(["mesh", str(PLASTIC), "-o", str(tmp_path)]) == 0
    assert "one of 24 sectors" in capsys.readouterr().out
    assert main(["check", str(tmp_path / "body_1.msh")]) == 0
    assert "match when turned by 360/24 deg" in capsys.readouterr().out


def test_exports_have_lands(tmp_path: Path) -> None:
    result = solved()
    drive = drive_of(result)
    tree = json.loads(result.to_json())
    assert len(tree["drive"]["land_before_N"][0]) == 5
    assert tree["drive"]["cord_stiffness_N"] == drive.cord_stiffness_N
    (row,) = csv.DictReader(io.StringIO(result.to_csv()))
    assert float(row["tight_tension_N"]) == drive.tight_tension_N[0]
    assert float(row["land_before_N_pair_3"]) == drive.land_before_N[0, 3]


def test_run_draws_and_check_describes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(EXAMPLE), "--plot", str(tmp_path), "--quiet"]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        "belt_on_pulley.png",
        "load_around_wrap.png",
    }
    assert main(["check", str(EXAMPLE)]) == 0
    assert "half of both tensions: 640 N" in capsys.readouterr().out


def test_costs_are_a_table_without_a_plan() -> None:
    found = fl.solve(fl.Scene.from_dict(tables(**{**SMALL, "load": {"torque_Nm": [5, 10]}})))
    lines = [line.split() for line in found.cost_table().splitlines()]
    assert ["states", "2", "2"] in lines
    assert ["fe", "factorisations", "3", "3"] in lines


def test_positions_have_teeth_that_enter_and_leave() -> None:
    result = solved(**POSITIONS)
    drive = drive_of(result)
    force = 1000.0 * result.torque_Nm / result.reference_radius_mm
    assert result.sites.tolist() == [-1, 0, 1, 2, 3, 4]
    np.testing.assert_allclose(result.site_force_N.sum(axis=1), force, rtol=SOLVER, atol=0.0)
    there = np.isfinite(drive.tension_behind_N)
    assert (there.sum(axis=1) == 5).all()
    assert there[:4, 1:].all()
    assert there[4:, :-1].all()
    assert (result.site_force_N[~there] == 0).all()
    # six lands: that behind the last tooth is before a tooth of the table, where that has left
    assert (np.isfinite(drive.lands_N).sum(axis=1) == 6).all()
    assert np.isfinite(drive.last_land_N).tolist() == [True] * 4 + [False] * 4
    # one pitch on all is the same, one tooth further
    np.testing.assert_allclose(
        result.site_force_N[-1, :-1], result.site_force_N[0, 1:], rtol=SOLVER, atol=SOLVER * force
    )
    np.testing.assert_allclose(
        result.transmission_error_um[-1], result.transmission_error_um[0], rtol=SOLVER, atol=0.0
    )
    tree = json.loads(result.to_json())
    assert tree["drive"]["tension_behind_N"][0][0] is None
    assert "first tooth" in result.table()


def test_single_position_is_the_first_of_many() -> None:
    one, two = solved(), solved(positions={"count": 2})
    assert one.position_rad.tolist() == [0.0]
    np.testing.assert_allclose(two.rotation_rad[0], one.rotation_rad[0], rtol=SOLVER, atol=0.0)


@pytest.mark.parametrize(
    "changes",
    [
        POSITIONS,
        {**POSITIONS, "effects": {"land_friction": 0.1}, "accuracy": {"estimate": True}},
        {**POSITIONS, "effects": {"land_lift": True}, "load": {"torque_Nm": [0, 5]}},
        {"body_2": {"wrapped_teeth": 1}},
        {**POSITIONS, "body_1": ELASTIC, "effects": {"land_friction": 0.1}},
        {"body_1": ELASTIC, "accuracy": {"estimate": True}, "load": {"torque_Nm": [0, 5, 10]}},
    ],
)
def test_work_is_counted_before_it_is_done(changes: dict[str, Any]) -> None:
    merged = {
        table: {**SMALL.get(table, {}), **changes.get(table, {})} for table in {**SMALL, **changes}
    }
    found = fl.solve(fl.Scene.from_dict(tables(**merged)))
    stages = found.cost["stages"]
    assert stages.pop("result")["counters"] == {}
    for stage in stages.values():
        spent = {name: n for name, n in stage["counters"].items() if name != "pivots"}
        counted = {name: n for name, n in stage["predicted"]["counters"].items() if n}
        assert spent == counted


def test_pictures_of_positions() -> None:
    result = solved(**POSITIONS)
    assert set(pictures_of(result)) == {
        "belt_on_pulley",
        "load_around_wrap",
        "load_map",
        "transmission_error",
        "force_through_wrap",
    }
    for name in ("load_map", "transmission_error", "force_through_wrap"):  # a run draws the others
        assert PICTURES[name](result).axes


def test_commands_that_need_two_bodies_with_flanks_say_so(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["mesh", str(EXAMPLE), "-o", "."]) == 2
    assert "body_2.kind: expected bodies with flanks" in capsys.readouterr().err
