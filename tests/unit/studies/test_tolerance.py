"""A named tolerance: its runs, their refinement, and the report."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.analysis.estimate import ON_CORNERS
from flankload.base.number_text import percent
from flankload.cli import main
from flankload.mechanisms import mechanism_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.notes import ELEMENT_RESERVE
from flankload.mechanisms.parameters import (
    ANYWHERE,
    ELEMENTS_WORK,
    LEAST_PART,
    Parameters,
    relative,
)
from flankload.result.notes import accuracy_lines
from flankload.scene.discretization import elements_for_modes
from flankload.scene.named_discretization import NamedDiscretization
from flankload.scene.steps import DEGREE, ELEMENTS, LOAD_DEGREE, MODES, SLICES, STEPS, STRIPS
from flankload.studies.tolerance import (
    AIM,
    MOST_POSITIONS,
    MOST_RUNS,
    PATIENCE,
    choose_discretization,
    finer_positions,
    first_choice,
    first_scene,
)
from flankload.studies.tolerance_report import (
    BOUND,
    OF_LARGEST,
    Attempt,
    Choice,
    errors_by_source,
    tolerance_report,
)
from tests.support.paths import SCENES
from tests.support.small_job import SCENE
from tests.support.tolerances import ROUND_OFF

#: That the default of `small` misses: its dominant sources are modes and named positions.
TIGHT = 0.003


def parameters_of(scene: fl.Scene) -> Parameters:
    return mechanism_of(scene).parameters(scene)


def small(**accuracy: Any) -> dict[str, Any]:
    """A gear on a rigid wheel, six positions."""
    tree = tomllib.loads(SCENE)
    tree["body_2"]["rigid"] = True
    tree["positions"]["count"] = 6
    tree["accuracy"] = accuracy
    return tree


def single(**accuracy: Any) -> dict[str, Any]:
    """The same at single positions, without an error between them."""
    angles = [0.0, 3.75, 7.5, 11.25, 15.0, 18.75]
    return {**small(**accuracy), "positions": {"angles_deg": angles}}


def solved(tree: dict[str, Any]) -> fl.Result:
    result = fl.solve(fl.Scene.from_dict(tree))
    assert isinstance(result, fl.Result)
    return result


def said(result: fl.Result) -> dict[str, Any]:
    assert result.accuracy is not None
    return dict(result.accuracy)


@pytest.fixture(scope="module")
def met() -> fl.Result:
    """A tolerance that the default meets at single positions."""
    return solved(single(tolerance=0.1))


@pytest.fixture(scope="module")
def tight() -> fl.Result:
    """A tolerance that the default misses."""
    return solved(small(tolerance=TIGHT))


def written_out(tree: dict[str, Any], found: dict[str, Any]) -> dict[str, Any]:
    """The scene with the keys that were chosen, and no tolerance."""
    tables = {name: {**tree.get(name, {}), **keys} for name, keys in found["keys"].items()}
    accuracy = {**tree["accuracy"], **found["keys"].get("accuracy", {})}
    accuracy.pop("tolerance")
    return {**tree, **tables, "accuracy": accuracy}


def assert_same(one: fl.Result, two: fl.Result) -> None:
    for name in ("position_rad", "rotation_rad", "site_force_N", "peak_pressure_MPa"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert one.estimate == two.estimate


# --- without the key ------------------------------------------------------------------------------
def test_without_the_key_nothing_is_decided() -> None:
    scene = fl.Scene.from_dict(small(modes=4, estimate=False))
    assert not scene.names_tolerance
    assert first_scene(scene) is scene
    result = fl.solve(scene)
    assert isinstance(result, fl.Result)
    assert result.accuracy is None
    assert "accuracy" not in json.loads(result.to_json())
    assert "steering" not in result.cost["stages"]


# --- runs -----------------------------------------------------------------------------------------
def test_a_tolerance_that_the_first_run_meets_takes_one_coarse_run(met: fl.Result) -> None:
    found = said(met)
    assert found["met"]
    strips = {"strips_per_half_width": 8.0, "corner_strips_per_half_width": 24.0}
    assert found["keys"] == {"accuracy": {"flank_element_mm": 1.6, "modes": 4, **strips}}
    assert found["tightened"] == {}
    assert "first run" not in met.cost["stages"]
    assert_same(met, solved(written_out(single(tolerance=0.1), found)))


@pytest.mark.parametrize(("tolerance", "modes"), [(0.1, 4), (0.01, 4), (0.005, 5)])
@pytest.mark.parametrize("name", ["external_gear", "internal_gear", "spline", "cam"])
def test_first_elements_are_coarse_and_resolve_the_modes(
    name: str, tolerance: float, modes: int
) -> None:
    tree = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    scene = fl.Scene.from_dict({**tree, "accuracy": {"tolerance": tolerance}})
    parameters = parameters_of(scene)
    values = first_choice(scene, parameters).values
    assert values[MODES] == modes
    resolved = elements_for_modes(5) / elements_for_modes(modes)
    part = STEPS[ELEMENTS].refined[0] if name == "cam" else ELEMENT_RESERVE * resolved
    assert values[ELEMENTS] == pytest.approx(part * parameters.values[ELEMENTS], rel=0.005, abs=0.0)
    assert values[STRIPS] == STEPS[STRIPS].refined[0] < parameters.values[STRIPS]
    pair = build_bodies(first_scene(scene))
    for body in (pair.body_1, pair.body_2):
        assert body.mesh is not None
        assert elements_for_modes(int(values[MODES])) <= ELEMENT_RESERVE * body.mesh.flank_elements


@pytest.mark.parametrize("keys", [{"modes": 8, "strips_per_half_width": 12.0}, {"estimate": False}])
def test_first_run_is_not_coarse_where_nothing_allows_or_judges_it(keys: dict[str, Any]) -> None:
    """Longer elements do not resolve eight modes; without an estimate no run follows."""
    scene = fl.Scene.from_dict(small(tolerance=0.01, **keys))
    parameters = parameters_of(scene)
    assert first_choice(scene, parameters).values == parameters.values


def test_refined_result_is_that_of_the_keys_written_out(tight: fl.Result) -> None:
    found = said(tight)
    assert found["tightened"]
    assert_same(tight, solved(written_out(small(tolerance=TIGHT), found)))


def test_refinement_helps(tight: fl.Result) -> None:
    found = said(tight)
    worst = "transmission_error"
    assert found["errors_before"][worst] > found["tolerance"] >= found["errors"][worst]


def test_the_verdict_is_that_of_the_last_run(tight: fl.Result) -> None:
    found, estimate = said(tight), tight.estimate
    assert estimate is not None
    curve = tight.transmission_error_um
    part = np.ptp(curve) / np.abs(curve).max()
    for quantity in BOUND:
        scale = part if quantity == OF_LARGEST else 1.0
        assert found["errors"][quantity] == pytest.approx(
            scale * estimate[quantity], rel=ROUND_OFF, abs=0.0
        )
    assert found["met"] == (max(found["errors"].values()) <= found["tolerance"])
    assert {one["quantity"] for one in found["missed"]} == {
        quantity for quantity, error in found["errors"].items() if error > found["tolerance"]
    }


def test_first_run_is_counted(tight: fl.Result) -> None:
    """A body's elements twice, the first time in a stage of its own."""
    stages = tight.cost["stages"]
    assert stages["first run"]["counters"]["fe_factorisations"] == 1
    assert tight.cost["fe_factorisations"] == 2
    states = sum(stage["counters"].get("states", 0) for stage in stages.values())
    assert tight.cost["states"] == states


