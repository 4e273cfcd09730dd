"""The sweep through the whole core: threads, periods, mirror, units, rigid bodies, counters."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

import flankload as fl
from tests.support.gear_pair import ONE, TWO, solved
from tests.support.tolerances import ROUND_OFF, SOLVER


@pytest.fixture(scope="module")
def plain() -> fl.Result:
    return solved()


def force_of(result: fl.Result, pair: int) -> np.ndarray:
    """Force of a pair at all positions, 0 where the result does not list it."""
    sites = result.sites.tolist()
    if pair not in sites:
        return np.zeros(len(result.position_rad))
    return result.site_force_N[:, sites.index(pair)]


def test_one_finite_element_job_a_body_whatever_the_positions() -> None:
    for count in (1, 16):
        cost = solved(positions={"count": count}, by=fl.solve).cost
        assert cost["fe_factorisations"] == 2
        assert cost["unit_loads_normal"] == 10
        assert cost["unit_loads_tangential"] == 0
        assert cost["influence_columns"] >= 40 * count


def test_rigid_body_costs_no_finite_elements(plain: fl.Result) -> None:
    """With a rigid mate, one factorisation is needed, and the pair is stiffer."""
    found = solved(two={"rigid": True}, by=fl.solve)
    assert found.cost["fe_factorisations"] == 1
    assert found.cost["unit_loads_normal"] == 5
    assert (found.rotation_rad < plain.rotation_rad).all()
    swapped = solved(one={"rigid": True})
    single = (found.site_force_N > 0).sum(axis=1) == 1
    single &= (swapped.site_force_N > 0).sum(axis=1) == 1
    single &= (plain.site_force_N > 0).sum(axis=1) == 1
    assert single.any()
    # one pair alone: compliances of both bodies add, but for the logarithm's half-width
    both = found.rotation_rad[single] + swapped.rotation_rad[single]
    np.testing.assert_allclose(both, plain.rotation_rad[single], rtol=0.05)


def test_answers_are_bitwise_the_same_with_any_number_of_threads() -> None:
    """Regression: a BLAS without locks gave wrong answers with two threads.

    The BLAS of numpy and scipy keeps one thread: their sums depend on the number.
    """
    program = (
        "import sys\n"
        "from tests.support.gear_pair import solved\n"
        "for _ in range(int(sys.argv[1])):\n"
        "    r = solved(positions={'count': 200})\n"
        "    sys.stdout.write(r.rotation_rad.tobytes().hex() + r.site_force_N.tobytes().hex())\n"
    )
    outputs = [
        subprocess.run(
            [sys.executable, "-c", program, times],
            env={**os.environ, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": "1"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads, times in (("1", "1"), ("4", "3"))
    ]
    assert outputs[1] == 3 * outputs[0]


def test_without_torque_nothing_deforms_and_no_elements_are_solved() -> None:
    found = solved(load={"torque_Nm": 0}, accuracy={})
    assert found.cost["fe_factorisations"] == 0
    assert found.cost["influence_columns"] == 0
    assert found.estimate is None
    np.testing.assert_allclose(found.transmission_error_um, 0.0, rtol=0, atol=1e-6)
    torques = {"torque_Nm": [0, 302]}
    unloaded, loaded = solved(load=torques, positions={"count": 4}, by=fl.solve).by_torque
    assert loaded.cost["fe_factorisations"] == 2
    assert not unloaded.site_force_N.any()


def test_curve_closes_and_pairs_move_up_by_one_after_a_period(plain: fl.Result) -> None:
    pitch = 360 / 16
    angles = [2.0, 9.0, 17.0]
    first, second = (
        solved(positions={"angles_deg": [angle + turn for angle in angles]})
        for turn in (0.0, pitch)
    )
    np.testing.assert_allclose(second.rotation_rad, first.rotation_rad, rtol=1e-8)
    scale = first.site_force_N.max()
    for pair in (-1, 0, 1):
        np.testing.assert_allclose(
            force_of(second, pair - 1), force_of(first, pair), rtol=0, atol=1e-7 * scale
        )


def test_far_and_backward_positions_are_positions_like_any_other() -> None:
    near, far, back = (
        solved(positions={"angles_deg": [9.0 + 22.5 * pitches]}) for pitches in (0, 7, -9)
    )
    for other, pitches in ((far, 7), (back, -9)):
        assert other.rotation_rad[0] == pytest.approx(near.rotation_rad[0], rel=1e-8)
        assert force_of(other, -pitches)[0] == pytest.approx(force_of(near, 0)[0], rel=1e-6)


def test_no_position_loses_a_pair() -> None:
    """Regression: circles through the end of a flank missed it by rounding and lost its pair.

    Over a dense sweep the rotation has kinks where tips meet flanks, but no jump.
    """
    rotation = solved(positions={"count": 3000}).rotation_rad
    steps = np.abs(np.diff(np.append(rotation, rotation[0])))
    assert steps.max() < 0.004 * rotation.mean()


@pytest.mark.parametrize(
    "tip",
    [{"tip_radius_mm": 0.4}, {"tip_chamfer_mm": 0.4}, {"tip_radius_mm": 0.05}],
    ids=["radius", "chamfer", "small radius"],
)
def test_rounded_and_chamfered_tips_keep_the_middle_of_the_path(
    plain: fl.Result, tip: dict
) -> None:
    """Regression: modes over the rounding made the flank 10 % too stiff, and pairs were lost."""
    found = solved(one=tip, two=tip)
    middle = [0, 1, 2, 7, 8, 9, 14, 15]
    np.testing.assert_allclose(found.rotation_rad[middle], plain.rotation_rad[middle], rtol=1.5e-3)
    dense = solved(one=tip, two=tip, positions={"count": 600}, load={"torque_Nm": 0})
    np.testing.assert_allclose(dense.transmission_error_um, 0.0, rtol=0, atol=1e-6)


def test_relieved_flank_leaves_its_deviation_unloaded() -> None:
    """Unloaded, a pinion relieved linearly lags by no more than the relief, and never leads."""
    relief = {"tip_relief_um": 35, "tip_relief_start_diameter_mm": 79}
    found = solved(one=relief, load={"torque_Nm": 0}, positions={"count": 64})
    assert (found.transmission_error_um > -1e-6).all()
    assert found.transmission_error_um.max() < 35
    assert (found.transmission_error_um < 1e-6).sum() >= 32


def test_pitch_error_shifts_the_load_to_the_early_tooth(plain: fl.Result) -> None:
    """Pair -1 is the tooth that follows pair 0; 10 um early, it takes more of the load."""
    errors = [0.0] * 16
    errors[1] = 10.0
    found = solved(one={"pitch_errors_um": errors})
    both = (force_of(plain, -1) > 0) & (force_of(plain, 0) > 0)
    assert (force_of(found, -1)[both] > 1.1 * force_of(plain, -1)[both]).all()
    beyond = {"beyond_limits": True}  # without load the early tooth takes up the backlash
    unloaded = solved(one={"pitch_errors_um": errors}, load={"torque_Nm": 0}, effects=beyond)
    assert unloaded.transmission_error_um.min() == pytest.approx(-10.0, abs=0.05)
    assert found.summary["transmission_error_harmonics_um"] is None


def test_equal_pitch_error_on_all_teeth_is_a_turn() -> None:
    """The bodies touch 7 um earlier; only mean normals at corners (2e-4 rad apart) see more.

    By half of that forces turn further: 5e-4 um at the corner, by 0.2 um for 0.034 rad.
    """
    errors = {"pitch_errors_um": [7.0] * 16}
    shifted, straight = (solved(one=keys, positions={"count": 4}) for keys in (errors, {}))
    turned = np.asarray(straight.corner_contact).any(axis=1)
    apart = np.abs(straight.transmission_error_um - shifted.transmission_error_um - 7.0)
    assert apart[~turned].max() < 2e-3
    assert apart[turned].max() < 2.5e-3


def test_mirrored_driver_and_driven_agree_along_the_line_of_action(plain: fl.Result) -> None:
    """The wheel as body 1 with the same tooth force: the same approach of the two bodies.

    The pairs are on circles about the other axis, which leaves an error of up to 1e-3.
    """
    swapped = fl.solve(
        fl.Scene.from_dict(
            {
                "body_1": TWO,
                "body_2": ONE,
                "pair": {"center_distance_mm": 91.5, "face_width_mm": 14},
                "load": {"torque_Nm": 302 * 24 / 16},
                "positions": {"count": 16},
                "accuracy": {"estimate": False, "tangents": False},
            }
        )
    )
    # position zero is the pitch point in both, and turning runs the other way along the flanks
    assert swapped.transmission_error_um[0] == pytest.approx(
        plain.transmission_error_um[0], rel=1e-3
    )
    backwards = -np.arange(16) % 16
    smooth = ~plain.corner_contact.any(axis=1) & ~swapped.corner_contact[backwards].any(axis=1)
    assert smooth.sum() >= 10
    np.testing.assert_allclose(
        swapped.transmission_error_um[backwards][smooth],
        plain.transmission_error_um[smooth],
        rtol=2e-3,
    )


def test_stiffness_tangent_is_the_slope_of_torque_over_rotation() -> None:
    step = 1e-3
    torques = [302 * (1 - step), 302.0, 302 * (1 + step)]
    below, at, above = solved(
        load={"torque_Nm": torques}, positions={"count": 4}, accuracy={"estimate": False}
    )
    slope = (torques[2] - torques[0]) / (above.rotation_rad - below.rotation_rad)
    # the cells are laid for each torque anew: their own error differs a little
    np.testing.assert_allclose(at.stiffness_tangent_Nm_per_rad, slope, rtol=2e-2)


def test_face_width_and_torque_together_change_nothing(plain: fl.Result) -> None:
    """Twice the width and twice the torque: the same plane problem."""
    found = solved(pair={"center_distance_mm": 91.5, "face_width_mm": 28}, load={"torque_Nm": 604})
    np.testing.assert_allclose(found.rotation_rad, plain.rotation_rad, rtol=SOLVER)
    np.testing.assert_allclose(found.peak_pressure_MPa, plain.peak_pressure_MPa, rtol=1e-6)


def test_stiffer_material_scales_the_rotation() -> None:
    """Twice the modulus and twice the torque: the same deformations, twice the pressure."""
    stiff = {"young_modulus_MPa": 412000}
    found = solved(one=stiff, two=stiff, load={"torque_Nm": 604}, positions={"count": 4})
    plain = solved(positions={"count": 4})
    np.testing.assert_allclose(found.rotation_rad, plain.rotation_rad, rtol=1e-8)
    np.testing.assert_allclose(found.peak_pressure_MPa, 2 * plain.peak_pressure_MPa, rtol=1e-6)


def test_plane_stress_is_softer() -> None:
    """The reduced modulus alone gives 1/(1 - nu²) = 10 %; measured 6 … 9 % in the rotation."""
    strain, stress = (
        solved(
            accuracy={"plane": plane, "estimate": False, "tangents": False}, positions={"count": 4}
        )
        for plane in ("strain", "stress")
    )
    ratio = stress.rotation_rad / strain.rotation_rad
    assert (ratio > 1.05).all()
    assert (ratio < 1 / (1 - 0.3**2) + 1e-9).all()


def test_torque_is_held_by_the_forces_of_every_position(plain: fl.Result) -> None:
    for k in range(len(plain.position_rad)):
        pairs = plain.pairs(k)
        moment = pairs.force_N @ (pairs.x_mm * pairs.normal_y - pairs.y_mm * pairs.normal_x)
        assert moment == pytest.approx(302e3, rel=1e-10)
        assert (pairs.force_N >= 0).all()
        assert (pairs.gap_um >= -1e-9).all()
        assert np.abs(pairs.gap_um[pairs.force_N > 0]).max() < 1e-9


@pytest.mark.parametrize("torque", [1e-6, 1e-2, 3020.0])
def test_torques_far_from_nominal_are_solved(torque: float) -> None:
    found = solved(load={"torque_Nm": torque}, positions={"count": 8})
    assert (found.status >= 0).all()
    force = found.site_force_N.sum(axis=1)
    np.testing.assert_allclose(force, 1000 * torque / 33.829, rtol=3e-2)
    assert found.cost["largest_backward_error"] < 10 * ROUND_OFF
