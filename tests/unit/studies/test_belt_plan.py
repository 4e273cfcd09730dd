"""The plan of a timing belt, compared with runs: effect of lands, work of a run."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from msgspec import structs

import flankload as fl
from flankload.mechanisms.toggles import toggled
from tests.support.belt_scenes import POSITIONS, SMALL, tables

#: Of sizes of effects from large elements and few positions, beside those of runs.
SIZE = 0.1
#: The same of lands that lift: where a tooth has just come, a land is held by one element, which is
#: longer in a plan.
SIZE_OF_LIFT = 0.5
#: Of bytes that are not counted one by one.
MEMORY = 0.5


def scene_of(**changes: dict[str, Any]) -> fl.Scene:
    merged = {
        table: {**SMALL.get(table, {}), **changes.get(table, {})} for table in {**SMALL, **changes}
    }
    return fl.Scene.from_dict(tables(**merged))


@cache
def plain_plan() -> fl.Plan:
    return fl.plan(scene_of())


def first_of(scene: fl.Scene, plan: fl.Plan | None = None) -> fl.Result:
    return fl.solve(scene, plan=plan).by_torque[0]


def test_rows_are_those_that_a_belt_knows() -> None:
    plan = plain_plan()
    names = [effect.name for effect in plan.effects]
    assert names == ["several_torques", "land_friction", "land_lift"]
    assert plan.effect("land_friction").assumed == "effects.land_friction = 0.1"
    assert plan.effect("land_friction").because == "effects.land_friction absent"
    assert "friction on the lands of a belt is off" in plan.remarks[0]


@pytest.mark.parametrize(
    ("effect", "on", "near"),
    [
        ("land_friction", False, SIZE),
        ("land_friction", True, SIZE),
        ("land_lift", False, SIZE_OF_LIFT),
    ],
)
def test_sizes_are_those_of_two_runs(effect: str, near: float, *, on: bool) -> None:
    """The runs have finer elements than the plan."""
    effects = {"effects": {effect: 0.1}} if on else {}
    scene = scene_of(
        positions={"angles_deg": [0, 6, 8]},
        accuracy={"flank_element_mm": 0.625, "estimate": False},
        **effects,
    )
    size = fl.plan(scene).effect(effect).size
    toggle = toggled(scene, effect, on=on)
    assert toggle is not None
    assert toggle.scene is not None
    assert size is not None
    one, other = first_of(scene), first_of(toggle.scene)
    share = np.abs(one.load_share - other.load_share).max()
    turn = np.abs(one.rotation_rad - other.rotation_rad).max() * one.reference_radius_mm
    np.testing.assert_allclose(size.load_share, share, rtol=near, atol=0.0)
    np.testing.assert_allclose(size.rotation_um, 1000.0 * turn, rtol=near, atol=0.0)


@pytest.mark.parametrize(
    "changes",
    [
        {**POSITIONS, "accuracy": {"flank_element_mm": 1.25, "estimate": True}},
        {**POSITIONS, "effects": {"land_friction": 0.1}},
        {"effects": {"land_lift": True}, "load": {"torque_Nm": [5, 10]}},
        {"body_2": {"wrapped_teeth": 1}},
    ],
)
def test_predicted_counters_are_those_of_the_run(changes: dict[str, Any]) -> None:
    scene = scene_of(**changes)
    plan = fl.plan(scene)
    cost = first_of(scene, plan).cost
    stages = {name: stage for name, stage in cost["stages"].items() if name != "result"}
    assert plan.predicted["stages"].keys() == stages.keys()
    for name, stage in stages.items():
        predicted = plan.predicted["stages"][name]
        assert stage["predicted"] == predicted
        spent = {key: n for key, n in stage["counters"].items() if key != "pivots"}
        exact = {key: n for key, n in predicted["counters"].items() if n and key != "pivots"}
        assert spent == exact
        np.testing.assert_allclose(
            predicted["workspace_bytes"], stage["workspace_bytes"], rtol=MEMORY, atol=0.0
        )
        if name.startswith(("bodies", "compliance")):
            assert predicted["bytes"] == stage["bytes"]
        np.testing.assert_allclose(predicted["bytes"], stage["bytes"], rtol=MEMORY, atol=0.0)
    assert plan.seconds > 0.0


def test_an_elastic_pulley_has_its_size_and_its_cost() -> None:
    few = {"positions": {"angles_deg": [0, 6, 8]}}
    scene = scene_of(
        body_1={"rigid": False, "bore_diameter_mm": 20, "young_modulus_MPa": 1000}, **few
    )
    plan = fl.plan(scene)
    result = first_of(scene, plan)
    rigid = first_of(scene_of(**few))
    size = plan.effect("elastic_body_1").size
    assert size is not None
    share = np.abs(result.load_share - rigid.load_share).max()
    turn = np.abs(result.rotation_rad - rigid.rotation_rad).max() * rigid.reference_radius_mm
    np.testing.assert_allclose(size.load_share, share, rtol=SIZE_OF_LIFT, atol=0.0)
    np.testing.assert_allclose(size.rotation_um, 1000.0 * turn, rtol=SIZE, atol=0.0)
    spent = result.cost["stages"]
    assert plan.predicted["stages"].keys() == spent.keys() - {"result"}
    for name in ("compliance body 1", "compliance body 2"):
        predicted = plan.predicted["stages"][name]
        assert predicted["counters"]["fe_solutions"] == spent[name]["counters"]["fe_solutions"]
        np.testing.assert_allclose(predicted["bytes"], spent[name]["bytes"], rtol=MEMORY, atol=0.0)


def test_more_work_is_a_higher_price() -> None:
    """The run with 42 elements on a flank takes 170 times as long as the one with 2.

    A cost proportional to the unknowns gave a factor of 30. Rates are measured: on a busy machine
    they scatter by a third.
    """
    few, many = (
        fl.plan(scene_of(accuracy={"flank_element_mm": size, "estimate": False}, **POSITIONS))
        for size in (1.25, 0.06)
    )
    assert many.seconds > 60 * few.seconds
    rubs = few.effect("land_friction")
    assert rubs.extra_bytes > 0
    # a difference of measured seconds: on a busy machine it may have either sign
    assert rubs.extra_s is not None


def test_an_effect_that_does_not_go_with_the_scene_says_so() -> None:
    plan = fl.plan(scene_of(body_2={"wrapped_teeth": 5, "prestress_N": 0}))
    assert not plan.effect("land_lift").possible
    unknown = plan.effect("land_lift").unknown
    assert unknown is not None
    assert "body_2.prestress_N: expected a number > 0" in unknown


def test_a_plan_of_another_belt_is_refused() -> None:
    scene, plan = scene_of(), plain_plan()
    longer = replace(scene, body_2=structs.replace(scene.body_2, wrapped_teeth=6))
    with pytest.raises(fl.errors.InputError, match="plan: expected a plan of this scene"):
        fl.solve(longer, plan=plan)