def test_elements_are_kept_where_strips_alone_are_refined() -> None:
    tree = tomllib.loads((SCENES / "cam.toml").read_text(encoding="utf-8"))
    tree["positions"]["count"] = 8
    tree["accuracy"] = {"tolerance": 0.0015, "flank_element_mm": 3.0, "modes": 4}
    result = solved(tree)
    assert said(result)["met"]
    assert list(said(result)["tightened"]) == ["strips_per_half_width"]
    assert "fe_factorisations" not in result.cost["stages"]["first run"]["counters"]
    assert result.cost["fe_factorisations"] == 2


def test_named_elements_carry_no_more_modes_than_they_bear() -> None:
    """Regression: five elements had 3 modes, an error of 28 %; 4 are better on any elements."""
    found = said(solved(single(tolerance=0.1, flank_element_mm=2.0)))
    assert found["keys"]["accuracy"]["modes"] == 4
    assert found["met"]


def test_named_parameters_stay_and_are_blamed() -> None:
    result = solved(small(tolerance=1e-4, flank_element_mm=2.0, modes=4, strips_per_half_width=6.0))
    found = said(result)
    assert found["keys"] == {}
    assert found["tightened"] == {}
    assert not found["met"]
    reasons = {one["source"]: one["why"] for one in found["missed"]}
    assert reasons["elements"] == "accuracy.flank_element_mm is set"
    assert all("modes" in one["beside"] for one in found["missed"])
    assert found["knobs"]["positions"]["left_as_it_is"] == "positions.count is set"
    values = {name: row["value"] for name, row in found["knobs"].items()}
    assert values == {ELEMENTS: 2.0, MODES: 4, STRIPS: 6.0, "positions": 6}


