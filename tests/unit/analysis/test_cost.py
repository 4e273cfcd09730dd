"""Cost of a run: every kind of work counted where it is done, in the stage that requires it."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.cli import main
from flankload.contact import sweep as sweep_room
from flankload.contact.pair_table import PackedPairs
from flankload.cost import COUNTERS, Account, held_bytes, totals
from flankload.elasticity.fronts import condensation
from flankload.elasticity.fronts.recovery import Recovery
from flankload.mechanisms import Parts
from flankload.mechanisms.flank_pair import prediction
from flankload.studies.prepared import solve_scene
from tests.support.gear_scenes import changed
from tests.support.paths import DOCS, SCENES

#: Every solution with a factor has a purpose.
SOLUTIONS = (
    "unit_loads_normal",
    "unit_loads_tangential",
    "fe_load_cases_growth",
    "corner_readings",
    "bore_reactions",
    "stress_recoveries",
)
#: Those with friction, whose loads along the flanks serve forces that turn, too.
RUBBED = set(SOLUTIONS) - {"corner_readings"}
FEW = {"positions__count": 4}
ALL = {"effects__friction_coefficient": 0.1, "effects__root_stress": True, **FEW}


PATHS = sorted(SCENES.glob("*.toml"))
#: Longer elements, fewer positions of examples that take seconds; regression tests solve the files.
SHORTER: dict[str, dict[str, Any]] = {
    "belt_plastic_pulley": {"accuracy.flank_element_mm": 0.8},
    "cam": {"positions.count": 12},
    "crowned_coupling": {"accuracy.flank_element_mm": 3.0},
    "helical_gear": {"accuracy.flank_element_mm": 3.0},
    "planetary_stage": {"positions.count": 4},
}


def fresh(**changes: Any) -> fl.Result:
    """Solve anew; of a list of torques the first one."""
    return fl.solve(fl.Scene.from_dict(changed(**changes))).by_torque[0]


KNOWN: dict[str, fl.Result] = {}


def solved(**changes: Any) -> fl.Result:
    """The result, solved once and then kept."""
    name = str(sorted(changes.items()))
    if name not in KNOWN:
        KNOWN[name] = fresh(**changes)
    return KNOWN[name]


# --- accounts -------------------------------------------------------------------------------------
def test_an_account_names_nothing_that_was_not_done() -> None:
    account = Account()
    account.count(pivots=3, states=0)
    account.count(pivots=2)
    assert account.counters == {"pivots": 5}
    assert totals({"a": account, "b": Account(counters={"pivots": 1})}) == {
        **dict.fromkeys(COUNTERS, 0),
        "pivots": 6,
    }


def test_work_without_a_name_is_not_counted() -> None:
    with pytest.raises(KeyError, match="pirouettes"):
        Account().count(pirouettes=1)


def test_an_account_runs_while_its_stage_does() -> None:
    account = Account()
    with account:
        sum(range(1000))
    once = account.wall_s
    with account:
        sum(range(1000))
    assert 0 < once < account.wall_s


def test_arrays_count_once_and_views_count_their_base() -> None:
    whole = np.zeros((10, 4))
    assert held_bytes(whole) == 320
    assert held_bytes({"a": [whole[:2], (whole, whole.T)]}, whole) == 320
    assert held_bytes(whole[:2], np.zeros(3)) == 344
    assert held_bytes(Account(), "text", 1, None) == 0


def test_packed_pairs_count_the_used_part_of_their_memory() -> None:
    pairs = PackedPairs(
        site=np.zeros(100, dtype=np.intc),
        table=np.zeros((100, 11)),
        first=np.array([0, 40]),
        count=np.array([7, 3]),
    )
    assert held_bytes([pairs]) == pairs.nbytes == 10 * (4 + 11 * 8)


# --- elements -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("changes", "kinds"),
    [
        (FEW, {"unit_loads_normal", "corner_readings"}),
        (
            {"body_1__bore": "torque", **ALL},
            set(SOLUTIONS) - {"fe_load_cases_growth", "corner_readings"},
        ),
        (
            {"body_1__rigid": True, "effects__speed_rpm": 100, **ALL},
            RUBBED - {"bore_reactions"},
        ),
        ({"load__torque_Nm": 0, **ALL}, set()),
    ],
    ids=["plain", "friction and stress", "rigid", "no torque"],
)
def test_factorisations_and_solutions_are_those_of_the_fronts(
    changes: dict[str, Any], kinds: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    done: Counter[str] = Counter()

    plain = condensation.condense_in_order

    def watched(*arguments: Any, **options: Any) -> Any:
        done["fe_factorisations"] += 1
        done["fe_solutions"] += arguments[2].shape[2]
        return plain(*arguments, **options)

    def read(self: Recovery, sector: Any, columns: np.ndarray, moved: np.ndarray) -> Any:
        done["fe_solutions"] += columns.shape[2]
        return reads(self, sector, columns, moved)

    reads = Recovery.read
    monkeypatch.setattr(condensation, "condense_in_order", watched)
    monkeypatch.setattr(Recovery, "read", read)
    cost = fresh(**changes).cost
    for name in ("fe_factorisations", "fe_solutions"):
        assert cost[name] == done[name]
    assert {name for name in SOLUTIONS if cost[name]} == kinds
    for stage in cost["stages"].values():
        counters = stage["counters"]
        assert sum(counters.get(name, 0) for name in SOLUTIONS) == counters.get("fe_solutions", 0)


# --- the sweep ------------------------------------------------------------------------------------
def test_counters_at_the_top_are_those_of_all_stages() -> None:
    cost = solved(**ALL).cost
    stages = cost["stages"].values()
    for name in COUNTERS:
        assert cost[name] == sum(stage["counters"].get(name, 0) for stage in stages)
    assert cost["bytes"] == sum(stage["bytes"] for stage in stages)


def test_the_estimate_has_an_account_of_its_own_and_the_sweep_counts_its_tangents() -> None:
    with_both = solved(**FEW).cost
    stages = with_both["stages"]
    assert [stages[name]["counters"]["states"] for name in ("sweep", "estimate")] == [4, 12]
    plain = solved(accuracy__tangents=False, **FEW).cost
    for name in ("influence_columns", "pivots", "contact_passes"):
        assert plain["of_this_torque"][name] == with_both["of_this_torque"][name]
        assert plain["stages"]["sweep"]["counters"][name] == plain["of_this_torque"][name]
        assert stages["sweep"]["counters"][name] > with_both["of_this_torque"][name]
        assert stages["estimate"]["counters"][name] > 0
    alone = solved(accuracy__estimate=False, **FEW).cost
    assert "estimate" not in alone["stages"]
    assert alone["pivots"] == with_both["pivots"] - stages["estimate"]["counters"]["pivots"]


def test_torques_of_a_list_share_the_run_and_have_their_own_part() -> None:
    scene = fl.Scene.from_dict(
        changed(load__torque_Nm=[0, 100, 302], accuracy__tangents=False, **FEW)
    )
    nothing, light, full = (result.cost for result in fl.solve(scene).by_torque)
    assert nothing["stages"] == light["stages"] == full["stages"]
    assert nothing["stages"]["sweep"]["counters"]["states"] == 12
    assert not any(nothing["of_this_torque"].values())
    for name, number in full["stages"]["sweep"]["counters"].items():
        if name != "states":
            assert number == light["of_this_torque"][name] + full["of_this_torque"][name]


def test_friction_makes_a_tangential_column_for_each_normal_one() -> None:
    rubbed, plain = solved(**ALL).cost, solved(**FEW).cost
    assert rubbed["influence_columns_tangential"] == rubbed["influence_columns"] > 0
    assert plain["influence_columns_tangential"] == 0


def test_rounds_of_adaptive_positions_are_counted_together() -> None:
    cost = solved(positions__adaptive=True, positions__count=8, accuracy__estimate=False).cost
    assert cost["position_rounds"] > 1
    assert cost["stages"]["sweep"]["counters"]["states"] == cost["positions"]


def test_states_that_found_no_room_are_counted_when_they_are_solved_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plain = solved(**FEW)
    monkeypatch.setattr(sweep_room, "INITIAL_PAIRS", 1)
    again = fresh(**FEW)
    assert again.cost["of_this_torque"] == plain.cost["of_this_torque"]
    once, twice = (result.cost["stages"]["sweep"]["counters"] for result in (plain, again))
    assert twice["states"] > once["states"]
    assert twice["influence_columns"] > once["influence_columns"]


# --- predicted ------------------------------------------------------------------------------------
def differences(cost: dict[str, Any]) -> dict[tuple[str, str], tuple[int, int]]:
    """Counters whose predictions differ from the run."""
    return {
        (stage, name): (predicted, spent)
        for stage, account in cost["stages"].items()
        for name, predicted in account["predicted"].get("counters", {}).items()
        if (spent := account["counters"].get(name, 0)) != predicted
    }


@pytest.mark.parametrize(
    "changes",
    [
        FEW,
        ALL,
        {"body_1__rigid": True, **ALL},
        {"body_2__rigid": True, **FEW},
        {"load__torque_Nm": 0, **ALL},
        {"load__torque_Nm": [0, 100, 302], **ALL},
        {"accuracy__modes": 3, "accuracy__estimate": False, **FEW},
        {"positions__adaptive": True, "positions__count": 8},
        {"effects__contact": "lumped", "effects__friction_coefficient": 0.1, **FEW},
        {"effects__body": "tooth", **ALL},
        {"effects__body": "segment", "effects__segment_teeth": 3, **ALL},
        {"effects__temperature_rise_K": -30, "effects__speed_rpm": 3000, **FEW},
        {
            "body_1__web_width_mm": 4,
            "body_1__rim_thickness_mm": 5,
            "accuracy__flank_element_mm": 3.0,
            **FEW,
        },
        {
            "body_1__web_width_mm": 4,
            "body_1__rim_thickness_mm": 5,
            "body_1__web_offset_mm": 2,
            "accuracy__flank_element_mm": 3.0,
            **FEW,
        },
        {
            "effects__temperature_rise_K": [0, -30],
            "effects__support_expansion_per_K": 0,
            "effects__speed_rpm": 3000,
            "effects__friction_coefficient": 0.1,
            "load__torque_Nm": 0,
            **FEW,
        },
    ],
    ids=lambda changes: ", ".join(f"{key}={value}" for key, value in changes.items()),
)
def test_counters_known_in_advance_are_those_of_the_run(changes: dict[str, Any]) -> None:
    cost = solved(**changes).cost
    assert differences(cost) == {}
    stages = cost["stages"]
    for name in SOLUTIONS:  # nothing is spent that was not predicted
        foreseen = sum(a["predicted"].get("counters", {}).get(name, 0) for a in stages.values())
        assert cost[name] == foreseen
    adaptive = changes.get("positions__adaptive", False)
    assert ("states" in stages["sweep"]["predicted"]["counters"]) is not adaptive


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.stem)
def test_each_example_is_solved_at_the_predicted_cost(path: Path) -> None:
    """The same holds without torque, with the elements of the first run."""
    scene, parts = fl.read_scene(path).replace(SHORTER.get(path.stem, {})), Parts()
    result = solve_scene(scene, None, parts)
    assert (result.status >= 0).all()
    assert np.isfinite(result.rotation_rad).all()
    assert result.estimate["transmission_error"] < 0.02
    assert result.outside_limits == ()
    assert differences(result.cost) == {}
    assert result.cost["stages"]["sweep"]["predicted"]["counters"]["states"] > 0
    if scene.stage is not None:
        return  # without load its planets are free to turn, which is refused
    unloaded = solve_scene(scene.replace({"load.torque_Nm": 0.0}), None, parts)
    assert np.isfinite(unloaded.rotation_rad).all()
    assert "transmission error" in unloaded.table()
    assert differences(unloaded.cost) == {}


def test_a_prediction_that_is_wrong_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(prediction, "modes_of", lambda *_: 4)
    differing = differences(fresh(**FEW).cost)
    assert differing["compliance body 1", "unit_loads_normal"] == (4, 5)


def test_a_plan_is_shown_beside_the_cost() -> None:
    scene = fl.Scene.from_dict(changed(**ALL))
    plain, planned = solved(**ALL), fl.solve(scene, plan=fl.plan(scene))
    assert isinstance(planned, fl.Result)
    assert np.array_equal(planned.rotation_rad, plain.rotation_rad)
    assert planned.cost["stages"]["sweep"]["predicted"]["counters"]["pivots"] > 0
    assert "pivots" not in plain.cost["stages"]["sweep"]["predicted"]["counters"]
    for name, stage in planned.cost["stages"].items():
        exact = plain.cost["stages"][name]["predicted"].get("counters", {})
        assert exact.items() <= stage["predicted"].get("counters", {}).items()
        assert stage["counters"] == plain.cost["stages"][name]["counters"]
        if name != "result":
            assert stage["predicted"]["cpu_s"] > 0
            assert "bytes" in stage["predicted"]


def test_a_plan_of_another_scene_is_refused() -> None:
    plan = fl.plan(fl.Scene.from_dict(changed(**FEW)))
    scene = fl.Scene.from_dict(changed(effects__friction_coefficient=0.1, **FEW))
    with pytest.raises(fl.errors.InputError, match="plan: expected a plan of this scene"):
        fl.solve(scene, plan=plan)


# --- as text and JSON -----------------------------------------------------------------------------
def test_table_of_costs_has_predicted_and_spent_side_by_side() -> None:
    result = solved(**FEW)
    head, *rows = result.cost_table().splitlines()
    assert head.split() == ["stage", "work", "predicted", "spent"]
    assert sum(not row.startswith(" ") for row in rows) == len(result.cost["stages"])
    table = dict(row.strip().rsplit(maxsplit=2)[::2] for row in rows)
    assert table["fe factorisations"] == "1"
    predicted = {tuple(row.strip().rsplit(maxsplit=2)[:2]) for row in rows if "CPU" not in row}
    assert {("states", "4"), ("states", "12"), ("unit loads normal", "5")} <= predicted
    assert ("pivots", "-") in predicted
    assert "unit loads tangential" not in table


def test_the_page_on_costs_names_all_counters_and_stages() -> None:
    page = (DOCS / "guide" / "cost.md").read_text(encoding="utf-8")
    names = {*COUNTERS, *solved(**ALL).cost["stages"]}
    assert {name for name in names if f"`{name}`" not in page} == set()


@pytest.mark.parametrize("kind", ["chain", "belt", "cam"])
def test_costs_of_other_kinds_are_printed_too(
    kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = next(path for path in PATHS if path.stem == kind)
    assert main(["run", str(path), "--cost", "--quiet"]) == 0
    assert capsys.readouterr().out.startswith("stage ")


def test_costs_are_plain_json() -> None:
    result = solved(**FEW)
    assert json.loads(result.to_json())["cost"] == result.cost
