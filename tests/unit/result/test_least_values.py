"""Least possible values of quantities, by their names."""

from __future__ import annotations

import numpy as np

import flankload as fl
from flankload.result.quantities import LEAST, curves_of, least_of
from flankload.studies.design.run import row_of
from tests.support.design_scene import design_scene
from tests.support.paths import SCENES
from tests.support.solving import solve


def values_of(scene: fl.Scene) -> dict[str, np.ndarray]:
    """Numbers of each quantity of a study of the scene."""
    (result,) = solve(scene).by_torque
    quantities = row_of(result, tuple(curves_of(result)))["quantities"]
    numbers = {name: np.ravel(np.array(value, dtype=object)) for name, value in quantities.items()}
    return {
        name: np.array([x for x in found if isinstance(x, int | float)])
        for name, found in numbers.items()
    }


def test_least_values_are_those_of_quantities_and_no_value_is_below() -> None:
    rubbing = {"effects.friction_coefficient": 0.05, "effects.speed_rpm": 1500.0}
    coast = {"effects.coast_flank": True, **rubbing}
    helical = fl.read_scene(SCENES / "helical_gear.toml").replace(
        {
            "accuracy.flank_element_mm": 4.0,
            "accuracy.axial_degree": 4,
            "accuracy.load_degree_z": 0,
            "accuracy.slices": 3,
            "positions": {"count": 2},
            "effects.root_stress": True,
        }
    )
    found = values_of(design_scene(**coast)) | values_of(helical)
    assert LEAST.keys() <= {name.rpartition(".")[2] for name in found}
    for name, values in found.items():
        assert np.all(values >= least_of(name)), name