def test_positions_follow_the_tolerance_where_none_are_named() -> None:
    tree = small(tolerance=0.1, flank_element_mm=2.0)
    del tree["positions"]
    result = solved(tree)
    assert said(result)["keys"]["positions"]["adaptive"] is True
    assert result.estimate is not None
    assert "positions" in result.estimate["by_source"]
    assert_same(result, solved(written_out(tree, said(result))))


def test_positions_are_refined_for_the_rotation_and_for_other_curves() -> None:
    positions = NamedDiscretization(count=16, adaptive=0.003)
    errors = {OF_LARGEST: 0.002, "stiffness_secant": 0.004}
    finer, left = finer_positions(positions, errors, 0.001)
    assert (finer.count, finer.adaptive) == (32, 0.0015)
    assert left == {OF_LARGEST: 0.001, "stiffness_secant": 0.001}
    assert finer_positions(positions, left, 0.001) == (positions, left)
    most, left = finer_positions(positions, {"stiffness_secant": 1.0}, 1e-6)
    assert most.count == MOST_POSITIONS
    assert left["stiffness_secant"] == pytest.approx((16 / MOST_POSITIONS) ** 2, rel=ROUND_OFF)


def test_several_torques_share_their_discretization() -> None:
    tree = small(tolerance=0.1, flank_element_mm=2.0)
    tree["load"]["torque_Nm"] = [0.0, 30.0, 300.0]
    results = fl.solve(fl.Scene.from_dict(tree)).by_torque
    assert len({json.dumps(said(result)) for result in results}) == 1
    errors = [result.estimate["load_share"] for result in results if result.estimate is not None]
    assert said(results[0])["errors"]["load_share"] == max(errors)


# --- without a check, or a refinement -------------------------------------------------------------
def test_without_estimate_the_default_is_not_checked() -> None:
    result = solved(small(tolerance=0.01, estimate=False))
    found = said(result)
    assert found["met"] is None
    assert found["unchecked"] == "default discretization, not checked (accuracy.estimate = false)"
    assert_same(result, solved(small(estimate=False)))


def test_without_torque_nothing_is_approximated() -> None:
    tree = small(tolerance=0.01, flank_element_mm=2.0)
    tree["load"]["torque_Nm"] = 0.0
    assert said(solved(tree))["unchecked"] == "without torque there is no approximation"


