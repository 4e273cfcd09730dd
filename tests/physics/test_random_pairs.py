"""Seeded external pairs of many shapes: statics, no penetration, and independence of the cells."""

from __future__ import annotations

import numpy as np
import pytest

import flankload as fl
from tests.support.solving import solve


def random_pair(seed: int) -> dict:
    """A pair with small backlash: shifts from the working angle, tips short of the mate's root."""
    rng = np.random.default_rng(seed)
    module = float(rng.uniform(1.0, 8.0))
    teeth = rng.integers(14, 70, 2)
    alpha = np.radians(20.0)
    working = np.radians(rng.uniform(19.0, 24.0))
    distance = module * teeth.sum() / 2 * np.cos(alpha) / np.cos(working)
    inv = np.tan([working, alpha]) - [working, alpha]
    total = teeth.sum() * (inv[0] - inv[1]) / (2 * np.tan(alpha))
    first = float(rng.uniform(0.3, 0.7)) * total
    shifts = np.array([first, total - first]) - 0.004
    roots = module * (teeth / 2 - 1.25 + shifts)
    tips = 2 * (distance - roots[::-1] - 0.25 * module)
    torque = module**2 * teeth[0] * float(rng.uniform(0.3, 3.0))
    bodies = {
        f"body_{z + 1}": {
            "kind": "gear",
            "teeth": int(teeth[z]),
            "module_mm": module,
            "profile_shift": float(shifts[z]),
            "tip_diameter_mm": float(tips[z]),
            "bore_diameter_mm": float(rng.uniform(0.4, 1.4) * roots[z]),
            **({"tip_radius_mm": 0.1 * module} if rng.random() < 0.4 else {}),
        }
        for z in range(2)
    }
    return {
        **bodies,
        "pair": {"center_distance_mm": float(distance), "face_width_mm": 3 * module},
        "load": {"torque_Nm": float(torque)},
        "positions": {"count": 24},
        "accuracy": {"estimate": False, "tangents": False},
    }


@pytest.mark.parametrize("seed", range(8))
def test_state_is_in_balance_and_nothing_penetrates(seed: int) -> None:
    scene = random_pair(seed)
    result = solve(fl.Scene.from_dict(scene))
    assert (result.status >= 0).all()
    for k in range(24):
        pairs = result.pairs(k)
        moment = pairs.force_N @ (pairs.x_mm * pairs.normal_y - pairs.y_mm * pairs.normal_x)
        assert moment == pytest.approx(1000 * scene["load"]["torque_Nm"], rel=1e-10)
        assert (pairs.force_N >= 0).all()
        assert (pairs.gap_um >= -1e-8).all()


@pytest.mark.parametrize("seed", range(4))
def test_answer_does_not_depend_on_the_cells(seed: int) -> None:
    """Twice the cells in three times the zone: 0.1 % of the rotation, 1 % on sharp corners."""
    scene = random_pair(seed)
    plain = solve(fl.Scene.from_dict(scene))
    scene["accuracy"] |= {
        "strips_per_half_width": 20,
        "corner_strips_per_half_width": 60,
        "zone_half_widths": 7.5,
    }
    fine = solve(fl.Scene.from_dict(scene))
    change = np.abs(plain.rotation_rad / fine.rotation_rad - 1)
    corner = plain.corner_contact.any(axis=1) | fine.corner_contact.any(axis=1)
    assert change[~corner].max(initial=0.0) < 1e-3
    assert change[corner].max(initial=0.0) < 1e-2


@pytest.mark.parametrize("seed", range(8))
def test_unloaded_conjugate_flanks_lose_no_pair(seed: int) -> None:
    """Without torque conjugate flanks touch at every position: a lost pair would show as a jump."""
    scene = random_pair(seed)
    scene["load"] = {"torque_Nm": 0}
    scene["positions"] = {"count": 500}
    result = solve(fl.Scene.from_dict(scene))
    np.testing.assert_allclose(result.transmission_error_um, 0.0, rtol=0, atol=1e-5)
