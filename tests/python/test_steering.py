"""A named tolerance: knobs that are picked, checked, tightened once, and what is said of them."""

import itertools
import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_cli import SCENE
from tolerances import ROUND_OFF

import flankload as fl
from flankload.assembly import build_bodies
from flankload.cli import main
from flankload.resolution import elements_for_modes
from flankload.result.accuracy_lines import accuracy_lines, percent
from flankload.result.notes import FEWER_DO
from flankload.setting import Setting
from flankload.steering import first_pick, first_scene, pick
from flankload.steering.bought import bought
from flankload.steering.knobs import ANYWHERE, MOST_MODES, knobs_of
from flankload.steering.laws import (
    BOUND,
    LAWS,
    LEAST_TOGETHER,
    MOST_TOGETHER,
    Law,
    as_told,
    together,
)
from flankload.steering.making import is_worth
from flankload.steering.pick import PARTS, STRIPS, cheapest, finest_part
from flankload.steering.told import told_by_source

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenes"
#: Seconds of a setting may be beaten by this part: two orders of the same sums.
SECONDS = 1e-12


def small(**accuracy: Any) -> dict[str, Any]:
    """A gear on a rigid wheel, six positions."""
    tree = tomllib.loads(SCENE)
    tree["body_2"]["rigid"] = True
    tree["positions"]["count"] = 6
    tree["accuracy"] = accuracy
    return tree


def solved(tree: dict[str, Any]) -> fl.Result:
    result = fl.solve(fl.Scene.from_dict(tree))
    assert isinstance(result, fl.Result)
    return result


def said(result: fl.Result) -> dict[str, Any]:
    assert result.accuracy is not None
    return dict(result.accuracy)


@pytest.fixture
def hopeful(monkeypatch: pytest.MonkeyPatch) -> None:
    """A law that takes errors for a third of what they are: its first setting is too coarse."""
    monkeypatch.setitem(LAWS, "gears", third_of(LAWS["gears"]))


def third_of(law: Law) -> Law:
    names = ("elements", "modes", "strips")
    less = {name: {q: e / 3.0 for q, e in getattr(law, name).items()} for name in names}
    return replace(law, **less)