def test_pressure_on_sharp_corners_is_not_certain(met: fl.Result) -> None:
    scene = fl.Scene.from_dict(small(tolerance=0.1))
    parameters = parameters_of(scene)
    estimate = {**(met.estimate or {}), "uncertain": {"peak_pressure": ON_CORNERS}}
    at_corners = replace(met, estimate=estimate)
    for result, verdict in ((met, True), (at_corners, None)):
        run = Attempt.of(first_choice(scene, parameters), (result,))
        report = tolerance_report(scene, parameters, [run])
        assert report["met"] is verdict
        lines = accuracy_lines(report)
        assert any(line.startswith("not certain: peak pressure: ") for line in lines) is not verdict
        state = "met" if verdict else "not certain (peak pressure), all else met"
        assert lines[0].startswith(f"10 %: {state}, ")
    report = tolerance_report(fl.Scene.from_dict(small(tolerance=1e-4)), parameters, [run])
    assert report["met"] is False


def test_uncertain_quantities_are_missed_beyond_the_tolerance(met: fl.Result) -> None:
    uncertain = replace(met, estimate={**(met.estimate or {}), "uncertain": {"peak_pressure": ""}})
    for error, result, missed in (
        (0.009, uncertain, False),
        (0.011, met, True),
        (0.011, uncertain, True),
    ):
        parameters, run = attempt({"modes": error}, result, quantity="peak_pressure")
        errors = dict.fromkeys(BOUND, 0.0) | run.errors
        run = replace(run, errors=errors)
        assert run.missed(0.01) == ["peak_pressure"] * missed
        assert (choose_discretization(parameters, [run], 0.01) is not None) is missed
        report = tolerance_report(fl.Scene.from_dict(small(tolerance=0.01)), parameters, [run])
        assert report["met"] is (False if missed else None)


def test_chain_has_no_parameters() -> None:
    tree = tomllib.loads((SCENES / "chain.toml").read_text(encoding="utf-8"))
    plain = solved(tree)
    result = solved({**tree, "accuracy": {"tolerance": 0.01}})
    assert set(said(result)["knobs"]) == {"positions"}
    assert said(result)["keys"] == {}
    np.testing.assert_array_equal(result.rotation_rad, plain.rotation_rad)


def belt(**accuracy: Any) -> dict[str, Any]:
    tree = tomllib.loads((SCENES / "belt.toml").read_text(encoding="utf-8"))
    return {**tree, "accuracy": accuracy}


def test_elements_of_a_belt_follow_the_tolerance() -> None:
    """At the default length its estimate is between 0.8 % and 1.2 %."""
    plain, finer = said(solved(belt(tolerance=0.012))), said(solved(belt(tolerance=0.008)))
    assert plain["met"]
    assert set(plain["knobs"]) == {ELEMENTS, "positions"}
    assert plain["knobs"]["positions"]["left_as_it_is"].startswith(
        "a belt has positions.count equally spaced"
    )
    assert plain["keys"] == {}
    assert set(finer["keys"]) == {"accuracy"}
    assert list(finer["tightened"]) == [ELEMENTS]


def test_elements_of_belt_and_pulley_are_one_source() -> None:
    tree = tomllib.loads((SCENES / "belt_plastic_pulley.toml").read_text(encoding="utf-8"))
    result = solved({**tree, "accuracy": {"flank_element_mm": 0.8}})
    by_source = errors_by_source([result])
    assert result.estimate is not None
    assert set(by_source) == {"elements"}
    for quantity in ("transmission_error", "load_share"):
        assert by_source["elements"][quantity] == pytest.approx(
            result.estimate[quantity], rel=ROUND_OFF, abs=0.0
        )


@pytest.mark.parametrize(
    ("keys", "name", "why"),
    [
        ({"effects": {"contact": "lumped"}}, STRIPS, "lumped contact has no"),
        ({"effects": {"near_field": "nodes"}}, MODES, "determined by the nodes of the flank"),
        ({"positions": {"adaptive": True}}, "positions", "positions.adaptive is set"),
    ],
)
def test_parameters_that_stay_say_why(keys: dict[str, Any], name: str, why: str) -> None:
    parameters = parameters_of(fl.Scene.from_dict({**small(tolerance=0.01), **keys}))
    assert parameters.fixed[name].startswith(why)
    assert name not in parameters.steps


