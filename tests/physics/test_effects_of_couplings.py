"""Splines in three dimensions: root stress, expansion and friction.

Without lateral contraction nothing varies over the width of straight teeth: stress, expansion and
offset axes are then those of the plane pair, whose contact is on cells.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload.result import results_to_text
from tests.support.couplings import CROWNED, EQUAL, MISALIGNED, TEETH, TORQUE_NMM, plane, solve
from tests.support.three_dimensional import deviation

STRAIGHT: dict[str, Any] = {f"body_{z}__poisson_ratio": 0.0 for z in (1, 2)}
#: Axes 10 um apart slide along the profile.
APART = {"pair__center_offset_mm": 0.01}
FRICTION = {"effects__friction_coefficient": 0.1}


def both(**changes: Any) -> tuple[fl.Result, fl.Result]:
    """The same in slices and on plane cells."""
    return solve(**EQUAL, **STRAIGHT, **changes), plane(**STRAIGHT, **changes)


@cache
def turned_by_torque() -> tuple[float, float]:
    """Rotations without other effects; they differ by 0.02 %."""
    one, two = (float(found.rotation_rad[0]) for found in both())
    assert one == pytest.approx(two, rel=4e-4)
    return one, two


def test_root_stress_is_that_of_plane_cells() -> None:
    """The force is distributed over the height as in the plane: measured difference 0.07 %."""
    one, two = both(effects__root_stress=True)
    for z in (0, 1):
        solid, flat = one.root_stress[z], two.root_stress[z]
        assert solid is not None
        assert flat is not None
        for name in ("tension", "compression"):
            largest, wanted = (getattr(part, name).stress_MPa for part in (solid, flat))
            np.testing.assert_allclose(largest, wanted, rtol=1.5e-3)
        # no slice differs from another one
        slices = solid.slice_tension_MPa
        np.testing.assert_allclose(
            slices, np.broadcast_to(slices[0, 0, 0], slices.shape), rtol=1e-3
        )


@pytest.mark.parametrize(
    "changes",
    [
        {"effects__temperature_rise_K": [15.0, 0.0]},
        {"effects__temperature_rise_K": 15.0, "effects__support_expansion_per_K": 0.0},
        {"effects__speed_rpm": 20000.0},
    ],
)
def test_expansion_turns_the_shaft_as_in_the_plane(changes: dict[str, Any]) -> None:
    """Measured 3e-4 of the rotation under the torque."""
    one, two = both(**changes)
    cold, wanted = turned_by_torque()
    turned, flat = float(one.rotation_rad[0]) - cold, float(two.rotation_rad[0]) - wanted
    assert turned == pytest.approx(flat, abs=1e-3 * wanted)
    assert abs(flat) > 5e-3 * wanted
    assert not any("expand so differently" in note for note in one.warnings)


def test_a_height_that_expansion_opens_is_named() -> None:
    hot = solve(**EQUAL, **STRAIGHT, effects__temperature_rise_K=[40.0, 0.0])
    assert any("expand so differently" in note for note in hot.warnings)


@pytest.mark.parametrize("driver", ["body_1", "body_2"])
def test_friction_on_offset_axes_is_that_of_plane_cells(driver: str) -> None:
    """Levers and tangential forces, which cancel by two thirds: measured 3 % of the change."""
    without = [float(found.rotation_rad[0]) for found in both(**APART)]
    one, two = both(**APART, **FRICTION, positions__driver=driver)
    change, wanted = (
        float(found.rotation_rad[0]) / alone - 1.0
        for found, alone in zip((one, two), without, strict=True)
    )
    assert change == pytest.approx(wanted, rel=0.05)
    assert abs(wanted) > 0.03
    assert one.friction is not None
    assert two.friction is not None
    np.testing.assert_allclose(one.friction.loss_J_per_rad, two.friction.loss_J_per_rad, rtol=0.01)
    np.testing.assert_allclose(one.load_share, two.load_share, atol=8e-3)


def test_the_moment_of_friction_on_hardly_misaligned_axes() -> None:
    """All teeth carry the same: the work of the moment is that of mu F along the sliding.

    Sliding is y by the angle of the axes along z, and z along the profile's part across the plane
    of the misalignment. Narrow teeth slide along z only, with the moment 2/pi mu T r/r_b.
    """
    found = solve(**EQUAL, **STRAIGHT, **FRICTION, pair__misalignment_mrad=0.001)
    assert found.friction is not None
    assert found.friction.tilting_moments_Nm is not None
    x, y = found.friction.tilting_moments_Nm[0]
    table, base_mm = found.pairs(0), TEETH * np.cos(np.radians(30.0))
    force_N = 0.1 * TORQUE_NMM / base_mm
    assert table.z_mm is not None
    wanted = force_N * np.hypot(table.y_mm, table.z_mm * table.normal_x).mean() / 1000.0
    assert abs(x) == pytest.approx(wanted, rel=5e-3)
    narrow = 2.0 / np.pi * force_N * np.hypot(table.x_mm, table.y_mm).mean() / 1000.0
    assert narrow < wanted < 1.05 * narrow
    assert abs(y) < 0.05 * wanted
    np.testing.assert_allclose(found.friction.axial_force_N, 0.0, atol=1e-3 * TORQUE_NMM / base_mm)


@pytest.mark.parametrize("driver", ["body_1", "body_2"])
def test_the_work_of_a_misaligned_coupling_is_lost_in_friction(driver: str) -> None:
    """Torque on the shaft and moment about the leaning axis of the hub; measured 1.4 %."""
    places = {"positions__angles_deg": None, "positions__count": 4}
    found = solve(**CROWNED, **MISALIGNED, **FRICTION, **places, positions__driver=driver)
    friction = found.friction
    assert friction is not None
    assert friction.work_1_J is not None
    assert friction.work_2_J is not None
    sense = 1.0 if driver == "body_1" else -1.0
    lost = sense * (friction.work_1_J - friction.work_2_J)
    assert lost == pytest.approx(friction.loss_work_J, rel=0.025)
    assert friction.efficiency == pytest.approx(1.0 - lost / friction.work_1_J, abs=1e-5)
    assert friction.tilting_moment_Nm is not None
    said = f"tilting moment up to {friction.tilting_moment_Nm.max():.4g} N m; loss"
    assert said in results_to_text([found])


def test_half_a_turn_of_a_rubbing_press_fit_exchanges_both_sides() -> None:
    """About the line of centres; the coupling then turns the other way."""
    shift = 0.05 + 0.003 / (2 * 2.0 * np.tan(np.radians(30.0)))
    keys = {"body_1__profile_shift": shift, "effects__coast_flank": True, "load__torque_Nm": 0.0}
    tilted = {"pair__misalignment_mrad": 3.0, "pair__misalignment_direction_deg": 90.0}
    one, two = (
        solve(**EQUAL, **keys, **tilted, **FRICTION, positions__driver=f"body_{z}") for z in (1, 2)
    )
    assert two.coast is not None
    working = one.slices.force_N[0]
    turned_over = working[-np.arange(TEETH) % TEETH, ::-1]
    coast = two.coast.pair_tables[0].force_N.reshape(working.shape)
    assert deviation(coast, turned_over) < 1e-7
    assert one.coast is not None
    other = one.coast.pair_tables[0].force_N.reshape(working.shape)
    assert deviation(other, turned_over) > 1e-4
