"""Flank tolerances by ISO 1328-1:2013: values worked out by hand, rounding, ranges."""

from __future__ import annotations

from dataclasses import astuple
from typing import Any

import pytest

import flankload as fl

GEAR: dict[str, Any] = {"teeth": 24, "module_mm": 4.5, "face_width_mm": 14}


@pytest.mark.parametrize(
    ("tolerance_class", "values"),
    [
        # before rounding 6.908, 21.082, 5.908, 7.475, 9.528, 5.829, 6.411, 8.665
        (5, (7.0, 21.0, 6.0, 7.5, 9.5, 6.0, 6.5, 8.5)),
        # a quarter: 1.727, 5.270, 1.477, 1.869, 2.382, 1.457, 1.603, 2.166
        (1, (1.7, 5.5, 1.5, 1.9, 2.4, 1.5, 1.6, 2.2)),
        # eight times: 55.264, 168.65, 47.264, 59.8, 76.22, 46.63, 51.29, 69.32
        (11, (55, 169, 47, 60, 76, 47, 51, 69)),
    ],
)
def test_tolerances_are_those_of_the_formulas(tolerance_class: int, values: Any) -> None:
    assert astuple(fl.iso_1328(tolerance_class, **GEAR)) == (tolerance_class, *values)


def test_a_helical_gear_has_the_diameter_of_its_transverse_module() -> None:
    """With cos(beta) = 0.8 and 40 teeth of 2 mm, d is 100 mm, as with 50 straight teeth."""
    helical = fl.iso_1328(
        7, teeth=40, module_mm=2, face_width_mm=20, helix_angle_deg=36.869897645844021
    )
    assert helical == fl.iso_1328(7, teeth=50, module_mm=2, face_width_mm=20)


@pytest.mark.parametrize(
    ("tolerance_class", "changes", "line"),
    [
        (12, {}, "class: expected an integer from 1 to 11 (ISO 1328-1), found 12"),
        (6.5, {}, "class: expected an integer from 1 to 11 (ISO 1328-1), found 6.5"),
        (None, {}, "class: expected an integer from 1 to 11 (ISO 1328-1), found nothing"),
        (
            7,
            {"teeth": 4},
            "teeth: expected a number from 5 to 1000, the range of ISO 1328-1, found",
        ),
        (7, {"face_width_mm": 3.9}, "face_width_mm: expected a number from 4 to 1200, the range"),
        (7, {"module_mm": 0.4}, "module_mm: expected a number from 0.5 to 70, the range of ISO"),
        (7, {"helix_angle_deg": 46}, "helix_angle_deg: expected a number from 0 to 45, the range"),
        (
            7,
            {"teeth": 5, "module_mm": 0.9},
            "module_mm: expected a reference diameter from 5 to 15000 mm, the range of ISO 1328-1",
        ),
    ],
)
def test_gears_beyond_the_standard_get_one_line(
    tolerance_class: Any, changes: dict[str, Any], line: str
) -> None:
    with pytest.raises(fl.SceneError) as refused:
        fl.iso_1328(tolerance_class, **(GEAR | changes))
    assert line in str(refused.value)