SPATIAL = {"effects": {"dimension": 3}}


def test_three_dimensions_have_degrees_and_slices() -> None:
    """Pressure modes of a higher degree along the axis come with higher displacements."""
    parameters = parameters_of(fl.Scene.from_dict({**small(tolerance=0.01), **SPATIAL}))
    values = parameters.values
    assert (values[LOAD_DEGREE], values[DEGREE], values[SLICES]) == (4, 8, 28)
    assert STRIPS not in values
    finer = parameters.finer(values, "axial")
    assert finer == {**values, LOAD_DEGREE: 5, DEGREE: 9}
    assert parameters.finer(values, "slices") == {**values, SLICES: 40}


@pytest.mark.parametrize(
    ("keys", "source"),
    [({"axial_degree": 8}, "axial"), ({"load_degree_z": 4}, "axial"), ({"slices": 7}, "slices")],
)
def test_named_degrees_and_slices_stay(keys: dict[str, int], source: str) -> None:
    scene = fl.Scene.from_dict({**small(tolerance=0.01, **keys), **SPATIAL})
    parameters = parameters_of(scene)
    assert parameters.finer(parameters.values, source) is None


# --- the choice -----------------------------------------------------------------------------------
def attempt(
    by_source: dict[str, float], result: fl.Result, *, quantity: str = "load_share", **values: Any
) -> tuple[Any, Attempt]:
    """Parameters of a gear whose positions stay, and a run with errors of one quantity."""
    parameters = parameters_of(fl.Scene.from_dict(small(tolerance=0.01)))
    choice = first_choice(fl.Scene.from_dict(small(tolerance=0.01)), parameters)
    table = {
        source: {name: error * (name == quantity) for name in BOUND}
        for source, error in by_source.items()
    }
    errors = {quantity: float(np.linalg.norm(list(by_source.values())))}
    choice = replace(choice, values={**choice.values, **values})
    return parameters, Attempt(choice, (result,), errors, table)


@pytest.mark.parametrize(
    ("source", "name", "order"), [("strips", STRIPS, -2.0), ("elements", ELEMENTS, 2.0)]
)
def test_a_source_is_refined_by_its_order_and_no_further(
    met: fl.Result, source: str, name: str, order: float
) -> None:
    parameters, run = attempt({source: 0.03}, met)
    choice = choose_discretization(parameters, [run], 0.01)
    assert choice is not None
    changed = {key for key, x in choice.values.items() if x != run.choice.values[key]}
    assert changed == {name}
    steps = (run.choice.values[name], *parameters.steps[name])
    before = [x for x in steps if order * (x - choice.values[name]) > 0][-1]
    error = [0.03 * (x / steps[0]) ** order for x in (choice.values[name], before)]
    assert error[0] <= AIM * 0.01 < error[1]
    assert choice.foreseen["load_share"] == pytest.approx(error[0], rel=ROUND_OFF, abs=0.0)


def test_errors_that_add_up_with_their_signs_are_refined(met: fl.Result) -> None:
    """Regression: with the root of squares below the target, the same run was solved again."""
    parameters, run = attempt({"modes": 0.006, "strips": 0.006}, met)
    choice = choose_discretization(parameters, [replace(run, errors={"load_share": 0.0105})], 0.01)
    assert choice is not None
    assert choice.values != run.choice.values
    assert choice.foreseen["load_share"] <= AIM * 0.01


def test_a_met_tolerance_is_not_refined(met: fl.Result) -> None:
    assert choose_discretization(*_one(attempt({"strips": 0.0099}, met)), 0.01) is None


def _one(pair: tuple[Any, Attempt]) -> tuple[Any, list[Attempt]]:
    return pair[0], [pair[1]]


def test_a_quantity_that_no_parameter_answers_for_asks_for_no_run(met: fl.Result) -> None:
    assert choose_discretization(*_one(attempt({"tip": 0.03, "strips": 0.005}, met)), 0.01) is None


