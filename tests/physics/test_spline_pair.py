"""Splines: equal shares, loads that travel with an offset, index errors as springs, convergence."""

from __future__ import annotations

import json
from functools import cache
from math import cos, radians
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import flankload as fl
from tests.support.solving import solve
from tests.support.tolerances import ROUND_OFF, SOLVER

TEETH, MODULE, WIDTH = 24, 2.0, 30.0
BASE_RADIUS = 0.5 * TEETH * MODULE * cos(radians(30))
TORQUE = 1500.0
SHAFT = {
    "kind": "spline_shaft",
    "teeth": TEETH,
    "module_mm": MODULE,
    "tip_diameter_mm": 49.6,
    "root_diameter_mm": 45.2,
    "bore_diameter_mm": 20.0,
}
HUB = {
    "kind": "spline_hub",
    "teeth": TEETH,
    "module_mm": MODULE,
    "profile_shift": 0.04,
    "tip_diameter_mm": 46.2,
    "root_diameter_mm": 50.8,
    "outer_diameter_mm": 75.0,
}
ROUNDED = {"tip_radius_mm": 0.2}

#: Flank curves are within 1e-9 mm of the involute; under 100 N m they approach by 8e-4 mm.
CURVES = 1e-8
#: Teeth on a thin rim between a held bore and a rigid hub still lean on each other a little.
SPRINGS = 0.005
#: Share of the largest load by which grids may differ where loads travel on.
TRAVELLING = 2e-6


def solved(
    shaft: dict | None = None,
    hub: dict | None = None,
    *,
    torque: float = TORQUE,
    offset: float = 0.0,
    angles: list[float] | None = None,
    **accuracy: object,
) -> fl.Result:
    tree = {
        "body_1": {**SHAFT, **(shaft or {})},
        "body_2": {**HUB, **(hub or {})},
        "pair": {"center_offset_mm": offset, "face_width_mm": WIDTH},
        "load": {"torque_Nm": torque},
        **({"positions": {"angles_deg": list(angles)}} if angles else {}),
        "accuracy": {"estimate": False, "tangents": False, **accuracy},
    }
    return _solved(json.dumps(tree, sort_keys=True))


@cache
def _solved(tree: str) -> fl.Result:
    found = solve(fl.Scene.from_dict(json.loads(tree)))
    assert isinstance(found, fl.Result)
    return found


def test_perfect_spline_shares_equally() -> None:
    found = solved()
    share = 1000 * TORQUE / (TEETH * BASE_RADIUS)
    np.testing.assert_allclose(found.site_force_N, share, rtol=SOLVER)
    assert found.status.tolist() == [0]
    assert found.loaded_pairs.tolist() == [TEETH]


def test_rounded_tips_share_equally_too() -> None:
    force = solved(ROUNDED, ROUNDED).site_force_N
    np.testing.assert_allclose(force, force.mean(), rtol=SOLVER)


def test_hundred_teeth_are_not_too_many() -> None:
    more = {"teeth": 100, "module_mm": 0.48}
    found = solved(
        {**more, "tip_diameter_mm": 48.4, "root_diameter_mm": 47.3},
        {**more, "tip_diameter_mm": 47.6, "root_diameter_mm": 48.7},
        strips_per_half_width=4,
    )
    assert found.sites.size == 100
    share = 1000 * TORQUE / (100 * 24.0 * cos(radians(30)))
    np.testing.assert_allclose(found.site_force_N, share, rtol=SOLVER)


def test_wind_up_grows_with_the_torque() -> None:
    """Sharp edges and no gaps: everything is linear."""
    one, three = (solved(torque=torque, tangents=True) for torque in (100.0, 300.0))
    np.testing.assert_allclose(three.rotation_rad, 3 * one.rotation_rad, rtol=CURVES)
    np.testing.assert_allclose(
        one.stiffness_tangent_Nm_per_rad, one.stiffness_secant_Nm_per_rad, rtol=CURVES
    )
    # a cell feels the curves more than all of them together
    np.testing.assert_allclose(
        three.pairs(0).pressure_MPa, 3 * one.pairs(0).pressure_MPa, rtol=1e4 * CURVES
    )


def test_the_whole_flank_is_covered_once() -> None:
    table = solved().pairs(0)
    for site in (0, 7):
        rows = table.site == site
        radius, along = table.radius_mm[rows], table.arc_length_1_mm[rows]
        assert np.all(np.diff(along) > 0)
        assert 23.1 < radius.min() < 23.11
        assert 24.79 < radius.max() < 24.8
        # cells that touch: half of both widths lies between their centres (flank 2 is as long)
        cell = table.cell_mm[rows]
        np.testing.assert_allclose(np.diff(along), 0.5 * (cell[1:] + cell[:-1]), rtol=1e-5)


