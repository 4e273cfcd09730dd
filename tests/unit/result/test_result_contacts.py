"""Contacts of a result by closed formulas: half-width, sliding, coast flanks, pairs, stiffness."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from math import cos, pi, sqrt, tan

import numpy as np
import pytest

import flankload as fl
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.pairing.body_pair import BodyPair
from flankload.result import Result, results_to_csv, stiffness_table
from flankload.result.flank_contact import loaded_length
from tests.support.made_up_result import made_up_result
from tests.support.pair_scenes import EXTERNAL, PINION, RING_PAIR, SPLINE, solved
from tests.support.tolerances import ROUND_OFF, RUBBING, SOLVER, SPEED_MM

#: Half-width of a contact against Hertz: a tenth of a cell, ten of which lie on it.
HALF_WIDTH = 1e-2
#: Peak pressure against Hertz, with ten cells.
PRESSURE = 5e-3
#: Curves of flanks are within 1e-9 mm of the involute, on both bodies and both sides.
CURVES_UM = 1e-5
#: Velocities per rad at a hundredth of the nominal load, against the point of contact without load.
CENTRE_MM = 1e-3


@pytest.fixture(scope="module")
def external() -> Result:
    return solved(EXTERNAL, 302.0, count=16)


def along_path_mm(result: Result, base_pitch: float) -> np.ndarray:
    """Distance (P, S) of the point of contact from the pitch point without load."""
    place = result.sites + result.position_rad[:, None] / result.period_rad
    return np.asarray(place * base_pitch)


# --- half-width -----------------------------------------------------------------------------------
def test_loaded_length_of_a_linear_square_of_pressure_is_exact() -> None:
    # p² falls to 0 in a straight line at s = 4.3 and -4.3
    s = np.arange(-6.0, 7.0)
    force = np.sqrt(np.maximum(0.0, 4.3 - np.abs(s)))
    assert loaded_length(s, np.ones(13), force) == pytest.approx(8.6, rel=ROUND_OFF)
    # in whatever order the cells come
    order = np.random.default_rng(3).permutation(13)
    assert loaded_length(s[order], np.ones(13), force[order]) == pytest.approx(8.6, rel=ROUND_OFF)


def test_loaded_length_sums_stretches_and_ends_with_a_cell_where_pressure_rises() -> None:
    s = np.arange(8.0)
    force = np.array([9.0, 5.0, 5.0, 9.0, 0.0, 0.0, 7.0, 0.0])
    assert loaded_length(s, np.ones(8), force) == pytest.approx(4.0 + 1.0, rel=ROUND_OFF)


def test_half_width_is_that_of_hertz(external: Result) -> None:
    mesh = build_pair(EXTERNAL).pairing.gear_geometry
    assert mesh is not None
    g = along_path_mm(external, mesh.base_pitch_mm)
    legs = [r * np.sin(mesh.pressure_angle_rad) for r in
            (mesh.pitch_radius_1_mm, mesh.pitch_radius_2_mm)]  # fmt: skip
    radius = 1 / (1 / (legs[0] + g) + 1 / (legs[1] - g))
    c = 2 * 2 * (1 - 0.3**2) / (pi * 206000)
    expected = np.sqrt(2 * radius * external.line_load_N_per_mm * c)
    # a contact that reaches its flank's end is no Hertz contact
    inside = (
        (external.site_force_N > 0) & (g > mesh.path_start_mm + 1.0) & (g < mesh.path_end_mm - 1.0)
    )
    assert inside.any(axis=1).all()
    np.testing.assert_allclose(
        external.contact_half_width_mm[inside], expected[inside], rtol=HALF_WIDTH, atol=0
    )
    pressure = 2 * external.line_load_N_per_mm[inside] / (pi * expected[inside])
    np.testing.assert_allclose(external.peak_pressure_MPa[inside], pressure, rtol=PRESSURE, atol=0)


def test_open_pairs_have_no_width_and_do_not_slide(external: Result) -> None:
    closed = external.site_force_N > 0
    assert not closed.all()
    for key in ("contact_half_width_mm", "sliding_mm_per_rad", "specific_sliding_1"):
        assert (np.isfinite(getattr(external, key)) == closed).all()


# --- sliding --------------------------------------------------------------------------------------
def build_pair(pair: dict) -> BodyPair:
    return build_bodies(fl.Scene.from_dict({**pair, "load": {"torque_Nm": 0.0}}))


@pytest.mark.parametrize(
    ("pair", "ratio"), [(EXTERNAL, 16 / 24), (RING_PAIR, -24 / 60)], ids=["external", "internal"]
)
def test_sliding_grows_with_the_distance_from_the_pitch_point(pair: dict, ratio: float) -> None:
    """(v_2 - v_1)·t_1 = (1 + z_1/z_2) g per rad of body 1; the ring turns the same way."""
    result, mesh = solved(pair, 3.0), build_pair(pair).pairing.gear_geometry
    assert mesh is not None
    g = along_path_mm(result, mesh.base_pitch_mm)
    inside = (g > mesh.path_start_mm + 1.0) & (g < mesh.path_end_mm - 1.0)
    inside &= result.site_force_N > 0
    assert inside.sum() >= result.position_rad.size
    np.testing.assert_allclose(
        result.sliding_mm_per_rad[inside], (1 + ratio) * g[inside], rtol=0, atol=CENTRE_MM
    )
    # along the flank body 1 moves as a wheel that rolls, with the distance to its base tangent
    one = mesh.pitch_radius_1_mm * np.sin(mesh.pressure_angle_rad) + g[inside]
    two = one - (1 + ratio) * g[inside]
    for own, other, found in (
        (one, two, result.specific_sliding_1),
        (two, one, result.specific_sliding_2),
    ):
        error = np.abs(found[inside] - (1 - other / own))
        # of first order in errors of both velocities
        assert (error <= SPEED_MM * (own + other) / own**2).all()


@pytest.mark.parametrize(("driver", "sense"), [("body_1", 1.0), ("body_2", -1.0)])
def test_sliding_is_that_of_the_pairs_under_friction(driver: str, sense: float) -> None:
    """Their mean by force; the sense of motion is that of the driver there."""
    positions = {"count": 8, "driver": driver}
    rubbed = solved(EXTERNAL, 30.0, positions=positions, effects={"friction_coefficient": 0.05})
    for p in range(8):
        table = rubbed.pairs(p)
        assert table.sliding_mm_per_rad is not None
        for s, site in enumerate(rubbed.sites):
            own = (table.site == site) & (table.force_N > 0)
            if rubbed.corner_contact[p, s] or not own.any():
                continue
            force = table.force_N[own]
            mean = sense * (force @ table.sliding_mm_per_rad[own]) / force.sum()
            found = rubbed.sliding_mm_per_rad[p, s]
            assert mean == pytest.approx(found, rel=RUBBING, abs=RUBBING)


def test_a_spline_on_common_axes_does_not_slide() -> None:
    result = solved(SPLINE, 50.0)
    sliding = result.sliding_mm_per_rad[result.site_force_N > 0]
    np.testing.assert_allclose(sliding, 0.0, rtol=0, atol=30 * ROUND_OFF)


# --- coast flanks ---------------------------------------------------------------------------------
@pytest.mark.parametrize("pair", [EXTERNAL, RING_PAIR], ids=["external", "internal"])
def test_coast_flanks_without_load_leave_the_normal_backlash(pair: dict) -> None:
    mesh = build_pair(pair).pairing.gear_geometry
    assert mesh is not None
    expected = 1000 * mesh.backlash_mm * cos(mesh.pressure_angle_rad)
    gap = solved(pair, 0.0, rigid=True).coast_flank_gap_um
    np.testing.assert_allclose(gap, expected, rtol=0, atol=CURVES_UM)


def test_coast_flanks_of_a_pair_further_apart() -> None:
    """Normal backlash from the centre distance alone: 2 r_b (inv a - inv a_0), both bodies."""
    pair = {**EXTERNAL, "pair": {"center_distance_mm": 91.7, "face_width_mm": 14.0}}
    bases = 4.5 * 20 * cos(pi / 9)

    def involute(distance: float) -> float:
        roll = sqrt((distance / bases) ** 2 - 1)
        return roll - np.arctan(roll)

    nearer = solved(EXTERNAL, 0.0, rigid=True, count=4).coast_flank_gap_um
    further = solved(pair, 0.0, rigid=True, count=4).coast_flank_gap_um
    assert nearer is not None
    assert further is not None
    expected = 2000 * bases * (involute(91.7) - involute(91.5))
    np.testing.assert_allclose(further - nearer, expected, rtol=0, atol=CURVES_UM)


def test_coast_gap_at_angles_many_turns_apart() -> None:
    """Regression: all coast flanks between the angles were checked, which exhausted the memory."""
    pitch = 360.0 / EXTERNAL["body_1"]["teeth"]
    angles = {"angles_deg": [5.0, 5.0 + 4e5 * pitch, 5.0 - 2e4 * pitch]}
    gap = solved(EXTERNAL, 0.0, rigid=True, positions=angles).coast_flank_gap_um
    # 1.6e5 rad are rounded to 3e-11 rad, 1e-6 um
    np.testing.assert_allclose(gap, gap[0], rtol=0, atol=CURVES_UM)


def test_coast_flanks_move_apart_by_the_transmission_error(external: Result) -> None:
    unloaded = solved(EXTERNAL, 0.0, rigid=True, count=1).coast_flank_gap_um
    assert unloaded is not None
    np.testing.assert_allclose(
        external.coast_flank_gap_um - external.transmission_error_um,
        np.full(16, unloaded[0]),
        rtol=0,
        atol=CURVES_UM,
    )


def test_coast_flanks_of_a_spline_leave_its_backlash() -> None:
    gap = solved(SPLINE, 0.0, rigid=True).coast_flank_gap_um
    # the shaft's tooth is thinner by 2 * 0.05 modules * 2 tan(30 deg) on the pitch circle
    expected = 1000 * 2 * 0.05 * 2.0 * tan(pi / 6) * cos(pi / 6)
    np.testing.assert_allclose(gap, expected, rtol=0, atol=CURVES_UM)


def test_pitch_errors_leave_coast_flanks_where_they_are() -> None:
    plain = solved(EXTERNAL, 0.0, rigid=True, count=1)
    early = {**EXTERNAL, "body_1": {**PINION, "pitch_errors_um": [7.0] + [0.0] * 15}}
    moved = solved(early, 0.0, rigid=True, count=1, effects={"beyond_limits": True})
    assert plain.coast_flank_gap_um is not None
    assert moved.coast_flank_gap_um is not None
    # metal that touches 7 um early turns body 1 back by as much
    difference = plain.coast_flank_gap_um - moved.coast_flank_gap_um
    np.testing.assert_allclose(difference, 7.0, rtol=0, atol=CURVES_UM)


def test_without_profile_the_coast_flanks_are_not_known(external: Result) -> None:
    pair = build_pair(EXTERNAL)
    pair = replace(pair, position_rad=external.position_rad)
    unknown = replace(pair, bodies=(pair.body_1, replace(pair.body_2, involute=None)))
    from flankload.elasticity.compliance import no_compliance
    from flankload.result.geometry import pair_geometry

    rigid = (no_compliance(unknown.body_1), no_compliance(unknown.body_2))
    geometry = pair_geometry(unknown, rigid)
    assert geometry.coast is None
    result = replace(external, geometry=geometry)
    assert result.coast_flank_gap_um is None
    assert json.loads(result.to_json())["coast_flank_gap_um"] is None
    row = next(csv.DictReader(io.StringIO(result.to_csv())))
    assert row["coast_flank_gap_um"] == ""
    assert "coast flanks        unknown: body_2 has no known coast flank" in (result.table())


# --- pairs, contact ratio -------------------------------------------------------------------------
def test_pairs_that_could_carry_are_those_on_the_path_and_those_that_do(external: Result) -> None:
    mesh = build_pair(EXTERNAL).pairing.gear_geometry
    assert mesh is not None
    g = along_path_mm(external, mesh.base_pitch_mm)
    on_path = ((g >= mesh.path_start_mm) & (g <= mesh.path_end_mm)).sum(axis=1)
    assert (external.potential_pairs >= np.maximum(on_path, external.loaded_pairs)).all()
    assert (external.potential_pairs <= on_path + 1).all()
    assert external.summary["contact_ratio_geometric"] == mesh.contact_ratio
    # load makes the contact longer than geometry has it
    assert external.summary["contact_ratio_under_load"] > mesh.contact_ratio
    text = external.table()
    assert f", {mesh.contact_ratio:.3f} by geometry)" in text
    assert external.summary["contact_ratio_usable"] == pytest.approx(mesh.contact_ratio, rel=SOLVER)


def test_contact_ratio_on_both_involutes_is_shown_if_it_differs(external: Result) -> None:
    """An undercut may reduce the 1.787 of the tip circles to less than one pair."""
    geometry = replace(external.geometry, contact_ratio=1.787, usable_contact_ratio=0.835)
    result = replace(external, geometry=geometry)
    assert ", 1.787 by geometry, 0.835 of it on both involutes)" in result.table()
    summary = json.loads(result.to_json())["summary"]
    assert (summary["contact_ratio_geometric"], summary["contact_ratio_usable"]) == (1.787, 0.835)


def test_line_load_is_force_over_width(external: Result) -> None:
    np.testing.assert_allclose(
        external.line_load_N_per_mm, external.site_force_N / 14.0, rtol=ROUND_OFF, atol=0
    )
    summary = external.summary
    p = int(np.flatnonzero(external.position_rad == summary["peak_line_load_position_rad"])[0])
    s = int(np.flatnonzero(external.sites == summary["peak_line_load_pair"])[0])
    assert summary["peak_line_load_N_per_mm"] == external.line_load_N_per_mm[p, s]
    assert summary["peak_line_load_N_per_mm"] == external.line_load_N_per_mm.max()
    # alone, a pair carries the torque over the base radius
    assert external.line_load_N_per_mm.max() == pytest.approx(
        1000 * 302 / external.reference_radius_mm / 14.0, rel=1e-4
    )


# --- stiffness ------------------------------------------------------------------------------------
def test_stiffness_means_are_those_of_the_curves(external: Result) -> None:
    assert external.summary["stiffness_tangent_mean_N_per_um"] == pytest.approx(
        external.stiffness_tangent_N_per_um.mean(), rel=SOLVER
    )
    assert external.summary["stiffness_secant_mean_Nm_per_rad"] == pytest.approx(
        external.stiffness_secant_Nm_per_rad.mean(), rel=SOLVER
    )
    assert "N/um tangent" in external.table()


def test_stiffness_is_not_averaged_over_open_curves_or_without_torque() -> None:
    key = "stiffness_secant_mean_N_per_um"
    assert made_up_result(count=3, closed=False).summary[key] is None
    assert made_up_result(torque_Nm=0.0).summary[key] is None


def test_secant_stiffness_is_not_claimed_where_body_1_lags_behind() -> None:
    turned = np.linspace(-1e-4, 1e-3, 32)
    secant = made_up_result(rotation_rad=turned).stiffness_secant_Nm_per_rad
    assert (np.isnan(secant) == (turned <= 0)).all()


def test_secant_stiffness_of_made_up_deflections_is_exact() -> None:
    """10 mrad with errors that leave 8 of them before there is torque."""
    unloaded = np.linspace(-2e-3, 8e-3, 32)
    deflection = np.full(32, 2e-3)
    found = made_up_result(
        torque_Nm=100.0, rotation_rad=unloaded + deflection, unloaded_rotation_rad=unloaded
    )
    np.testing.assert_allclose(found.stiffness_secant_Nm_per_rad, 5e4, rtol=SOLVER, atol=0)
    mean_um = 2.0 * found.reference_radius_mm
    assert found.summary["transmission_error_by_load_mean_um"] == pytest.approx(mean_um, rel=SOLVER)
    assert f"({mean_um:.3f} um beyond the state without load), peak" in found.table()
    rows = list(csv.DictReader(io.StringIO(found.to_csv())))
    assert float(rows[0]["unloaded_transmission_error_um"]) == pytest.approx(
        -2.0 * found.reference_radius_mm, rel=SOLVER
    )
    assert json.loads(found.to_json())["unloaded_transmission_error_um"] == pytest.approx(
        list(found.unloaded_transmission_error_um), rel=SOLVER
    )


def test_pressures_that_are_all_on_corners_have_no_estimate_of_none() -> None:
    """Regression: the estimate was 0 %."""
    plain = made_up_result()
    corners = replace(plain, corner_contact=np.ones_like(plain.corner_contact))
    text = "peak pressure not estimated (sharp corners)"
    assert text in corners.table()
    assert text not in plain.table()


def test_stiffness_table_closes_over_the_period_and_reads_back() -> None:
    results = [made_up_result(torque_Nm=torque, count=8) for torque in (0.0, 100.0, 302.0)]
    table = stiffness_table(results)
    assert table.closed
    assert table.angle_rad.size == 9
    assert table.angle_rad[-1] == table.angle_rad[0] + results[0].period_rad
    lines = table.to_csv().splitlines()
    comments = [line for line in lines if line.startswith("#")]
    assert comments[0] == "# made-up pair"
    assert "closed" in comments[1]
    rows = list(csv.DictReader(lines[len(comments) :]))
    assert len(rows) == 9
    for result in results:
        for key, values in table.values.items():
            found = [row[f"{key}@{result.torque_Nm:.12g}"] for row in rows]
            expected = getattr(result, key)
            for n, text in enumerate(found):
                value = expected[n % 8]
                assert text == (repr(float(value)) if np.isfinite(value) else "")
            t = results.index(result)
            np.testing.assert_array_equal(values[:-1, t], expected)
    assert rows[0]["stiffness_secant_N_per_um@0"] == ""


def test_stiffness_table_of_open_positions_ascends_and_does_not_close() -> None:
    given = made_up_result(count=3, position_rad=[0.2, 0.0, 0.1], closed=False)
    table = given.stiffness_table()
    assert not table.closed
    assert table.angle_rad.tolist() == [0.0, 0.1, 0.2]
    expected = given.transmission_error_um[[1, 2, 0]]
    np.testing.assert_array_equal(table.values["transmission_error_um"][:, 0], expected)
    assert "(open)" in table.to_csv()


def test_stiffness_table_of_uneven_positions_that_cover_the_period_closes() -> None:
    even = made_up_result(count=12)
    order = [3, 4, 6, 7, 8, 9, 10, 11, 0, 1, 2]
    keys = ("position_rad", "rotation_rad", "stiffness_tangent_Nm_per_rad")
    changes = {key: getattr(even, key)[order] for key in keys}
    table = made_up_result(count=11, closed=False, **changes).stiffness_table()
    assert table.closed
    assert (np.diff(table.angle_rad) > 0).all()
    assert table.angle_rad[-1] == table.angle_rad[0] + even.period_rad
    expected = even.transmission_error_um[sorted(order)]
    np.testing.assert_array_equal(table.values["transmission_error_um"][:-1, 0], expected)


def test_one_position_of_a_spline_on_common_axes_is_a_whole_period() -> None:
    result = solved(SPLINE, 50.0)
    table = result.stiffness_table()
    assert table.closed
    assert table.angle_rad.tolist() == [0.0, result.period_rad]
    assert result.summary["stiffness_tangent_mean_Nm_per_rad"] == pytest.approx(
        float(result.stiffness_tangent_Nm_per_rad[0]), rel=ROUND_OFF
    )


def test_results_at_different_positions_make_no_table() -> None:
    with pytest.raises(ValueError, match="different positions"):
        stiffness_table([made_up_result(count=8), made_up_result(count=9)])


# --- files ----------------------------------------------------------------------------------------
def test_csv_of_a_pair_that_another_torque_alone_loads_is_open_there() -> None:
    results = (made_up_result(), made_up_result(sites=[-1, 0, 2]))
    rows = list(csv.DictReader(io.StringIO(results_to_csv(results))))
    assert rows[0]["site_force_N_pair_2"] == "0"
    assert rows[0]["contact_half_width_mm_pair_2"] == ""
    assert rows[0]["sliding_mm_per_rad_pair_2"] == ""


def test_results_without_geometry_say_nothing_of_motion() -> None:
    result = made_up_result()
    assert result.coast_flank_gap_um is None
    assert np.isnan(result.sliding_mm_per_rad).all()
    assert "coast flanks" not in result.table()
