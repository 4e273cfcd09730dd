"""Every key by itself: unknown, missing, of a wrong type or out of range, it gets one line."""

import datetime
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from flankload.scene.effects.keys import EffectsAsked
from flankload.scene.form import fields_of, required_of
from flankload.scene.gear import Gear, Ring
from flankload.scene.groups import GROUPS, group_of
from flankload.scene.mesh import Profile
from flankload.scene.pair import Pair
from flankload.scene.spline import SplineHub, SplineShaft
from tests.support.gear_scenes import ABSENT, changed, one_line, refusal

#: Kinds of body 1, as a message names them.
KINDS_1 = (
    "'gear' or 'spline_shaft' or 'follower' or 'sprocket' or 'pulley' or 'mesh' or 'compliance'"
)

KINDS_2 = "'gear' or 'ring' or 'spline_hub' or 'cam' or 'chain' or 'belt' or 'mesh' or 'compliance'"
TORQUES = "a number from 0 to 1e+12 or a non-empty list of numbers from 0 to 1e+12"


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        # unknown keys
        (
            {"body_1__modul_mm": 4},
            "body_1.modul_mm",
            "a known key (did you mean module_mm?)",
            "the unknown key 'modul_mm'",
        ),
        (
            {"laod": {}},
            "laod",
            "a known key (did you mean load?)",
            "the unknown key 'laod'",
        ),
        (
            {"pair__x": 1},
            "pair.x",
            f"a known key ({', '.join(Pair.__struct_fields__)})",
            "the unknown key 'x'",
        ),
        (
            {"effects__wind": 1},
            "effects.wind",
            f"a known key ({', '.join(EffectsAsked.__struct_fields__)})",
            "the unknown key 'wind'",
        ),
        (
            {"body_2": {"kind": "spline_hub", "topography_file": "a.csv"}},
            "body_2.topography_file",
            "no such key, since this version does not simulate measured topographies",
            "'a.csv'",
        ),
        # missing keys and tables
        (
            {"body_1__teeth": ABSENT},
            "body_1.teeth",
            "an integer from 3 to 10000",
            "nothing",
        ),
        (
            {"body_1__bore_diameter_mm": ABSENT},
            "body_1.bore_diameter_mm",
            "a number from 0.001 to 100000",
            "nothing",
        ),
        (
            {"body_1__kind": ABSENT},
            "body_1.kind",
            KINDS_1,
            "nothing",
        ),
        (
            {"body_2": ABSENT, "load": ABSENT},
            "body_2.kind",
            f"{KINDS_2} (also missing: load.torque_Nm)",
            "nothing",
        ),
        (
            {"pair": ABSENT},
            "pair.face_width_mm",
            "a number from 0.001 to 100000",
            "nothing",
        ),
        (
            {
                "body_1__teeth": ABSENT,
                "body_1__module_mm": ABSENT,
                "body_2__tip_diameter_mm": ABSENT,
                "pair": {},
                "load": ABSENT,
            },
            "body_1.teeth",
            (
                "an integer from 3 to 10000 (also missing: module_mm, body_2.tip_diameter_mm, "
                "pair.face_width_mm, load.torque_Nm)"
            ),
            "nothing",
        ),
        (
            {"load__torque_Nm": ABSENT},
            "load.torque_Nm",
            TORQUES,
            "nothing",
        ),
        # wrong types
        (
            {"body_1": 3},
            "body_1",
            "a table",
            "3",
        ),
        (
            {"body_1__kind": "ring"},
            "body_1.kind",
            KINDS_1,
            "'ring'",
        ),
        (
            {"body_1__kind": ["gear"]},
            "body_1.kind",
            KINDS_1,
            "['gear']",
        ),
        (
            {"body_1__teeth": "16"},
            "body_1.teeth",
            "an integer from 3 to 10000",
            "'16'",
        ),
        (
            {"body_1__teeth": 16.5},
            "body_1.teeth",
            "an integer from 3 to 10000",
            "16.5",
        ),
        (
            {"body_1__teeth": True},
            "body_1.teeth",
            "an integer from 3 to 10000",
            "true",
        ),
        (
            {"body_1__module_mm": False},
            "body_1.module_mm",
            "a number from 0.001 to 100000",
            "false",
        ),
        (
            {"body_1__rigid": 1},
            "body_1.rigid",
            "true or false",
            "1",
        ),
        (
            {"name": 7},
            "name",
            "a non-empty string",
            "7",
        ),
        (
            {"name": "\ud800"},
            "name",
            "a non-empty string",
            "one with the letter U+D800",
        ),
        (
            {"name": "a\0b"},
            "name",
            "a non-empty string",
            "one with the letter U+0000",
        ),
        (
            {"name": " "},
            "name",
            "a non-empty string",
            "' '",
        ),
        (
            {"positions__angles_deg": 3.0},
            "positions.angles_deg",
            "a non-empty list of numbers from -1e+07 to 1e+07",
            "3.0",
        ),
        (
            {"positions__angles_deg": []},
            "positions.angles_deg",
            "a non-empty list of numbers from -1e+07 to 1e+07",
            "[]",
        ),
        (
            {"positions__angles_deg": [0, "a"]},
            "positions.angles_deg[1]",
            "a number from -1e+07 to 1e+07",
            "'a'",
        ),
        (
            {"load__torque_Nm": "302"},
            "load.torque_Nm",
            TORQUES,
            "'302'",
        ),
        # out of range
        (
            {"body_1__teeth": 2},
            "body_1.teeth",
            "an integer from 3 to 10000",
            "2",
        ),
        (
            {"body_1__module_mm": 0},
            "body_1.module_mm",
            "a number from 0.001 to 100000",
            "0",
        ),
        (
            {"body_1__poisson_ratio": 0.5},
            "body_1.poisson_ratio",
            "a number >= 0 and < 0.5",
            "0.5",
        ),
        (
            {"body_1__profile_shift": float("nan")},
            "body_1.profile_shift",
            "a number from -5 to 5",
            "nan",
        ),
        (
            {"body_1__young_modulus_MPa": float("inf")},
            "body_1.young_modulus_MPa",
            "a number from 0.001 to 1e+09",
            "inf",
        ),
        (
            {"pair__face_width_mm": -14},
            "pair.face_width_mm",
            "a number from 0.001 to 100000",
            "-14",
        ),
        (
            {"pair__face_width_mm": 10**400},
            "pair.face_width_mm",
            "a number from 0.001 to 100000",
            "1" + 76 * "0" + "...",
        ),
        (
            {"load__torque_Nm": -1},
            "load.torque_Nm",
            TORQUES,
            "-1",
        ),
        (
            {"load__torque_Nm": []},
            "load.torque_Nm",
            "a non-empty list of numbers from 0 to 1e+12",
            "[]",
        ),
        (
            {"load__torque_Nm": datetime.date(2026, 1, 31)},
            "load.torque_Nm",
            TORQUES,
            "2026-01-31",
        ),
        (
            {
                "body_2": {
                    "kind": "chain",
                    "pitch_mm": 12.7,
                    "roller_diameter_mm": 8.5,
                    "wrap_angle_deg": 180,
                    "link_stiffness_N": 5e-324,
                    "contact_stiffness_N_per_mm": 1e5,
                }
            },
            "body_2.link_stiffness_N",
            "a number from 0.001 to 1e+12",
            "5e-324",
        ),
        (
            {"load__torque_Nm": b"x"},
            "load.torque_Nm",
            TORQUES,
            "[120]",
        ),
        (
            {"load__torque_Nm": 1e300},
            "load.torque_Nm",
            TORQUES,
            "1e+300",
        ),
        (
            {"body_1__pitch_errors_um": [1e300] * 16},
            "body_1.pitch_errors_um[0]",
            "a number from -1e+06 to 1e+06",
            "1e+300",
        ),
        (
            {"effects__temperature_rise_K": ["a"]},
            "effects.temperature_rise_K",
            "a list of 2 numbers from -273 to 2000",
            "['a']",
        ),
        (
            {"effects__friction_coefficient": [[0.0, float("inf")], [1.0, 0.1]]},
            "effects.friction_coefficient[0][1]",
            "a number",
            "inf",
        ),
        (
            {"body_1__tip_relief_um": None},
            "body_1.tip_relief_um",
            "a number from 0 to 1e+06",
            "None",
        ),
        (
            {"load": np.array([1.0, 2.0])},
            "load",
            "a table",
            "[1.0, 2.0]",
        ),
        (
            {"load__torque_Nm": [1, -2]},
            "load.torque_Nm[1]",
            "a number from 0 to 1e+12",
            "-2",
        ),
        (
            {"positions__count": 0},
            "positions.count",
            "an integer from 1 to 100000",
            "0",
        ),
        (
            {"positions__driver": "body_3"},
            "positions.driver",
            "'body_1' or 'body_2'",
            "'body_3'",
        ),
        (
            {"accuracy__tolerance": 0.5},
            "accuracy.tolerance",
            "a number from 0.0001 to 0.1",
            "0.5",
        ),
        (
            {"accuracy__modes": 2},
            "accuracy.modes",
            "an integer from 3 to 12",
            "2",
        ),
        (
            {"accuracy__plane": "shell"},
            "accuracy.plane",
            "'strain' or 'stress'",
            "'shell'",
        ),
        (
            {"positions__pitches": "all"},
            "positions.pitches",
            "an integer from 1 to 10000 or 'hunting'",
            "'all'",
        ),
        (
            {"positions__pitches": 0},
            "positions.pitches",
            "an integer from 1 to 10000 or 'hunting'",
            "0",
        ),
        (
            {"positions__pitches": [2, 3]},
            "positions.pitches",
            "an integer from 1 to 10000 or 'hunting'",
            "[2, 3]",
        ),
        ({"positions__adaptive": 1}, "positions.adaptive", "true or false", "1"),
        (
            {"positions": {"adaptive": True, "tolerance": 0}},
            "positions.tolerance",
            "a number from 1e-05 to 0.1",
            "0",
        ),
    ],
    ids=lambda value: next(iter(value), "") if isinstance(value, Mapping) else "",
)
def test_bad_key_gets_one_line(
    changes: dict[str, Any], key: str, expected: str, found: str
) -> None:
    one_line(changes, key, expected, found)


def test_scene_must_be_a_table() -> None:
    assert str(refusal([1])) == "a.toml: scene: expected a table, found [1]"


def test_long_values_are_cut_in_the_message() -> None:
    error = refusal(changed(body_1__teeth="x" * 500))
    assert len(error.found) <= 80


def test_keys_of_a_body_have_the_order_of_a_design() -> None:
    """Regression: the table of keys began with the tooth thickness instead of required keys."""
    keys = list(fields_of(Gear))
    assert keys[:4] == ["teeth", "module_mm", "tip_diameter_mm", "bore_diameter_mm"]
    assert set(keys[:4]) == set(required_of(Gear))
    groups = [group_of(key) for key in keys[4:]]
    assert list(dict.fromkeys(groups)) == list(GROUPS)
    for form in (Gear, Ring, SplineShaft, SplineHub, Profile):
        alone = [key for key in fields_of(form) if group_of(key) is None and key != "kind"]
        assert alone == [], "keys of teeth belong to a group of flankload.scene.groups"
