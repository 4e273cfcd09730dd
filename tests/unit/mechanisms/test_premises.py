"""Premises of the model: a violation is refused with its number, or marked if it is permitted.

Every refusal is a `PremiseError`, exit code 2, and the same through all interfaces.
"""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.cli import main
from flankload.contact.flank_contact import FlankContact
from flankload.contact.sweep import sweep
from flankload.elasticity.compliance import no_compliance
from flankload.mechanisms.flank_pair import premises
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.result.geometry import pair_geometry
from flankload.scene.named_discretization import NamedDiscretization
from flankload.studies.accuracy.runs import Runs
from flankload.studies.accuracy.study import Row
from flankload.studies.accuracy.study_text import limit_notes
from tests.support.cam_scenes import cam_scene
from tests.support.gear_scenes import RING, changed
from tests.support.paths import SCENES

COARSE = {"flank_element_mm": 2.0, "estimate": False, "tangents": False}
ALLOWED = {"beyond_limits": True}
#: Tips so short that between two pairs of flanks none touches in the path of contact.
SHORT = {"body_1__tip_diameter_mm": 75.5, "body_2__tip_diameter_mm": 75.5}


def gears(**changes: Any) -> fl.Scene:
    tables = {"positions__count": 2, "accuracy": COARSE, **changes}
    return fl.Scene.from_dict(changed(**tables))


def refused(scene: fl.Scene) -> fl.PremiseError:
    with pytest.raises(fl.PremiseError) as caught:
        fl.solve(scene)
    assert "(or effects.beyond_limits = true)" in caught.value.expected
    return caught.value


def one_result(scene: fl.Scene) -> fl.Result:
    found = fl.solve(scene)
    assert isinstance(found, fl.Result)
    return found


# --- each premise ---------------------------------------------------------------------------------
def test_a_contact_ratio_below_1_is_refused_before_elements_are_solved() -> None:
    stages: list[str] = []
    with pytest.raises(fl.PremiseError) as caught:
        fl.solve(gears(**SHORT), lambda stage, *_: stages.append(stage))
    assert caught.value.key == "pair.center_distance_mm"
    assert caught.value.expected.startswith("a contact ratio of at least 1 ")
    assert float(caught.value.found.split()[0]) < 1.0
    assert set(stages) == {"bodies"}


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        (
            {"body_1__bore_diameter_mm": 57.0},
            "body_1.bore_diameter_mm",
            'a held rim of at least 0.5 tooth heights, or bore = "torque"',
            "0.17 tooth heights (1.88 mm)",
        ),
        (
            {"body_2": {**RING, "outer_diameter_mm": 293.0}, "pair__center_distance_mm": 99.0},
            "body_2.outer_diameter_mm",
            'a held rim of at least 1.75 modules, or rim = "torque"',
            "1.33 modules (6 mm)",
        ),
    ],
    ids=["gear", "ring"],
)
def test_a_thin_rim_that_is_held_is_refused_before_elements_are_solved(
    changes: dict[str, Any], key: str, expected: str, found: str
) -> None:
    """Regression: a rim of half a millimetre passed, and was stiffer than a solid gear."""
    scene = gears(**changes)
    error = refused(scene)
    assert (error.key, error.found) == (key, found)
    assert error.expected.startswith(expected)
    (broken,) = premises.broken_by_geometry(build_bodies(scene))
    assert broken.premise.name == "rim"
    support = "bore" if key.startswith("body_1") else "rim"
    free = scene.replace({f"{key.partition('.')[0]}.{support}": "torque"})
    assert not list(premises.broken_by_geometry(build_bodies(free)))


def test_teeth_that_give_way_too_far_are_refused_and_the_torque_is_named() -> None:
    found = refused(gears(load__torque_Nm=[302, 10000]))
    assert found.key == "load.torque_Nm[1]"
    assert found.expected.startswith("flank deflections of at most 0.1 of a module")
    assert found.found.endswith("under 10000 N m")
    assert refused(gears(load__torque_Nm=10000)).key == "load.torque_Nm"


def test_a_modulus_in_GPa_is_blamed() -> None:
    """Regression: the search for contact gave up, with exit 1 and a word about its cells."""
    soft = {f"body_{z}__young_modulus_MPa": 206 for z in (1, 2)}
    found = refused(gears(**soft, positions__count=4))
    assert found.key == "body_1.young_modulus_MPa"
    assert "did you mean 206000?" in found.found
    assert "under 302 N m" in found.found


def test_a_follower_that_turns_by_a_tenth_of_a_radian_is_refused() -> None:
    """A cam has no module."""
    tables = cam_scene(accuracy=COARSE)
    tables["body_1"]["young_modulus_MPa"] = 500.0
    tables["load"]["torque_Nm"] *= 4
    found = refused(fl.Scene.from_dict(tables))
    assert found.key == "load.torque_Nm"
    assert "of a radian under" in found.found


