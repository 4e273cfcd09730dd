"""Drawing data of `flankload check` and of the report agree."""

from math import asin, atan, cos, radians, sin, tan

import pytest

import flankload as fl
from flankload.mechanisms.flank_pair.data_sheet import data_sheet
from flankload.mechanisms.flank_pair.description import describe
from tests.support.gear_scenes import example


def inv(angle: float) -> float:
    return tan(angle) - angle


def number(text: str) -> float:
    return float(text.split()[0])


def test_normal_backlash_includes_the_helix_angle_on_the_base_cylinder() -> None:
    """Regression: `check` printed the transverse value, the report the normal one."""
    keys = example("helical_gear")
    scene = fl.Scene.from_dict(keys)
    one, two = keys["body_1"], keys["body_2"]
    normal, helix = radians(20.0), radians(15.0)
    transverse = atan(tan(normal) / cos(helix))
    bases = [0.5 * body["teeth"] * 3.0 / cos(helix) * cos(transverse) for body in (one, two)]
    working = _angle(sum(bases) / 132.0)
    shifts, teeth = (sum(body[key] for body in (one, two)) for key in ("profile_shift", "teeth"))
    tight = inv(transverse) + 2.0 * tan(normal) * shifts / teeth
    # ISO 21771: sin(beta_b) = sin(beta) cos(alpha_n)
    wanted = 2.0 * sum(bases) * (inv(working) - tight) * cos(asin(sin(helix) * cos(normal)))
    checked = number(dict(describe(scene).rows["pair"])["backlash, normal"])
    (shown,) = (number(row.value) for row in data_sheet(scene).pair if row.symbol == "j_bn")
    assert checked == shown == pytest.approx(wanted, abs=6e-5)


def _angle(cosine: float) -> float:
    return atan((1.0 - cosine**2) ** 0.5 / cosine)


@pytest.mark.parametrize("k", [None, 4])
def test_span_measurements_are_over_the_same_number_of_teeth(k: int | None) -> None:
    """Regression: `check` used 9 teeth of this wheel (2 of FZG C), the report 10 (3)."""
    sizes = {"teeth": 71, "module_mm": 2.5, "helix_angle_deg": 18.0, "tip_diameter_mm": 191.37}
    wheel = {"kind": "gear", "hand": "left", "profile_shift": -0.05, "bore_diameter_mm": 60.0}
    pinion = {"teeth": 23, "hand": "right", "profile_shift": 0.25, "tip_diameter_mm": 66.7}
    keys = {
        "body_1": {**sizes, "kind": "gear", "bore_diameter_mm": 25.0, **pinion},
        "body_2": {**sizes, **wheel},
        "pair": {"center_distance_mm": 124.1, "face_width_mm": 30.0},
        "load": {"torque_Nm": 320.0},
    }
    if k is not None:
        keys["body_1"] |= {"span_measurement_mm": 27.15, "span_teeth": k}
    scene = fl.Scene.from_dict(keys)
    found = describe(scene).rows
    for z, rows in enumerate(data_sheet(scene).bodies):
        checked = dict(found[f"body_{z + 1}: gear"])["span measurement"]
        (shown,) = (row.value for row in rows if row.symbol == "W_k")
        assert shown.replace("k = ", "") == checked
        assert number(shown) == pytest.approx(27.15 if k and not z else number(checked))