def test_errors_of_parameters_are_refined_beside_other_errors(met: fl.Result) -> None:
    """Regression: beside a fixed error of tips, modes with 1.5 % were not refined."""
    parameters, run = attempt({"tip": 0.0174, "modes": 0.0145}, met)
    choice = choose_discretization(parameters, [run], 0.01)
    assert choice is not None
    assert choice.values[MODES] > run.choice.values[MODES]
    assert choice.foreseen["load_share"] > 0.0174


def test_a_smaller_tolerance_never_chooses_less(met: fl.Result) -> None:
    parameters, run = attempt({"modes": 0.02, "strips": 0.007, "elements": 0.002}, met)
    before = run.choice.values
    for tolerance in (0.02, 0.015, 0.01, 0.007):
        choice = choose_discretization(parameters, [run], tolerance)
        assert choice is not None
        assert choice.values[MODES] >= before[MODES]
        assert choice.values[STRIPS] >= before[STRIPS]
        assert choice.values[ELEMENTS] <= before[ELEMENTS]
        before = choice.values


def test_an_unreachable_tolerance_costs_only_a_few_runs(met: fl.Result) -> None:
    """Far below the error of the finest elements: they are not all tried."""
    parameters, run = attempt({"elements": 1.0}, met)
    choice = choose_discretization(parameters, [run], 0.001)
    assert choice is not None
    part = choice.values[ELEMENTS] / run.choice.values[ELEMENTS]
    assert part > LEAST_PART
    assert relative(ELEMENTS_WORK, choice.values, parameters.values) <= PATIENCE


def test_the_choice_does_not_depend_on_measured_seconds(met: fl.Result) -> None:
    """Regression: a busy machine chose other elements and thus had other results."""
    stages = {name: {**one, "cpu_s": 1e3} for name, one in met.cost["stages"].items()}
    stages["sweep"]["cpu_s"] = 1e9
    busy = replace(met, cost={**met.cost, "stages": stages})
    chosen = [
        choose_discretization(*_one(attempt({"elements": 1.0}, result)), 0.001)
        for result in (met, busy)
    ]
    assert chosen[0] == chosen[1]


def test_elements_of_a_cam_converge_by_the_first_order(met: fl.Result) -> None:
    """Regression: with the second order, a run refined for 0.1 % had 0.108 %."""
    tree = tomllib.loads((SCENES / "cam.toml").read_text(encoding="utf-8"))
    parameters = parameters_of(fl.Scene.from_dict({**tree, "accuracy": {"tolerance": 0.001}}))
    _, run = attempt({"elements": 0.00145}, met, **parameters.values)
    choice = choose_discretization(parameters, [run], 0.001)
    assert choice is not None
    part = choice.values[ELEMENTS] / run.choice.values[ELEMENTS]
    assert choice.foreseen["load_share"] == pytest.approx(part * 0.00145, rel=ROUND_OFF, abs=0.0)


def test_cheap_strips_are_refined_where_elements_take_too_long(met: fl.Result) -> None:
    """Regression: they stayed at ten, with an error of pressure of 0.16 instead of 0.09 %."""
    parameters, run = attempt({"elements": 1.0, "strips": 0.02}, met)
    choice = choose_discretization(parameters, [run], 0.001)
    assert choice is not None
    assert choice.values[STRIPS] > 2 * run.choice.values[STRIPS]


def test_a_third_run_is_refined_like_the_second_one_and_is_the_last(met: fl.Result) -> None:
    parameters, run = attempt({"strips": 0.02, "modes": 0.008}, met)
    first = choose_discretization(parameters, [run], 0.01)
    second = choose_discretization(parameters, [run, run], 0.01)
    assert first is not None
    assert second is not None
    assert first.values[MODES] > run.choice.values[MODES]
    assert second.values == first.values
    assert choose_discretization(parameters, [run] * MOST_RUNS, 0.01) is None