def test_pressure_is_compared_with_the_softer_elastic_body() -> None:
    """Gears exceed other limits first, so the peaks of a sweep are set to reach this one."""
    scene = gears(body_1__rigid=True, body_1__young_modulus_MPa=1000)
    pair = build_bodies(scene)
    nothing = (no_compliance(pair.body_1), no_compliance(pair.body_2))
    (found,) = sweep(
        FlankContact(pair, nothing, pair.discretization.grid),
        pair.position_rad,
        [0.0],
    )
    geometry = pair_geometry(pair, nothing)

    def broken(pressure: float, corner: int) -> list[str]:
        peak = np.full_like(found.site_peak_N_per_mm, 14.0 * pressure)
        there = replace(
            found, site_peak_N_per_mm=peak, site_corner=np.full_like(found.site_corner, corner)
        )
        return [
            one.found for one in premises.broken_by_load(scene, pair, geometry, there, number=0)
        ]

    assert broken(0.49 * 206000, 0) == []
    assert broken(0.6 * 206000, 0) == ["0.6 of 206000 MPa under 302 N m"]
    assert broken(0.6 * 206000, 1) == []  # on a sharp corner


def test_pressures_of_slices_are_not_divided_by_the_width() -> None:
    """Regression: a pressure of 14 times the limit passed on gears 14 mm wide."""
    scene = gears(effects__dimension=3, body_1__rigid=True)
    pair = build_bodies(scene)
    nothing = (no_compliance(pair.body_1), no_compliance(pair.body_2))
    (found,) = sweep(
        FlankContact(pair, nothing, pair.discretization.grid, "lumped"),
        pair.position_rad,
        [0.0],
    )
    geometry = pair_geometry(pair, nothing)
    for part, count in ((0.49, 0), (0.6, 1)):
        peak = np.full_like(found.site_peak_N_per_mm, part * 206000)
        there = replace(
            found, site_peak_N_per_mm=peak, site_corner=np.zeros_like(found.site_corner)
        )
        broken = premises.broken_by_load(scene, pair, geometry, there, number=0)
        assert len(list(broken)) == count


def test_backlash_that_is_taken_up_is_refused() -> None:
    """A tooth that is 40 um ahead turns body 1 back until coast flanks overlap."""
    errors = {"body_1__pitch_errors_um": [40.0] + [0.0] * 15, "load__torque_Nm": 1}
    found = refused(gears(**errors))
    assert found.key == "body_1.pitch_errors_um"
    assert "effects.coast_flank = true" in found.expected
    assert found.found.startswith("about 4")  # the error, and the deflection of the teeth
    one_result(gears(**errors, effects={"coast_flank": True}))
    one_result(gears(load__torque_Nm=1))  # no backlash at all, and no overlap


@pytest.mark.parametrize(
    "keys",
    [
        {"body_1__tip_radius_mm": 0.3, "body_2__tip_chamfer_mm": 0.3},
        {"effects__near_field": "nodes"},
    ],
)
def test_coast_flanks_of_rounded_tips_and_nodal_forces_are_found(keys: dict[str, Any]) -> None:
    """Regression: the core refused the bodies without elasticity, and no gap was known."""
    found = refused(gears(pair__center_distance_mm=71.95, load__torque_Nm=10, **keys))
    assert found.key == "pair.center_distance_mm"
    # at most 2 sin(20 deg) 50 um; less if few nodes leave gaps
    assert 20.0 < float(found.found.split()[1]) < 34.2


#: A centre distance of four decimals at which the teeth have a backlash of -0.14 um.
ROUNDED = {"pair__center_distance_mm": 71.9998, "load__torque_Nm": 0.32}


def test_a_backlash_of_minus_0_14_um_is_that_of_a_rounded_centre_distance() -> None:
    found = one_result(gears(**ROUNDED))
    assert found.outside_limits == ()
    assert not [warning for warning in found.warnings if "backlash" in warning]


def test_misalignment_that_takes_up_the_backlash_is_blamed() -> None:
    """Regression: 12 um/mm blamed the centre distance."""
    coarse = COARSE | {"slices": 4, "axial_degree": 5, "modes": 3}
    tilted = {"pair__deviation_um_per_mm": 12, "pair__inclination_um_per_mm": 1}
    found = refused(gears(**ROUNDED, **tilted, accuracy=coarse))
    assert found.key == "pair.deviation_um_per_mm"
    assert "um of overlap under 0.32 N m" in found.found