def test_pressure_of_a_flat_punch_in_the_middle() -> None:
    """Peaks at both edges, the least in between, and the sum is the force."""
    found = solved()
    table = found.pairs(0)
    pressure = table.pressure_MPa[table.site == 0]
    assert pressure[0] > 3 * pressure.min() < pressure[-1]
    least = int(np.argmin(pressure))
    assert np.all(np.diff(pressure[:least]) < 0)
    assert np.all(np.diff(pressure[least:]) > 0)
    assert found.corner_contact.all()


@pytest.mark.parametrize("edge", [{}, ROUNDED], ids=["sharp", "rounded"])
@pytest.mark.parametrize("offset", [1e-7, 1e-3, 0.01, 0.03])
def test_loads_on_an_offset_travel_from_tooth_to_tooth(offset: float, edge: dict) -> None:
    """One pitch later, tooth j is where tooth j + 1 was; any offset has an answer."""
    found = solved(edge, edge, offset=offset, angles=[0.0, 5.0, 360.0 / TEETH])
    force = found.site_force_N
    atol = TRAVELLING * force.max()
    np.testing.assert_allclose(force[2], np.roll(force[0], -1), rtol=0, atol=atol)
    np.testing.assert_allclose(found.rotation_rad[2], found.rotation_rad[0], rtol=TRAVELLING)
    moment = force.sum(axis=1) * BASE_RADIUS
    np.testing.assert_allclose(moment, 1000 * TORQUE, rtol=3e-3)


def test_minimum_where_flanks_conform_less_is_no_contact_beside_the_one_where_they_do() -> None:
    """Under a large load the whole flank carries, with its sharp ends: every place once.

    The offset then changes the wind-up by the square of its ratio to the approach.
    """
    teeth = 15
    small = {"teeth": teeth, "module_mm": 1.0, "pressure_angle_deg": 30}
    shaft = {"tip_diameter_mm": teeth + 0.8, "root_diameter_mm": teeth - 1.4}
    hub = {"tip_diameter_mm": teeth - 0.9, "root_diameter_mm": teeth + 1.4}
    tree: dict[str, Any] = {
        "body_1": {"kind": "spline_shaft", **small, **shaft, "bore_diameter_mm": 6.0},
        "body_2": {
            "kind": "spline_hub", **small, **hub,
            "profile_shift": 0.0403, "outer_diameter_mm": teeth + 11.42,
        },
        "pair": {"face_width_mm": 6.1},
        "load": {"torque_Nm": 1000.0},
        "effects": {"beyond_limits": True},
        "accuracy": {"estimate": False, "tangents": False},
    }  # fmt: skip
    none = solve(fl.Scene.from_dict(tree))
    assert isinstance(none, fl.Result)
    offset_mm = 0.0045
    tree["pair"]["center_offset_mm"] = offset_mm
    tree["load"]["torque_Nm"] = [38.0, 39.0, 100.0, 1000.0]
    tree["positions"] = {"angles_deg": [0.0, 180 / teeth]}
    found = solve(fl.Scene.from_dict(tree))
    assert isinstance(found, tuple)
    for result in found:
        assert result.status.tolist() == [0, 0]
        for table in result.pair_tables:
            moment = table.x_mm * table.normal_y - table.y_mm * table.normal_x
            np.testing.assert_allclose(
                table.force_N @ moment, 1000 * result.torque_Nm, rtol=ROUND_OFF
            )
            for site in result.sites:
                rows = table.site == site
                along, cell = table.arc_length_1_mm[rows], table.cell_mm[rows]
                assert np.all(cell > 0)
                # the mean of both flanks' cells, of which that of the hub follows the circles
                np.testing.assert_allclose(np.diff(along), 0.5 * (cell[1:] + cell[:-1]), rtol=1e-3)
    most = found[-1]
    assert most.loaded_pairs.tolist() == [teeth, teeth]
    np.testing.assert_allclose(
        most.rotation_rad,
        none.rotation_rad[0],
        rtol=(1000 * offset_mm / none.transmission_error_um[0]) ** 2,
    )


def test_small_offset_is_none_in_the_limit() -> None:
    """For offsets that the load closes, the wind-up changes by their square or less."""
    none = solved().rotation_rad[0]
    for offset, least in ((1e-5, 1e-9), (1e-4, 1e-7), (1e-3, 1e-5)):
        found = solved(offset=offset, angles=[0.0]).rotation_rad[0]
        np.testing.assert_allclose(found, none, rtol=least)


def test_offset_loads_the_teeth_on_one_side() -> None:
    """The hub is displaced to positive x; flanks meet counter-clockwise, so teeth below it gain."""
    force = solved(offset=0.02, angles=[0.0]).site_force_N[0]
    angle = 2 * np.pi * np.arange(TEETH) / TEETH
    # the flank of tooth j has its normal about 90 degrees ahead of the tooth
    towards = np.cos(angle + np.pi / 2)
    assert force[towards < -0.7].min() > 0
    assert force[towards > 0.7].max() == 0