@pytest.fixture(scope="module")
def tight() -> fl.Result:
    """A tolerance that the first setting misses."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(LAWS, "gears", third_of(LAWS["gears"]))
        return solved(small(tolerance=0.004))


def written_out(tree: dict[str, Any], found: dict[str, Any]) -> dict[str, Any]:
    """The scene with the knobs that were bought, and no tolerance."""
    tables = {name: {**tree.get(name, {}), **keys} for name, keys in found["keys"].items()}
    tables["accuracy"].pop("tolerance")
    return {**tree, **tables}


def assert_same(one: fl.Result, two: fl.Result) -> None:
    for name in ("position_rad", "rotation_rad", "site_force_N", "peak_pressure_MPa"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert one.estimate == two.estimate


# --- without the key ------------------------------------------------------------------------------
def test_without_the_key_nothing_is_steered() -> None:
    scene = fl.Scene.from_dict(small(modes=4, estimate=False))
    assert not scene.steers
    assert first_scene(scene) is scene
    result = fl.solve(scene)
    assert isinstance(result, fl.Result)
    assert result.accuracy is None
    assert "accuracy" not in json.loads(result.to_json())
    assert "steering" not in result.cost["stages"]


# --- what is run ----------------------------------------------------------------------------------
def test_result_is_that_of_the_knobs_written_out() -> None:
    tree = small(tolerance=0.1)
    result = solved(tree)
    assert said(result)["tightened"] == {}
    assert_same(result, solved(written_out(tree, said(result))))


def test_tightened_result_is_that_of_the_knobs_written_out(tight: fl.Result) -> None:
    found = said(tight)
    assert found["tightened"]
    assert_same(tight, solved(written_out(small(tolerance=0.004), found)))


def test_tightening_helps(tight: fl.Result) -> None:
    found = said(tight)
    worst = "transmission_error"
    assert found["errors_before"][worst] > found["tolerance"] >= found["errors"][worst]


def test_what_is_said_is_what_the_estimate_tells(tight: fl.Result) -> None:
    found, estimate = said(tight), tight.estimate
    assert estimate is not None
    curve = tight.transmission_error_um
    part = np.ptp(curve) / np.abs(curve).max()
    for quantity in BOUND:
        scale = part if quantity.endswith("peak_to_peak") else 1.0
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


def test_elements_are_kept_where_strips_are_tightened(monkeypatch: pytest.MonkeyPatch) -> None:
    """A law that takes strips for harmless begins with too few of them."""
    harmless = replace(LAWS["gears"], strips=dict.fromkeys(BOUND, 0.0))
    monkeypatch.setitem(LAWS, "gears", harmless)
    monkeypatch.setattr(pick, "STRIPS", np.array([3.0, *STRIPS]))
    result = solved(small(tolerance=0.005, flank_element_mm=0.5, modes=7))
    assert list(said(result)["tightened"]) == ["strips_per_half_width"]
    assert "fe_factorisations" not in result.cost["stages"]["first run"]["counters"]
    assert result.cost["fe_factorisations"] == 1


def test_named_knobs_stay_and_are_blamed() -> None:
    result = solved(small(tolerance=1e-4, flank_element_mm=2.0, modes=4, strips_per_half_width=6.0))
    found = said(result)
    assert found["keys"] == {}
    assert found["tightened"] == {}
    assert not found["met"]
    reasons = {one["source"]: one["why"] for one in found["missed"]}
    assert reasons["modes"] == "accuracy.modes is named"
    assert found["knobs"]["positions"]["left_as_it_is"] == "positions.count is named"
    assert [row["value"] for row in found["knobs"].values()] == [2.0, 4, 6.0, 6]


def test_positions_follow_the_tolerance_where_none_are_named() -> None:
    tree = small(tolerance=0.1, flank_element_mm=2.0)
    del tree["positions"]
    result = solved(tree)
    assert said(result)["keys"]["positions"]["adaptive"] is True
    assert result.estimate is not None
    assert "positions" in result.estimate["by_source"]
    assert_same(result, solved(written_out(tree, said(result))))


def test_several_torques_share_their_knobs() -> None:
    tree = small(tolerance=0.1, flank_element_mm=2.0)
    tree["load"]["torque_Nm"] = [0.0, 30.0, 300.0]
    results = fl.solve(fl.Scene.from_dict(tree))
    assert isinstance(results, tuple)
    assert len({json.dumps(said(result)) for result in results}) == 1
    errors = [result.estimate["load_share"] for result in results if result.estimate is not None]
    assert said(results[0])["errors"]["load_share"] == max(errors)


# --- what cannot be checked, or steered -----------------------------------------------------------
def test_without_estimate_knobs_are_picked_and_not_checked() -> None:
    found = said(solved(small(tolerance=0.01, estimate=False)))
    assert found["met"] is None
    assert found["unchecked"] == "knobs as predicted, not checked (accuracy.estimate = false)"
    assert found["keys"]["accuracy"]["modes"] >= 3


def test_without_torque_nothing_is_approximated() -> None:
    tree = small(tolerance=0.01, flank_element_mm=2.0)
    tree["load"]["torque_Nm"] = 0.0
    assert said(solved(tree))["unchecked"] == "without torque nothing is approximated"


def test_chain_has_no_knobs() -> None:
    tree = tomllib.loads((EXAMPLES / "chain.toml").read_text(encoding="utf-8"))
    plain = solved(tree)
    result = solved({**tree, "accuracy": {"tolerance": 0.01}})
    assert set(said(result)["knobs"]) == {"positions"}
    assert said(result)["keys"] == {}
    np.testing.assert_array_equal(result.rotation_rad, plain.rotation_rad)


def belt(**accuracy: Any) -> dict[str, Any]:
    tree = tomllib.loads((EXAMPLES / "belt.toml").read_text(encoding="utf-8"))
    return {**tree, "accuracy": accuracy}


def test_elements_of_a_belt_follow_the_tolerance() -> None:
    found = said(solved(belt(tolerance=0.1)))
    assert set(found["knobs"]) == {"flank_element_mm", "positions"}
    assert found["knobs"]["positions"]["left_as_it_is"].startswith("a belt has as many even ones")
    assert set(found["keys"]) == {"accuracy"}


def test_elements_of_belt_and_pulley_are_one_source() -> None:
    tree = tomllib.loads((EXAMPLES / "belt_plastic_pulley.toml").read_text(encoding="utf-8"))
    result = solved({**tree, "accuracy": {"flank_element_mm": 0.8}})
    by_source = told_by_source([result])
    assert result.estimate is not None
    assert by_source is not None
    assert set(by_source) == {"elements"}
    for quantity in ("transmission_error", "load_share"):
        assert by_source["elements"][quantity] == pytest.approx(
            result.estimate[quantity], rel=ROUND_OFF, abs=0.0
        )


def test_a_belt_gets_no_shorter_elements_than_it_needs() -> None:
    """At the default length its estimate tells less than 1.2 %."""
    tree = belt(tolerance=0.012)
    found, length = said(solved(tree)), knobs_of(fl.Scene.from_dict(tree)).element_mm
    assert length is not None
    assert found["met"]
    assert found["knobs"]["flank_element_mm"]["value"] > 0.5 * length


def reasons(tree: dict[str, Any], steps: list[tuple[float, float]], tolerance: float) -> list[str]:
    """Why a run is told to miss its tolerance: parts of the default length, errors foreseen."""
    scene = fl.Scene.from_dict({**tree, "accuracy": {"tolerance": tolerance}})
    knobs, first = knobs_of(scene), first_pick(scene)
    picks = [
        replace(first, part=part, errors=dict.fromkeys(BOUND, foreseen)) for part, foreseen in steps
    ]
    error = {"transmission_error": 10 * tolerance}
    found = bought(scene, knobs, picks, [solved(small())], [error], {"elements": error})
    return [one["why"] for one in found["missed"]]


def test_a_miss_says_what_ends_it() -> None:
    """What stopped before the end of its ladder was said to be more than could be foreseen."""
    end, unlikely = "the finest step of its ladder", "no step of its ladder is likely to bring"
    tree = small(tolerance=1e-4)
    assert reasons(tree, [(0.125, 1e-3)], 1e-4)[0].startswith(end)
    assert reasons(tree, [(0.25, 1e-3)], 1e-4)[0].startswith(unlikely)
    assert reasons(tree, [(1.0, 0.0), (0.25, 1e-3)], 1e-4)[0].startswith(unlikely)
    assert reasons(tree, [(1.0, 0.0), (0.25, 0.0)], 1e-4)[0].startswith("more than could be")


def test_a_belt_says_why_finer_elements_help_little() -> None:
    """Its corners are no corners of pairs, and no tip radius cures them."""
    (why,) = reasons(belt(), [(0.125, 1e-3)], 1e-4)
    assert why.startswith("the finest step of its ladder; beside the corners of teeth and lands")
    assert "tip_radius_mm" not in why


@pytest.mark.parametrize(
    ("keys", "knob", "why"),
    [
        ({"effects": {"contact": "lumped"}}, "strips_per_half_width", "lumped contact lays no"),
        ({"effects": {"near_field": "nodes"}}, "modes", "effects.near_field = 'nodes' goes by"),
        ({"positions": {"adaptive": True}}, "positions", "positions.adaptive is named"),
    ],
)
def test_knobs_that_stay_say_why(keys: dict[str, Any], knob: str, why: str) -> None:
    scene = fl.Scene.from_dict({**small(tolerance=0.01), **keys})
    assert knobs_of(scene).closed[knob].startswith(why)


# --- laws and the choice --------------------------------------------------------------------------
@pytest.mark.parametrize("kind", LAWS)
@pytest.mark.parametrize("tolerance", [0.05, 0.01, 0.001])
def test_no_other_step_is_cheaper(kind: str, tolerance: float) -> None:
    """Against a plain search through all steps."""
    scene = fl.Scene.from_dict(small(tolerance=tolerance))
    knobs = replace(knobs_of(scene), kind=kind, states=32)
    law = LAWS[kind]
    best = cheapest(law, knobs, tolerance, positions=Setting(), states=32.0)
    for part, modes, strips in itertools.product(PARTS, range(3, MOST_MODES + 1), STRIPS):
        if part < finest_part(tolerance) or not knobs.bears(part, modes):
            continue
        one = tuple(np.array(value, dtype=float) for value in (part, modes, strips))
        worst = max(float(law.errors(quantity, *one)) for quantity in BOUND)
        seconds = float(law.elements_seconds(*one[:2]) + law.states_seconds(one[2], 32.0))
        if max(best.errors.values()) <= tolerance:
            assert worst > tolerance or seconds >= best.seconds * (1.0 - SECONDS)
        else:
            assert worst > tolerance


@pytest.mark.parametrize("name", ["external_gear", "internal_gear", "spline"])
@pytest.mark.parametrize("tolerance", [0.05, 0.01, 0.001])
def test_elements_bear_the_modes_that_are_picked(name: str, tolerance: float) -> None:
    """On the bodies as they are meshed, which the pick does not look at."""
    tree = tomllib.loads((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8"))
    tree["accuracy"] = {"tolerance": tolerance}
    scene = first_scene(fl.Scene.from_dict(tree))
    assert scene.accuracy.modes is not None
    pair = build_bodies(scene)
    for body in (pair.body_1, pair.body_2):
        assert body.mesh is not None
        wanted = elements_for_modes(scene.accuracy.modes)
        assert scene.accuracy.modes <= ANYWHERE or wanted <= FEWER_DO * body.mesh.flank_elements


def test_a_second_run_must_meet_something_or_come_much_nearer() -> None:
    first = first_pick(fl.Scene.from_dict(small(tolerance=0.01)))
    found = {"peak_pressure": 0.1, "load_share": 0.02}

    def worth(peak: float, share: float) -> bool:
        foreseen = {**first.errors, "peak_pressure": peak, "load_share": share}
        return is_worth(replace(first, errors=foreseen), found, found, 0.01)

    assert worth(0.1, 0.009)
    assert worth(0.06, 0.013)
    assert not worth(0.06, 0.019)
    assert not worth(0.09, 0.013)


def test_a_law_as_told_tells_what_was_told() -> None:
    rng = np.random.default_rng(5)
    told = {
        source: {quantity: float(rng.uniform(1e-4, 1e-2)) for quantity in BOUND}
        for source in ("elements", "strips", "positions")
    }
    of_all = {
        quantity: float(rng.uniform(0.9, 1.1))
        * sum(row[quantity] ** 2 for row in told.values()) ** 0.5
        for quantity in BOUND
    }
    ratio = together(told, of_all)
    law = as_told(LAWS["gears"], told, ratio, part=0.7, modes=6, strips=14.0)
    knobs = (np.array(0.7), np.array(6.0), np.array(14.0))
    for quantity in BOUND:
        sources = law.sources(quantity, *knobs)
        for source, name in (("elements", "elements"), ("strips", "strips"), ("rest", "positions")):
            assert float(sources[source]) == pytest.approx(
                told[name][quantity], rel=ROUND_OFF, abs=0.0
            )
    # the root of the squares of what the law says of each, modes included
    for quantity in BOUND:
        squares = sum(float(error) ** 2 for error in law.sources(quantity, *knobs).values())
        assert float(law.errors(quantity, *knobs)) == pytest.approx(
            ratio[quantity] * squares**0.5, rel=ROUND_OFF, abs=0.0
        )


def test_sources_that_cancel_are_told_together_within_bounds() -> None:
    told = {source: dict.fromkeys(BOUND, 3e-3) for source in ("elements", "modes")}
    alone = 2.0**0.5 * 3e-3
    name = BOUND[0]
    assert together(told, {name: alone})[name] == pytest.approx(1.0, rel=ROUND_OFF, abs=0.0)
    assert together(told, {name: 1e-6})[name] == LEAST_TOGETHER
    assert together(told, {name: 1.0})[name] == MOST_TOGETHER
    assert together({}, {name: 0.0})[name] == 1.0


def test_nothing_of_a_belt_is_put_down_to_modes() -> None:
    scene = fl.Scene.from_dict(belt(tolerance=0.005))
    pick = first_pick(scene)
    assert not any(pick.sources["modes"].values())
    assert pick.as_dict()["dominant_source"] == "elements"


def test_a_smaller_tolerance_never_buys_less() -> None:
    picks = [
        first_pick(fl.Scene.from_dict(small(tolerance=tolerance)))
        for tolerance in (0.1, 0.03, 0.01, 0.005, 0.004, 0.003, 0.002, 0.001, 0.0003)
    ]
    seconds = [pick.seconds for pick in picks]
    assert seconds == sorted(seconds)
    assert seconds[-1] > seconds[0]


# --- how it is told -------------------------------------------------------------------------------
def test_peak_to_peak_is_told_as_part_of_what() -> None:
    """A tolerance was met at 0.15 % below an estimate of 5 % of a small peak to peak."""
    tree = tomllib.loads((EXAMPLES / "cam.toml").read_text(encoding="utf-8"))
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
        "largest transmission error, which is what counts"
    )


def test_peak_to_peak_within_the_tolerance_needs_no_words() -> None:
    found = said(solved(small(tolerance=0.1)))
    assert found["peak_to_peak_of_itself"] < found["tolerance"]
    assert not any("of itself" in line for line in accuracy_lines(found))


def test_lines_of_a_miss_name_source_and_reason(tight: fl.Result) -> None:
    found = said(tight)
    first, knobs, tightened, of_itself, *missed = accuracy_lines(found)
    assert of_itself.startswith("peak to peak ")
    assert first.startswith("0.4 %: not met, transmission error mean ")
    assert knobs.startswith(f"flank_element_mm {found['knobs']['flank_element_mm']['value']:g} (")
    assert " (modes 0." in knobs
    assert tightened.startswith("tightened once: flank_element_mm ")
    assert missed
    for line, one in zip(missed, found["missed"], strict=True):
        assert line.startswith(f"missed: {one['quantity'].replace('_', ' ')} ")
        assert line.endswith("most of it from positions: positions.count is named")


def test_a_miss_names_all_sources_that_exceed_the_tolerance(tight: fl.Result) -> None:
    """Not the largest one alone: where it shrinks the tolerance is missed all the same."""
    scene = fl.Scene.from_dict(small(tolerance=0.01))
    first = first_pick(scene)
    by_source = {
        source: {"peak_pressure": error}
        for source, error in (("strips", 0.03), ("modes", 0.02), ("elements", 0.005))
    }
    found = bought(scene, knobs_of(scene), [first], [tight], [{"peak_pressure": 0.04}], by_source)
    (one,) = found["missed"]
    assert (one["source"], one["beside"]) == ("strips", ["modes"])
    assert accuracy_lines(found)[-1].startswith(
        "missed: peak pressure 4 %, most of it from strips (modes alone exceeds the tolerance, "
        "too): "
    )


def test_steps_are_printed_as_short_as_they_are(tight: fl.Result) -> None:
    """Strips went from 56.0 to 80.0."""
    found = said(tight)
    found["tightened"] = {"strips_per_half_width": [56.0, 80.0], "modes": [None, 7]}
    line = next(line for line in accuracy_lines(found) if line.startswith("tightened"))
    assert line == "tightened once: strips_per_half_width 56 -> 80, modes default -> 7"


def test_run_plan_and_check_show_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "pair.toml"
    path.write_text(SCENE.replace("estimate = false\n", ""), encoding="utf-8")
    assert main(["run", str(path)]) == 0
    assert "tolerance           10 %: met" in capsys.readouterr().out
    assert main(["plan", str(path)]) == 0
    assert "accuracy.tolerance = 0.1 begins with modes = " in capsys.readouterr().out
    assert main(["check", str(path)]) == 0
    assert "knobs that a tolerance of 0.1 begins with" in capsys.readouterr().out


def test_a_plan_is_that_of_the_first_run() -> None:
    scene = fl.Scene.from_dict(small(tolerance=0.1))
    plan = fl.plan(scene)
    assert plan.picked is not None
    result = fl.solve(scene, plan=plan)
    assert isinstance(result, fl.Result)
    assert plan.picked["keys"] == said(result)["keys"]
    assert plan.predicted["counters"]["fe_factorisations"] == result.cost["fe_factorisations"]


@pytest.mark.usefixtures("hopeful")
def test_progress_of_two_runs_grows_to_its_end() -> None:
    told: list[tuple[int, int]] = []
    scene = fl.Scene.from_dict(small(tolerance=0.008))
    fl.solve(scene, progress=lambda stage, done, total: told.append((done, total)))
    done = [one for one, _ in told]
    assert done == sorted(done)
    assert told[-1][0] == told[-1][1]
    assert len({total for _, total in told}) == 1
