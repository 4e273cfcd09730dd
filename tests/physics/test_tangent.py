"""Tangent stiffness against differences of the rotation that the program itself computes."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

import flankload as fl

SCENES = Path(__file__).parents[2] / "examples" / "scenes"
#: The differences' own error: second order in the step, rounding of the rotation over the step.
DIFFERENCES = 1e-6
#: Smaller than the step that the tangent itself is made with.
STEP = 1e-4


@pytest.mark.parametrize("friction", [0.0, 0.1])
@pytest.mark.parametrize("name", ["external_gear", "internal_gear"])
def test_tangent_is_what_the_rotation_does(name: str, friction: float) -> None:
    tables = tomllib.loads((SCENES / f"{name}.toml").read_text(encoding="utf-8"))
    torque = tables["load"]["torque_Nm"]
    tables |= {
        "load": {"torque_Nm": [torque * (1 - STEP), torque, torque * (1 + STEP)]},
        "effects": {"friction_coefficient": friction},
        "accuracy": {"estimate": False},
    }
    less, here, more = fl.solve(fl.Scene.from_dict(tables))
    found = (more.torque_Nm - less.torque_Nm) / (more.rotation_rad - less.rotation_rad)
    beside = np.abs(found / here.stiffness_tangent_Nm_per_rad - 1.0)
    # on a corner, or where the next pair is just about to touch, cells change their number
    assert np.quantile(beside, 0.85) < DIFFERENCES
    assert beside.max() < 1e-3
    assert "tangent" in here.cost["stages"]


def test_no_torque_needs_no_tangent() -> None:
    tables = tomllib.loads((SCENES / "external_gear.toml").read_text(encoding="utf-8"))
    tables["load"]["torque_Nm"] = 0
    result = fl.solve(fl.Scene.from_dict(tables))
    assert isinstance(result, fl.Result)
    assert np.isnan(result.stiffness_tangent_Nm_per_rad).all()


def test_a_torque_that_just_holds_keeps_the_tangent_of_its_state() -> None:
    """A little more torque has no state; the derivative with the pairs in contact held stays."""
    from flankload.errors import NoContactState
    from flankload.sweep import Sweep
    from flankload.tangent import with_tangents

    numbers = {name: np.ones(1) for name in Sweep.__dataclass_fields__}
    state = Sweep(**(numbers | {"torque_Nmm": 5.0}))  # type: ignore[arg-type]

    def fails(**_: object) -> tuple[Sweep, ...]:
        raise NoContactState("none")

    assert with_tangents((state,), fails) == (state,)