def test_index_errors_are_springs_of_different_length() -> None:
    """Uncoupled teeth: F_j = k (r_b phi + e_j), or 0 if that is negative.

    The hub is rigid and the bore just below the roots of the shaft. The spring k of a tooth is that
    of the spline without errors, whose teeth carry M/(z r_b) each at the rotation phi.
    """
    alone = {"bore_diameter_mm": 44.0}
    perfect = solved(alone, {"rigid": True})
    spring = perfect.site_force_N.mean() / (perfect.rotation_rad[0] * BASE_RADIUS)
    errors = np.random.default_rng(24).integers(-8, 9, TEETH)
    for torque, teeth in ((100.0, 1), (2000.0, 5), (40000.0, TEETH)):

        def forces(closed: float) -> np.ndarray:
            return spring * np.maximum(0.0, closed + errors / 1000)

        def lacking(closed: float, torque: float = torque) -> float:
            return float(forces(closed).sum() * BASE_RADIUS - 1000 * torque)

        closed = float(brentq(lacking, -1.0, 1.0, xtol=1e-14))
        expected = forces(closed)
        found = solved(
            {**alone, "pitch_errors_um": errors.tolist()}, {"rigid": True}, torque=torque
        )
        scale = expected.max()
        np.testing.assert_allclose(found.site_force_N[0], expected, rtol=0, atol=SPRINGS * scale)
        # the wind-up from where the highest tooth touches
        touch = errors.max() / 1000
        np.testing.assert_allclose(
            found.rotation_rad[0] * BASE_RADIUS + touch, closed + touch, rtol=2 * SPRINGS
        )
        assert found.loaded_pairs[0] >= teeth
        assert (expected > 0).sum() >= teeth


def test_errors_of_shaft_and_hub_add_up() -> None:
    errors = np.random.default_rng(7).integers(-5, 6, TEETH)
    one = solved({"pitch_errors_um": errors.tolist()})
    two = solved(None, {"pitch_errors_um": errors.tolist()})
    both = solved({"pitch_errors_um": errors.tolist()}, {"pitch_errors_um": (-errors).tolist()})
    atol = 1e-4 * one.site_force_N.max()
    np.testing.assert_allclose(one.site_force_N, two.site_force_N, rtol=0, atol=atol)
    np.testing.assert_allclose(both.site_force_N, both.site_force_N.mean(), rtol=1e-4)


def test_wind_up_converges_with_the_elements() -> None:
    angles = [solved(flank_element_mm=size, modes=5).rotation_rad[0] for size in (0.8, 0.4, 0.2)]
    first, second = np.abs(np.diff(angles)) / angles[-1]
    assert second < 3e-4
    assert second < 0.5 * first


def test_wind_up_and_edge_pressure_converge_with_the_cells() -> None:
    """Rounded edges have a largest pressure; sharp ones only a wind-up. Twelve teeth: few cells."""
    few = {"teeth": 12, "module_mm": 4.0, "tip_radius_mm": 0.4}
    shaft = {**few, "tip_diameter_mm": 51.2, "root_diameter_mm": 42.4}
    hub = {**few, "tip_diameter_mm": 44.4, "root_diameter_mm": 53.6}
    fine = solved(shaft, hub, strips_per_half_width=40)
    for strips, turn, peak in ((5, 2e-4, 0.2), (10, 5e-5, 0.1), (20, 5e-5, 0.05)):
        found = solved(shaft, hub, strips_per_half_width=strips)
        np.testing.assert_allclose(found.rotation_rad, fine.rotation_rad, rtol=turn)
        np.testing.assert_allclose(found.peak_pressure_MPa, fine.peak_pressure_MPa, rtol=peak)


def test_stiffer_bodies_wind_up_less() -> None:
    """The wind-up of two elastic bodies is about the sum of those with either body rigid."""
    both = solved().rotation_rad[0]
    shaft = solved(None, {"rigid": True}).rotation_rad[0]
    hub = solved({"rigid": True}).rotation_rad[0]
    assert max(shaft, hub) < both
    # the near field is not quite additive: each pressure settles with both bodies
    np.testing.assert_allclose(shaft + hub, both, rtol=0.03)


def test_rounding_that_lies_along_the_tip_circle_is_met_at_its_end() -> None:
    """A circle through its last place only touches it there."""
    both = {"teeth": 30, "module_mm": 4.0, "pressure_angle_deg": 20, "tip_radius_mm": 0.32}
    shaft = {"profile_shift": 0.15407405026629317, "bore_diameter_mm": 37.0}
    hub = {"profile_shift": 0.15932031707513017, "outer_diameter_mm": 236.0}
    found = solved(
        {
            **both,
            **shaft,
            "tip_diameter_mm": 123.50067579662468,
            "root_diameter_mm": 116.82636642923609,
        },
        {
            **both,
            **hub,
            "tip_diameter_mm": 118.42636642923608,
            "root_diameter_mm": 125.10067579662467,
        },
        torque=0.0,
        angles=np.linspace(0.0, 360.0, 100).tolist(),
    )
    np.testing.assert_allclose(found.transmission_error_um, 0.0, atol=5e-6)