@pytest.mark.parametrize("name", ["external_gear", "internal_gear", "spline"])
@pytest.mark.parametrize("modes", [0.012, 0.03, 0.06])
def test_elements_bear_the_modes_that_are_chosen(name: str, modes: float, met: fl.Result) -> None:
    """Checked on the meshed bodies, which the choice does not use."""
    tree = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    scene = fl.Scene.from_dict({**tree, "accuracy": {"tolerance": 0.01}})
    parameters = parameters_of(scene)
    _, run = attempt({"modes": modes}, met, **parameters.values)
    choice = choose_discretization(parameters, [run], 0.01)
    assert choice is not None
    assert choice.values[MODES] > max(ANYWHERE, run.choice.values[MODES])
    keys = choice.discretization(parameters).tables()["accuracy"]
    pair = build_bodies(fl.Scene.from_dict({**tree, "accuracy": keys}))
    for body in (pair.body_1, pair.body_2):
        assert body.mesh is not None
        assert elements_for_modes(keys[MODES]) <= ELEMENT_RESERVE * body.mesh.flank_elements


def test_more_modes_come_with_elements_that_bear_them_or_not_at_all() -> None:
    """Six modes need twelve elements; a flank has nine by default."""
    open_ = parameters_of(fl.Scene.from_dict(small(tolerance=0.01)))
    assert open_.finer(open_.values, "modes") == {**open_.values, MODES: 6, ELEMENTS: 0.75}
    named = parameters_of(fl.Scene.from_dict(small(tolerance=0.01, flank_element_mm=1.0)))
    assert named.values[MODES] == 5
    assert named.finer(named.values, "modes") is None


# --- why it is missed -----------------------------------------------------------------------------
def reasons(
    tree: dict[str, Any], result: fl.Result, values: dict[str, float], foreseen: float | None
) -> str:
    """Why elements are blamed for a missed tolerance."""
    scene = fl.Scene.from_dict({**tree, "accuracy": {"tolerance": 0.001}})
    parameters = parameters_of(scene)
    choice = Choice(
        {**parameters.values, **values},
        first_choice(scene, parameters).positions,
        {} if foreseen is None else {"transmission_error": foreseen},
    )
    error = {"transmission_error": 0.01}
    run = Attempt(choice, (result,), error, {"elements": error})
    (one,) = tolerance_report(scene, parameters, [run])["missed"]
    return str(one["why"])


def test_a_miss_names_its_limit(met: fl.Result) -> None:
    end, unlikely = (
        "the parameter is at its finest value",
        "no value of the parameter is likely to meet",
    )
    assert reasons(small(), met, {ELEMENTS: 0.2}, 0.0).startswith(end)
    assert reasons(small(), met, {}, None).startswith(unlikely)
    assert reasons(small(), met, {ELEMENTS: 0.5}, 0.002).startswith(unlikely)
    assert reasons(small(), met, {ELEMENTS: 0.5}, 0.0005).startswith("larger than predicted")


def test_a_belt_says_why_finer_elements_help_little(met: fl.Result) -> None:
    """Its corners are not those of contacts, and a tip radius would not help."""
    why = reasons(belt(), met, {ELEMENTS: 0.01}, 0.0)
    assert why.startswith(
        "the parameter is at its finest value; near the corners of teeth and lands"
    )
    assert "tip_radius_mm" not in why


def test_a_miss_names_all_sources_that_exceed_the_tolerance(met: fl.Result) -> None:
    """All of them, since reducing only the largest one would not meet the tolerance."""
    by_source = {"strips": 0.03, "modes": 0.02, "elements": 0.005}
    parameters, run = attempt(by_source, met, quantity="peak_pressure")
    found = tolerance_report(fl.Scene.from_dict(small(tolerance=0.01)), parameters, [run])
    (one,) = found["missed"]
    assert (one["source"], one["beside"]) == ("strips", ["modes"])
    assert accuracy_lines(found)[-1].startswith(
        "exceeded: peak pressure 3.6 %, mostly from strips (modes alone also exceeds the "
        "tolerance): "
    )