@pytest.mark.parametrize(
    ("nearer_um", "torque_Nm", "touch"),
    [(10, 302, False), (10, 100, True), (30, 1500, False), (30, 302, True), (0, 30, False)],
)
def test_backlash_is_taken_up_where_coast_flanks_would_carry(
    nearer_um: float, torque_Nm: float, touch: bool
) -> None:
    """Against coast flanks that are there: they change the transmission error by 9 % or 0.3 %."""
    tables = tomllib.loads((SCENES / "external_gear.toml").read_text("utf-8"))
    tables["pair"]["center_distance_mm"] -= nearer_um / 1000.0
    tables["load"]["torque_Nm"] = torque_Nm
    tables |= {"positions": {"count": 4}, "accuracy": COARSE}
    with_coast, without = (
        one_result(fl.Scene.from_dict({**tables, "effects": effects}))
        for effects in ({"coast_flank": True}, ALLOWED)
    )
    change = np.abs(with_coast.rotation_rad / without.rotation_rad - 1.0).max()
    assert (change > 0.05) == touch
    assert change < 0.01 or touch
    assert without.outside_limits == (("backlash",) if touch else ())


@pytest.mark.parametrize("solved", [fl.solve, fl.plan], ids=lambda f: f.__name__)
@pytest.mark.parametrize(
    ("name", "body", "softer"),
    [
        ("belt_plastic_pulley", "body_1", {"young_modulus_MPa": 500.0}),
        ("chain", "body_2", {"link_stiffness_N": 2e4}),
    ],
)
def test_chains_and_belts_that_turn_too_far_are_refused(
    name: str, body: str, softer: dict[str, float], solved: Any
) -> None:
    tables = tomllib.loads((SCENES / f"{name}.toml").read_text("utf-8"))
    tables["accuracy"], tables["positions"] = {"estimate": False}, {"count": 1}
    tables[body] |= softer
    tables["load"]["torque_Nm"] *= 3
    with pytest.raises(
        fl.PremiseError, match=r"a rotation of body 1 under load of at most 0\.1 of a"
    ):
        solved(fl.Scene.from_dict(tables))


# --- where it is meant ----------------------------------------------------------------------------
@pytest.fixture(scope="module")
def beyond() -> tuple[fl.Result, ...]:
    scene = gears(
        **SHORT,
        load__torque_Nm=[302, 10000],
        effects=ALLOWED,
        accuracy={"flank_element_mm": 2.0, "tolerance": 0.05},
    )
    return fl.solve(scene).by_torque


def test_results_beyond_limits_name_their_premises(beyond: tuple[fl.Result, ...]) -> None:
    small, large = beyond
    assert small.outside_limits == ("contact_ratio",)
    assert large.outside_limits == ("contact_ratio", "deflection", "rotation")
    assert large.warnings[0].startswith("outside the model's limits: pair.center_distance_mm: ")
    assert large.warnings[1].startswith("outside the model's limits: load.torque_Nm[1]: ")


def test_no_error_estimate_beyond_limits_goes_without_these_words(
    beyond: tuple[fl.Result, ...],
) -> None:
    for result in beyond:
        assert result.estimate is not None
        assert result.estimate["outside_limits"] == result.outside_limits
        labels = ("estimated error", "by positions alone", "tolerance  ")
        lines = [line for line in result.table().splitlines() if line.startswith(labels)]
        assert len(lines) == 3
        assert all("outside the model's limits (contact ratio" in line for line in lines)
        tree = json.loads(result.to_json())
        assert tree["outside_limits"] == list(result.outside_limits)
        assert tree["estimate"]["outside_limits"] == list(result.outside_limits)


def test_a_result_within_limits_says_nothing() -> None:
    result = one_result(gears(effects=ALLOWED))
    assert result.outside_limits == ()
    assert "outside" not in result.table()
    assert "outside_limits" not in json.loads(result.to_json())


# --- all interfaces -------------------------------------------------------------------------------
@pytest.fixture
def short_scene(tmp_path: Path) -> Path:
    path = tmp_path / "short.toml"
    text = (SCENES / "external_gear.toml").read_text("utf-8")
    path.write_text(text.replace("82.46", "79.0").replace("118.36", "114.0"), "utf-8")
    return path


@pytest.mark.parametrize("command", ["run", "plan", "accuracy", "verify", "check"])
def test_every_command_refuses_with_exit_2_and_one_line(
    command: str, short_scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command, str(short_scene)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    start = f"flankload: {short_scene}: pair.center_distance_mm: expected a contact ratio of at"
    assert line.startswith(start)


@pytest.mark.parametrize("solved", [fl.plan, fl.accuracy, fl.verify], ids=lambda f: f.__name__)
def test_functions_refuse_premises_broken_by_the_load(solved: Any) -> None:
    with pytest.raises(fl.PremiseError, match=r"load\.torque_Nm: expected flank deflections"):
        solved(gears(load__torque_Nm=10000))


def test_a_study_beyond_limits_says_so() -> None:
    run = Runs(gears(load__torque_Nm=[302, 10000], effects=ALLOWED)).at(NamedDiscretization())
    assert run.outside == ("deflection",)
    assert limit_notes([Row("default", run, {}, {})]) == (
        "errors outside the model's limits (deflection)",
    )
    assert limit_notes([Row("default", replace(run, outside=()), {}, {})]) == ()
