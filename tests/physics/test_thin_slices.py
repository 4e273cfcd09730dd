"""Slices that are narrower than the contact is wide, or whose gap has no parabola."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

import flankload as fl
from tests.support.solving import solve

COARSE = {"modes": 3, "axial_degree": 5, "load_degree_z": 1, "estimate": False, "tangents": False}
#: Slices four times as many: of the rotation; measured 3.5e-5.
THIN = 1e-4
#: Steps of the largest change of a line load from position to position, of each other: 0.6 %;
#: with a jump 4.
EVEN = 0.03

#: A pinion with an undercut: the tips of the gear touch the corner behind it first.
UNDERCUT: dict[str, Any] = {
    "body_1": {
        "kind": "gear",
        "teeth": 15,
        "module_mm": 7.113,
        "profile_shift": -0.1563,
        "tip_diameter_mm": 119.38,
        "bore_diameter_mm": 42.0,
        "tip_chamfer_mm": 0.52,
        "helix_angle_deg": 1.32,
        "hand": "right",
        "lead_crowning_um": 10.3,
    },
    "body_2": {
        "kind": "gear",
        "teeth": 36,
        "module_mm": 7.113,
        "profile_shift": -0.1889,
        "tip_diameter_mm": 268.33,
        "bore_diameter_mm": 176.2,
        "tip_chamfer_mm": 0.376,
        "helix_angle_deg": 1.32,
        "hand": "left",
        "lead_crowning_um": 3.5,
        "helix_slope_um": -11.2,
    },
    "pair": {"center_distance_mm": 179.3, "face_width_mm": 43.0},
    "load": {"torque_Nm": 655.0},
    "positions": {"angles_deg": [8.55, 8.6, 8.65, 8.7, 8.75, 8.8]},
    "effects": {"dimension": 3},
    "accuracy": COARSE | {"flank_element_mm": 5.6, "slices": 24},
}
#: A pinion in a ring, under a load that leaves the contacts on one end.
TILTED: dict[str, Any] = {
    "body_1": {
        "kind": "gear",
        "teeth": 20,
        "module_mm": 2.15,
        "pressure_angle_deg": 19.17,
        "helix_angle_deg": 17.24,
        "hand": "right",
        "profile_shift": 0.272,
        "tip_diameter_mm": 50.2,
        "bore_diameter_mm": 14.7,
        "tip_chamfer_mm": 0.17,
        "end_relief_um": [6.7, 6.1],
        "end_relief_length_mm": [1.4, 1.9],
    },
    "body_2": {
        "kind": "ring",
        "teeth": 78,
        "module_mm": 2.15,
        "pressure_angle_deg": 19.17,
        "helix_angle_deg": 17.24,
        "hand": "right",
        "profile_shift": 0.272,
        "tip_diameter_mm": 172.8,
        "root_diameter_mm": 182.3,
        "outer_diameter_mm": 206.0,
        "helix_slope_um": -7.4,
    },
    "pair": {"center_distance_mm": 65.23, "face_width_mm": 9.45},
    "load": {"torque_Nm": 3.9},
    "positions": {"count": 1},
    "effects": {"dimension": 3},
    "accuracy": COARSE | {"flank_element_mm": 1.7},
}


def solved(scene: dict[str, Any], slices: int) -> fl.Result:
    table = copy.deepcopy(scene)
    table["accuracy"]["slices"] = slices
    result = solve(fl.Scene.from_dict(table))
    assert isinstance(result, fl.Result)
    return result


def test_line_loads_are_continuous_where_contacts_leave_an_undercut() -> None:
    """Regression: a parabola of a width of millimetres stood for a corner with a hollow flank."""
    result = solved(UNDERCUT, 24)
    assert result.corner_contact.any()
    steps = np.abs(np.diff(result.slice_line_load_N_per_mm, axis=0)).max(axis=(1, 2))
    assert np.ptp(steps) <= EVEN * steps.mean()


def test_thin_slices_at_an_undercut_have_a_state() -> None:
    """Regression: "no pair could carry the torque", since K had a negative diagonal."""
    wide, thin = (solved(UNDERCUT, slices) for slices in (24, 96))
    np.testing.assert_allclose(thin.rotation_rad, wide.rotation_rad, rtol=THIN)


def test_contacts_wider_than_their_estimate_have_a_state() -> None:
    """Regression: K had a negative diagonal, and "no pair could carry the torque"."""
    wide, thin = (solved(TILTED, slices) for slices in (40, 160))
    np.testing.assert_allclose(thin.rotation_rad, wide.rotation_rad, rtol=THIN)
