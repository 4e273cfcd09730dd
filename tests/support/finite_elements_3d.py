"""A spur pair in three dimensions by nonlinear finite elements."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import flankload as fl
from tests.support.solving import solve
from tests.support.three_dimensional import tree_of

#: Spur pair by nonlinear finite elements of two whole gears (15-node wedges, 300 000 + 400 000
#: degrees of freedom, pressure on the nodes, no kernel and no modes; checked against CalculiX):
#: position 0 with pair 0 in the pitch point, half a pitch later with two pairs. Uncertainties:
#: 0.06 %, 5 N of the forces, 0.5 N/mm (5 N/mm at the end), 0.5 to 1 % of the pressures.
FINITE_ELEMENTS: dict[str, Any] = {
    "transmission_error_um": (47.949, 33.955),
    "base_radius_mm": 33.828937,
    "force_N": {-1: 4366.0, 0: 4561.0},
    "middle_N_per_mm": {(0, 0): 640.6, (1, -1): 309.8, (1, 0): 324.3},
    "middle_MPa": {(0, 0): 1661.0, (1, -1): 1389.0, (1, 0): 1179.0},
    "last_half_mm_N_per_mm": 560.0,
}


def solved_like_finite_elements(**changes: Any) -> fl.Result:
    """The spur pair at the positions of the finite elements."""
    places = {"positions__count": None, "positions__angles_deg": [0.0, 11.25]}
    tree = tree_of("external_gear", {"effects__dimension": 3, **places, **changes})
    found = solve(fl.Scene.from_dict(tree))
    assert isinstance(found, fl.Result)
    return found


def check_rotation_and_loads(found: fl.Result, *, rotation: float, load: float) -> None:
    """Hold rotations and line loads of the middle within parts, load shares as the rotations."""
    wanted = FINITE_ELEMENTS
    te_um = found.rotation_rad * wanted["base_radius_mm"] * 1000.0
    np.testing.assert_allclose(te_um, wanted["transmission_error_um"], rtol=rotation)
    s = found.sites.tolist().index
    total = sum(wanted["force_N"].values())
    for site, force in wanted["force_N"].items():
        assert found.load_share[1, s(site)] == pytest.approx(force / total, abs=rotation)
    middle = found.slice_z_mm.size // 2
    for (p, site), force in wanted["middle_N_per_mm"].items():
        of_middle = found.slice_line_load_N_per_mm[p, s(site), middle]
        assert of_middle == pytest.approx(force, rel=load)
