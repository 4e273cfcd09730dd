"""The table of effects: its rows, the keys that switch them, and its completeness."""

import tomllib
from copy import deepcopy
from dataclasses import astuple, fields
from typing import Any

import pytest

from flankload.errors import SceneError
from flankload.scene import Scene
from flankload.scene.effects import EFFECTS, Effect, Effects, effects_of, excluded_by, switches_of
from flankload.scene.effects.keys import EffectsAsked
from tests.support.gear_scenes import SCENE, changed
from tests.support.paths import DOCS, SCENES

PAGE = DOCS / "guide" / "effects.md"
ROWS = {effect.name: effect for effect in EFFECTS}

#: Keys of [effects] that are no effect themselves.
NO_EFFECTS = {"choose", "beyond_limits"}


#: How the page calls the entries of Work.
WORK = (
    "{} factorisation",
    "{} load case",
    "{} load per mode",
    "{} tangential load per mode",
    "{} coast reading per mode",
    "{} solution per place",
    "{} column per pair",
    "{} contact problem per state",
)
SIZES = {
    "compliance": "other compliance",
    "gaps": "other gaps",
    "places": "other places of contact",
    "levers": "other levers or influence coefficients",
    "spacing": "spacing of the nodes",
    "cells": "influence coefficients, in proportion to the cells",
    "nothing": "changes no state",
}


def effects_table() -> list[str]:
    """Lines of the table in docs/guide/effects.md, from the rows."""
    lines = ["| effect | keys | adds | size from |", "|---|---|---|---|"]
    for effect in EFFECTS:
        keys = ", ".join(f"`{key}`" for key in effect.keys)
        numbers = zip(WORK, astuple(effect.work), strict=True)
        adds = ", ".join(text.format(f"{number:+g}") for text, number in numbers if number)
        lines.append(f"| {effect.title} | {keys} | {adds or '–'} | {SIZES[effect.size_by]} |")
    return lines


def test_the_page_of_effects_has_the_table() -> None:
    """If this fails, insert the output of python -m tests.unit.scene.test_effects."""
    page = PAGE.read_text(encoding="utf-8").splitlines()
    first = page.index("| effect | keys | adds | size from |")
    assert page[first : first + len(EFFECTS) + 2] == effects_table()
    assert not page[first + len(EFFECTS) + 2].startswith("|")


def test_each_row_is_a_field() -> None:
    assert [field.name for field in fields(Effects)] == list(ROWS)


def test_each_key_is_in_the_table() -> None:
    known = {key for effect in EFFECTS for key in effect.keys}
    asked = {f"effects.{key}" for key in set(EffectsAsked.__struct_fields__) - NO_EFFECTS}
    assert asked <= known


def test_excluded_effects_are_in_the_table_both_ways() -> None:
    for effect in EFFECTS:
        for other in effect.refused_with:
            assert other in excluded_by(effect)
            assert effect.name in excluded_by(ROWS[other])


def scene_of(effect: Effect, *, on: bool, **keys: Any) -> Scene:
    """A scene that may have an effect, with it or without it."""
    wanted = dict(effect.on if on else effect.off)
    if effect.only_for:
        name = {"stage": "planetary_stage"}.get(effect.only_for, effect.only_for)
        tree = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
        if effect.only_for != "stage":
            tree.setdefault("load", {})["slack_tension_N"] = 10.0
    else:
        tree = deepcopy(SCENE)
    named = {key: value for key, value in {**wanted, **keys}.items() if value is not None}
    tree["effects"] = {**tree.get("effects", {}), **named}
    return Scene.from_dict(tree, file="a.toml")


@pytest.mark.parametrize("name", [name for name, effect in ROWS.items() if effect.on])
def test_keys_of_a_record_switch_its_effect(name: str) -> None:
    effect = ROWS[name]
    assert effect.switch(scene_of(effect, on=True)).on
    assert not effect.switch(scene_of(effect, on=False)).on


@pytest.mark.parametrize(
    ("name", "other"), [(name, other) for name in ROWS for other in ROWS[name].refused_with]
)
def test_excluded_effect_is_refused_in_the_words_of_its_record(name: str, other: str) -> None:
    effect = ROWS[name]
    more = {key: value for key, value in ROWS[other].on.items() if value is not None}
    with pytest.raises(SceneError) as caught:
        scene_of(effect, on=True, **more)
    assert caught.value.key == f"effects.{effect.key}"
    assert caught.value.expected == effect.refused_with[other]


def test_effects_are_the_switches() -> None:
    scene = Scene.from_dict(SCENE)
    effects = effects_of(scene)
    for name, switch in switches_of(scene).items():
        assert getattr(effects, name) is switch.on


@pytest.mark.parametrize(
    ("changes", "effect", "on", "because", "named"),
    [
        ({}, "elastic_body_1", True, "body_1.rigid absent", False),
        ({"body_2__rigid": True}, "elastic_body_2", False, "body_2.rigid = true", True),
        ({"load__torque_Nm": 0}, "elastic_body_1", False, "load.torque_Nm = 0", True),
        ({}, "tooth_coupling", True, "effects.tooth_coupling absent", False),
        ({}, "friction", False, "effects.friction_coefficient absent", False),
        (
            {"effects__friction_coefficient": 0.1},
            "friction",
            True,
            "effects.friction_coefficient = 0.1",
            True,
        ),
        (
            {"effects__friction_coefficient": 0},
            "power_loss",
            False,
            "effects.friction_coefficient = 0",
            True,
        ),
        (
            {"effects__friction_coefficient": [[-4, 0.1], [4, 0.06]]},
            "friction",
            True,
            "effects.friction_coefficient = [2 entries]",
            True,
        ),
        ({"effects__root_stress": True}, "root_stress", True, "effects.root_stress = true", True),
        (
            {"effects__root_stress": True, "load__torque_Nm": 0},
            "root_stress",
            False,
            "load.torque_Nm = 0",
            True,
        ),
        (
            {"body_2__tip_radius_mm": 0.3},
            "flank_modifications",
            True,
            "body_2.tip_radius_mm = 0.3",
            True,
        ),
        (
            {"body_1__pitch_errors_um": [0] * 15 + [3]},
            "pitch_errors",
            True,
            "body_1.pitch_errors_um",
            True,
        ),
        (
            {"load__torque_Nm": [5, 10]},
            "several_torques",
            True,
            "load.torque_Nm = [2 entries]",
            True,
        ),
        ({}, "several_torques", False, "load.torque_Nm = 302", True),
    ],
)
def test_switch_names_its_key(
    changes: dict[str, Any], effect: str, on: bool, because: str, named: bool
) -> None:
    switch = switches_of(Scene.from_dict(changed(**changes)))[effect]
    assert (switch.on, switch.because, switch.named) == (on, because, named)


if __name__ == "__main__":
    print("\n".join(effects_table()))
