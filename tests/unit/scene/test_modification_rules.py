"""Rules between the keys of reliefs and of the protuberance, each with its line."""

from typing import Any, get_args, get_type_hints

import pytest

from flankload.scene import Gear, Scene
from flankload.scene.table import RELIEF_EXPONENTS
from tests.support.gear_scenes import changed, one_line

DOUBLE = {
    "body_1__tip_relief_um": 20.0,
    "body_1__tip_relief_start_diameter_mm": 76.0,
    "body_1__tip_relief_shape": "double_linear",
}


@pytest.mark.parametrize(
    ("changes", "key", "expected", "found"),
    [
        (
            DOUBLE,
            "body_1.tip_relief_knee_um",
            "a number, since body_1.tip_relief_shape is 'double_linear'",
            "nothing",
        ),
        (
            {"body_1__tip_relief_knee_um": 5.0},
            "body_1.tip_relief_knee_um",
            "nothing without body_1.tip_relief_shape = 'double_linear'",
            "5.0",
        ),
        (
            {"body_1__root_relief_um": 5.0},
            "body_1.root_relief_start_diameter_mm",
            (
                "a number > 0 (or root_relief_start_roll_angle_deg, root_relief_length), since "
                "there is a body_1.root_relief_um"
            ),
            "nothing",
        ),
        (
            {"body_1__root_relief_shape": "parabolic"},
            "body_1.root_relief_um",
            "a number >= 0, since there is a body_1.root_relief_shape",
            "nothing",
        ),
        (
            {"body_1__grinding_stock_mm": 0.1},
            "body_1.protuberance_mm",
            "a number, since there is a body_1.grinding_stock_mm",
            "nothing",
        ),
        (
            {"body_1__protuberance_mm": 0.1, "body_1__grinding_stock_mm": 0.1},
            "body_1.protuberance_mm",
            "more than body_1.grinding_stock_mm (0.1), so that the root is cut free",
            "0.1",
        ),
        (
            {"body_1__protuberance_mm": 0.1, "body_1__protuberance_angle_deg": 20.0},
            "body_1.protuberance_angle_deg",
            "less than body_1.pressure_angle_deg (20)",
            "20.0",
        ),
    ],
)
def test_contradicting_keys_get_one_line(
    changes: dict[str, Any], key: str, expected: str, found: str
) -> None:
    one_line(changes, key, expected, found)


@pytest.mark.parametrize(
    "keys",
    [
        {"tip_relief_um": 0},
        {"root_relief_um": 0.0},
        {"tip_relief_um": 0, "tip_relief_shape": "double_linear"},
    ],
)
def test_a_relief_of_0_begins_nowhere(keys: dict[str, Any]) -> None:
    """Regression: a study from 0 to 30 um needed a start for its first design."""
    Scene.from_dict(changed(**{f"body_1__{key}": value for key, value in keys.items()}))


@pytest.mark.parametrize("key", ["tip_relief_shape", "root_relief_shape", "end_relief_shape"])
def test_every_shape_of_a_relief_has_its_exponent(key: str) -> None:
    """Regression: a shape without an entry was silently linear."""
    shapes = get_args(get_args(get_type_hints(Gear, include_extras=True)[key])[0])
    assert set(shapes) <= set(RELIEF_EXPONENTS)
