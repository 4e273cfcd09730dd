"""Splines in three dimensions on coarse elements, and their plane sections."""

from __future__ import annotations

from typing import Any

import flankload as fl
from tests.support.solving import solve as solve_scene
from tests.support.three_dimensional import tree_of

COUPLING = "crowned_coupling"
#: The example on coarse elements, with straight teeth on a common axis.
SMALL: dict[str, Any] = {
    "accuracy__flank_element_mm": 0.9,
    "accuracy__modes": 3,
    "accuracy__axial_degree": 6,
    "accuracy__load_degree_z": 2,
    "accuracy__slices": 8,
    "positions__count": None,
    "positions__angles_deg": [0.0],
    "body_1__lead_crowning_um": None,
    "pair__misalignment_mrad": None,
    "effects__dimension": 3,
}
EQUAL = {f"body_{z}__face_width_mm": 16.0 for z in (1, 2)}
CROWNED, MISALIGNED = {"body_1__lead_crowning_um": 20.0}, {"pair__misalignment_mrad": 3.0}
TEETH, TORQUE_NMM = 24, 600e3


def scene(**changes: Any) -> fl.Scene:
    """The coupling with changed keys."""
    return fl.Scene.from_dict(tree_of(COUPLING, {**SMALL, **changes}))


def solve(**changes: Any) -> fl.Result:
    """Its result in three dimensions."""
    found = solve_scene(scene(**changes))
    assert isinstance(found, fl.Result)
    return found


def plane(**changes: Any) -> fl.Result:
    """The plane section, with contact on cells."""
    of_slices = ("axial_degree", "load_degree_z", "slices")
    straight = {f"body_{z}__face_width_mm": 16.0 for z in (1, 2)}
    none = {f"accuracy__{key}": None for key in of_slices} | {"effects__dimension": None}
    return solve(**straight, **none, **changes)