# --- messages -------------------------------------------------------------------------------------
def test_peak_to_peak_names_its_reference() -> None:
    """The error is relative to the largest value, not to a small peak to peak."""
    tree = tomllib.loads((SCENES / "cam.toml").read_text(encoding="utf-8"))
    tree["positions"]["count"] = 12
    tree["accuracy"] = {"tolerance": 0.01, "modes": 4, "strips_per_half_width": 4.0}
    result = solved(tree)
    found, estimate = said(result), result.estimate
    assert estimate is not None
    assert found["met"]
    of_itself = estimate["transmission_error_peak_to_peak"]
    assert found["peak_to_peak_of_itself"] == of_itself > found["tolerance"]
    part = np.ptp(result.transmission_error_um) / result.transmission_error_um.max()
    assert accuracy_lines(found)[-1] == (
        f"peak to peak {percent(of_itself)} of itself is {percent(of_itself * part)} of the "
        "largest transmission error, to which the tolerance refers"
    )


def test_peak_to_peak_within_the_tolerance_needs_no_words(met: fl.Result) -> None:
    found = said(met)
    assert found["peak_to_peak_of_itself"] < found["tolerance"]
    assert not any("of itself" in line for line in accuracy_lines(found))


def test_lines_of_a_miss_name_source_and_reason(tight: fl.Result) -> None:
    found = said(tight)
    first, values, tightened, *missed = accuracy_lines(found)
    assert first.startswith(f"{percent(TIGHT)}: not met, transmission error mean ")
    assert values.startswith(f"flank_element_mm {found['knobs']['flank_element_mm']['value']:g} (")
    assert " (modes 0." in values
    assert tightened.startswith("refined: flank_element_mm ")
    assert missed
    for line, one in zip(missed, found["missed"], strict=True):
        assert line.startswith(f"exceeded: {one['quantity'].replace('_', ' ')} ")
        assert line.endswith("mostly from positions: positions.count is set")


def test_steps_are_printed_as_short_as_they_are(tight: fl.Result) -> None:
    """Regression: strips were printed as 56.0 and 80.0."""
    found = said(tight)
    found["tightened"] = {"strips_per_half_width": [56.0, 80.0], "modes": [None, 7]}
    line = next(line for line in accuracy_lines(found) if line.startswith("refined"))
    assert line == "refined: strips_per_half_width 56 -> 80, modes default -> 7"


def test_run_plan_and_check_show_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "pair.toml"
    path.write_text(SCENE.replace("estimate = false\n", ""), encoding="utf-8")
    assert main(["run", str(path)]) == 0
    assert "tolerance           10 %: met" in capsys.readouterr().out
    assert main(["plan", str(path)]) == 0
    assert "accuracy.tolerance = 0.1 begins with modes = 4, " in capsys.readouterr().out
    assert main(["check", str(path)]) == 0
    assert "initial discretization for a tolerance of 0.1" in capsys.readouterr().out


def test_a_plan_is_that_of_the_first_run() -> None:
    scene = fl.Scene.from_dict(small(tolerance=0.1))
    plan = fl.plan(scene)
    assert plan.picked is not None
    result = fl.solve(scene, plan=plan)
    assert isinstance(result, fl.Result)
    assert plan.picked["keys"]["accuracy"]["modes"] == said(result)["knobs"]["modes"]["value"]
    assert plan.predicted["counters"]["fe_factorisations"] == result.cost["fe_factorisations"]


def test_progress_of_two_runs_grows_to_its_end() -> None:
    told: list[tuple[int, int]] = []
    scene = fl.Scene.from_dict(small(tolerance=TIGHT))
    fl.solve(scene, progress=lambda stage, done, total: told.append((done, total)))
    done = [one for one, _ in told]
    assert done == sorted(done)
    assert told[-1][0] == told[-1][1]
    assert len({total for _, total in told}) == 1
