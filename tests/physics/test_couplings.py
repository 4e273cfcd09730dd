"""Splines in three dimensions: crowned and misaligned couplings beside plane pairs and cells."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import flankload as fl
import flankload.pairing.common_height as common
from flankload.base.rotation import turned
from flankload.contact import solve_contact_general
from flankload.contact.conforming import reduced_compliance
from flankload.contact.core_call import CORE_COUNTERS
from flankload.contact.pair_table import COLUMNS
from flankload.contact.sweep import sweep
from flankload.elasticity.compliance.body_compliance import no_compliance
from flankload.elasticity.prism.strip_field import StripField, mean_potential, strip_distances
from flankload.errors import InputError
from flankload.mechanisms.elements import compliance_of
from flankload.mechanisms.flank_pair.assembly import build_bodies
from flankload.mechanisms.flank_pair.stages import contact_of
from tests.support.couplings import (
    CROWNED,
    EQUAL,
    MISALIGNED,
    TEETH,
    TORQUE_NMM,
    plane,
    scene,
    solve,
)
from tests.support.three_dimensional import deviation, tree_of
from tests.support.tolerances import SOLVER

# --- plane pairs ----------------------------------------------------------------------------------


def test_a_wide_coupling_is_that_of_plane_cells() -> None:
    """Rotation of the resolved contact in plane strain, from above: the ends are more compliant."""
    rigid = {"body_2__rigid": True}
    ratios, wanted = [], float(plane(**rigid).rotation_rad[0])
    for times, degree in ((1.0, 6), (6.0, 10)):
        wide = {f"body_{z}__face_width_mm": 16.0 * times for z in (1, 2)}
        found = solve(
            **rigid,
            **wide,
            load__torque_Nm=600.0 * times,
            accuracy__axial_degree=degree,
        )
        ratios.append(float(found.rotation_rad[0]) / wanted)
        np.testing.assert_allclose(found.load_share, 1.0 / TEETH, rtol=SOLVER)
    assert 1.01 > ratios[0] > ratios[1] > 1.0
    assert ratios[1] < 1.003


def test_pitch_errors_share_the_load_as_in_the_plane() -> None:
    errors = np.round(5.0 * np.sin(1.7 * np.arange(TEETH)), 2).tolist()
    one, two = (make(body_1__pitch_errors_um=errors) for make in (solve, plane))
    np.testing.assert_allclose(one.load_share, two.load_share, atol=6e-3)
    assert two.load_share.max() > 2.0 / TEETH
    none = (make().rotation_rad[0] for make in (solve, plane))
    wind_up = [
        float(found.rotation_rad[0] / even) for found, even in zip((one, two), none, strict=True)
    ]
    assert wind_up[0] == pytest.approx(wind_up[1], abs=0.02)


# --- cells ----------------------------------------------------------------------------------------


def test_one_unknown_per_slice_beside_strips_of_the_height(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rotation within 0.4 % of the wind-up, shares 0.6 points, the largest line load 1 %."""
    monkeypatch.setattr(common, "STRIPS", 6)
    keys = {"accuracy__slices": 6, **CROWNED, **MISALIGNED}
    own = scene(**keys)
    pair = build_bodies(own)
    compliances = (compliance_of(pair.body_1, own), compliance_of(pair.body_2, own))
    contact = contact_of(own, pair, compliances)
    (found,) = sweep(contact, pair.position_rad, [TORQUE_NMM])
    matrix, gaps = _of_strips(pair, compliances)
    base_mm = pair.body_1.base_radius_mm
    levers = np.full(gaps.size, base_mm)
    state = solve_contact_general(matrix, gaps.ravel(), levers, TORQUE_NMM)
    force = state.normal_forces.reshape(gaps.shape).sum(axis=2)
    assert found.slices is not None
    wind_up = state.rotation - gaps.min() / base_mm
    assert abs(found.rotation_rad[0] - state.rotation) < 4e-3 * wind_up
    total = force.sum()
    np.testing.assert_allclose(found.site_force_N[0] / total, force.sum(1) / total, atol=6e-3)
    assert found.slices.force_N[0].max() == pytest.approx(force.max(), rel=1e-2)


def gap_by_axes(pair: Any, normal: np.ndarray, turn_rad: np.ndarray) -> np.ndarray:
    """Gap (S, J) by offset and tilt of the hub's axis, along a normal of the shaft in its frame.

    A rotation vector w of the hub moves the section at z, like its axis, by z (w_y, -w_x); the gap
    is the component along the normal. `turn_rad` (S,): angles of the teeth of the shaft in space.
    """
    height = pair.slices.conforming
    axis = np.outer(pair.slices.z_mm - height.middle_z_mm, height.tilt)
    axis[:, 0] += pair.pairing.center_distance_mm
    return np.asarray(turned(normal, turn_rad) @ axis.T)


def test_the_core_solves_the_equations_of_the_slices() -> None:
    """(S6) at each position, for offset and misaligned axes, crowned teeth and pitch errors."""
    errors = np.round(5.0 * np.sin(1.7 * np.arange(TEETH)), 2).tolist()
    keys = {"accuracy__slices": 6, "body_1__pitch_errors_um": errors, **CROWNED, **MISALIGNED}
    own = scene(**keys, pair__center_offset_mm=0.01, positions__angles_deg=[0.0, 5.0])
    pair = build_bodies(own)
    contact = contact_of(own, pair, (compliance_of(pair.body_1, own), no_compliance(pair.body_2)))
    none, found = sweep(contact, pair.position_rad, [0.0, TORQUE_NMM])
    spread, compliance = reduced_compliance(pair, contact.compliances)
    slices, base_mm, site_angles = pair.slices, pair.body_1.base_radius_mm, pair.pairing
    assert slices.conforming is not None
    assert base_mm is not None
    one, two = site_angles.site_angles_rad
    alone = base_mm * (two - one)[:, None] + slices.removed_mm[0] + slices.removed_mm[1]
    for p, turn in enumerate(pair.pairing.turns(pair.position_rad)[0]):
        gaps = alone + gap_by_axes(pair, spread @ slices.conforming.normal, turn + one)
        levers = np.full(gaps.size, base_mm)
        state = solve_contact_general(compliance, gaps.ravel(), levers, TORQUE_NMM)
        assert none.rotation_rad[p] == pytest.approx(gaps.min() / base_mm, rel=SOLVER)
        assert found.rotation_rad[p] == pytest.approx(state.rotation, rel=SOLVER)
        assert found.tangent_rad_per_Nmm[p] == pytest.approx(state.tangent[0, 0], rel=SOLVER)
        assert found.slices is not None
        forces, scale = found.slices.force_N[p].ravel(), state.normal_forces.max()
        np.testing.assert_allclose(forces, state.normal_forces, atol=SOLVER * scale)
        _, table = found.pairs.at(p)
        left = table[:, COLUMNS.index("gap")]
        np.testing.assert_allclose(left, state.final_gap_angles, atol=SOLVER * gaps.max())
    assert found.counters[:, CORE_COUNTERS.index("pivots")].all()


def pressed(wider_um: float, torque_Nm: float, **changes: Any) -> fl.Result:
    """A coupling whose teeth are wider than the spaces, or narrower."""
    shift = 0.05 + wider_um / 1000.0 / (2 * 2.0 * np.tan(np.radians(30.0)))
    keys = {"body_1__profile_shift": shift, "load__torque_Nm": torque_Nm, **EQUAL, **changes}
    return solve(effects__coast_flank=True, **keys)


def test_a_press_fit_carries_on_both_sides_of_its_teeth() -> None:
    """Flanks recede as in the plane: (S + X) F in preload, (S - X) dF by torque, S F alone."""
    preload, more, alone = (pressed(*case) for case in ((3.0, 0.0), (3.0, 200.0), (-3.0, 400.0)))
    assert preload.coast is not None
    assert more.coast is not None
    assert alone.coast is not None
    assert not alone.coast.force_N.any()
    assert preload.transmission_error_um[0] == pytest.approx(1.5, rel=SOLVER)
    every = np.concatenate([preload.site_force_N[0], preload.coast.force_N[0]])
    np.testing.assert_allclose(every, every[0], rtol=SOLVER)
    base = TEETH * np.cos(np.radians(30.0))
    part = 200e3 / (2 * TEETH * base)
    np.testing.assert_allclose(more.site_force_N[0], every[0] + part, rtol=SOLVER)
    np.testing.assert_allclose(more.coast.force_N[0], every[0] - part, rtol=SOLVER)
    alike = base * preload.rotation_rad[0] / every[0]
    opposite = base * (more.rotation_rad[0] - preload.rotation_rad[0]) / part
    single = base * alone.rotation_rad[0] / alone.site_force_N[0, 0]
    # on each side, the force is distributed over the height as if this side carried alone
    assert alike + opposite == pytest.approx(2 * single, rel=2e-4)
    assert 0.0 < alike < single < opposite


def test_half_a_turn_of_a_misaligned_press_fit_exchanges_both_sides() -> None:
    """About the line of centres, on which a tooth is: the teeth are in the opposite order."""
    tilted = {"pair__misalignment_mrad": 3.0, "pair__misalignment_direction_deg": 90.0}
    found = pressed(3.0, 0.0, **tilted)
    assert found.coast is not None
    assert found.slices is not None
    working, turned_over = found.slices.force_N[0], -np.arange(TEETH) % TEETH
    coast = found.coast.pair_tables[0].force_N.reshape(working.shape)
    image = working[turned_over, ::-1]
    np.testing.assert_allclose(coast, image, atol=100 * SOLVER * working.max())
    assert np.ptp(found.site_force_N[0]) > 0.1 * found.site_force_N[0].max()
    assert not any("which this run ignores" in note for note in found.warnings)


def test_conforming_slices_refuse_finite_forces() -> None:
    own = scene(accuracy__slices=2)
    pair = build_bodies(own)
    contact = contact_of(own, pair, (no_compliance(pair.body_1), no_compliance(pair.body_2)))
    with pytest.raises(InputError, match="slices along the face width"):
        sweep(replace(contact, finite_steps=2), pair.position_rad, [TORQUE_NMM])


def _of_strips(pair: Any, compliances: Any) -> tuple[np.ndarray, np.ndarray]:
    """Compliance and gaps (S, J, N) with an unknown on each strip of each slice."""
    slices, height = pair.slices, pair.slices.conforming
    sites, n, count = np.arange(TEETH), height.s_mm[0].size, slices.count
    matrix = np.zeros((TEETH, count, n, TEETH, count, n))
    apart = np.abs(np.arange(n)[:, None] - np.arange(n))
    for compliance, s in zip(compliances, height.s_mm, strict=True):
        field = StripField.of(compliance, TEETH, s, height.strip_mm, slices.edges_mm)
        modes = np.einsum("ia,jb->jiab", field.along, field.over).reshape(count * n, -1)
        blocks = (modes @ compliance.smooth @ modes.T).reshape(-1, count, n, count, n)
        number = compliance.block_of(sites[:, None], sites, TEETH)
        matrix += blocks[number].transpose(0, 2, 3, 1, 4, 5)
        near = field.near[apart] + field.corners.sum(axis=0)
        matrix[sites, :, :, sites] += near.transpose(2, 0, 3, 1)
    turns = pair.pairing.turns(pair.position_rad)[0][0] + pair.pairing.site_angles_rad[0]
    own = np.stack([gap_by_axes(pair, normal, turns) for normal in height.normal], axis=-1)
    removed = slices.removed_mm[0] + slices.removed_mm[1]
    return matrix.reshape(TEETH * count * n, -1), removed[:, None] + own


def test_distances_of_strips_have_the_mean_logarithm() -> None:
    places = (np.arange(500) + 0.5) / 500
    for n, distance in enumerate(strip_distances(4, 0.3)):
        between = np.abs(places[:, None] + n - places[None, :] + (0.5 / 500) * (n == 0))
        assert np.log(distance / 0.3) == pytest.approx(np.log(between).mean(), abs=4e-3)


def test_mean_potential_far_and_near() -> None:
    """Both forms meet, and the one of near segments is the integral."""
    far = mean_potential(
        np.array([10.0 + 1e-9, 10.0 - 1e-9]), np.ones(2), np.ones(2), np.full(2, 1e-3)
    )
    assert far[0] == pytest.approx(far[1], rel=2e-5)
    y = (np.arange(400) + 0.5) / 400
    exact = (1.0 / np.hypot(1.3 + 2.0 * y[:, None] - 1.0 - (y - 0.5), 0.2)).mean()
    assert mean_potential(*np.array([1.3, 2.0, 1.0, 0.2])) == pytest.approx(exact, rel=1e-5)


# --- misalignment ---------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", [0.0, 70.0, 200.0])
def test_the_gap_by_an_exact_rotation(direction: float) -> None:
    """The hub is rotated in space about the middle of its width; straight lines of its flanks cut
    the section at z, and the gap is their displacement along the shaft's normal."""
    angle = 1e-4
    tilted = {"pair__misalignment_mrad": 1e3 * angle, "pair__misalignment_direction_deg": direction}
    pair = build_bodies(scene(**tilted))
    height = pair.slices.conforming
    assert height is not None
    teeth = pair.pairing.site_angles_rad[0]
    z, found = pair.slices.z_mm[-1], gap_by_axes(pair, height.normal[0], teeth)[:, -1]
    tilt = np.radians(direction)
    # leaning along (cos, sin) is a rotation about (-sin, cos)
    rotation = _rotation(np.array([-np.sin(tilt), np.cos(tilt), 0.0]), angle)
    curve = pair.body_1.curve
    s = height.s_mm[0][0] + np.linspace(-0.02, 0.02, 41)
    for tooth in (0, 5, 13, 20):
        flank = turned_rows(curve.point(s), teeth[tooth])
        place = turned_rows(curve.point([height.s_mm[0][0]]), teeth[tooth])[0]
        normal = turned_rows(curve.normal([height.s_mm[0][0]]), teeth[tooth])[0]
        lines = np.column_stack([flank, np.zeros(len(flank))]) @ rotation.T
        along = rotation @ np.array([0.0, 0.0, 1.0])
        section = (lines + np.outer((z - lines[:, 2]) / along[2], along))[:, :2] - place
        tangent = np.array([normal[1], -normal[0]])
        exact = np.interp(
            0.0, *(section @ np.column_stack([tangent, normal])).T[:, np.argsort(section @ tangent)]
        )
        assert found[tooth] == pytest.approx(exact, rel=2e-3, abs=2e-7)


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rotation matrix about a unit vector."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def turned_rows(points: np.ndarray, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray(points @ np.array([[c, s], [-s, c]]))


def test_the_direction_of_the_misalignment_turns_the_load() -> None:
    """Six pitches are a quarter turn; half a turn reverses the load along the teeth."""
    one, quarter, half = (
        solve(**CROWNED, **MISALIGNED, pair__misalignment_direction_deg=angle)
        for angle in (0.0, 90.0, 180.0)
    )
    loads = one.slice_line_load_N_per_mm[0]
    assert deviation(quarter.slice_line_load_N_per_mm[0], np.roll(loads, 6, axis=0)) < 1e-8
    assert deviation(half.slice_line_load_N_per_mm[0], loads[:, ::-1]) < 1e-8
    moments = [found.slices.tilting_moments_Nm[0] for found in (one, quarter) if found.slices]
    np.testing.assert_allclose(moments[1], [-moments[0][1], moments[0][0]], rtol=1e-6, atol=1e-9)


def test_moments_are_those_of_the_forces_of_all_pairs() -> None:
    found = solve(**CROWNED, **MISALIGNED)
    table, slices = found.pairs(0), found.slices
    assert table.z_mm is not None
    lever = table.x_mm * table.normal_y - table.y_mm * table.normal_x
    assert float(table.force_N @ lever) == pytest.approx(TORQUE_NMM, rel=1e-9)
    moments = [
        -(table.z_mm * table.force_N) @ table.normal_y,
        (table.z_mm * table.force_N) @ table.normal_x,
    ]
    assert slices.tilting_moments_Nm is not None
    np.testing.assert_allclose(slices.tilting_moments_Nm[0], np.array(moments) / 1000.0, rtol=1e-9)
    assert found.tilting_moment_Nm[0] == pytest.approx(np.hypot(*moments) / 1000.0)
    # the sleeve that leans along x is turned back, about y
    assert slices.tilting_moments_Nm[0, 1] < -0.1 * found.tilting_moment_Nm[0]
    even = solve(**CROWNED).slices
    assert even is not None
    np.testing.assert_allclose(even.tilting_moments_Nm, 0.0, atol=1e-6)


def test_crowned_teeth_for_axes_at_an_angle() -> None:
    """On parallel axes crowning raises the largest line load, on misaligned ones it lowers it."""
    even, crowned = solve().face_load_factor, solve(**CROWNED).face_load_factor
    tilted, both = (
        solve(**MISALIGNED).face_load_factor,
        solve(**CROWNED, **MISALIGNED).face_load_factor,
    )
    assert even < 1.2 < crowned
    assert both < 0.8 * tilted
    assert solve(**CROWNED).load_share.max() == pytest.approx(1.0 / TEETH)
    loads = solve(**MISALIGNED).slice_line_load_N_per_mm
    assert tilted == pytest.approx(loads.max() / loads.mean())


def test_work_of_the_torque() -> None:
    """Rotation is proportional to torque if all teeth carry; derivative from the forces."""
    one, two = (solve(load__torque_Nm=torque) for torque in (600.0, 1200.0))
    np.testing.assert_allclose(two.rotation_rad, 2.0 * one.rotation_rad, rtol=1e-9)
    stiffness = one.torque_Nm / one.rotation_rad
    np.testing.assert_allclose(one.stiffness_tangent_Nm_per_rad, stiffness, rtol=1e-9)
    less, some, more = (
        solve(**CROWNED, **MISALIGNED, load__torque_Nm=600.0 + step) for step in (-0.1, 0.0, 0.1)
    )
    slope = (more.rotation_rad - less.rotation_rad) / 0.2
    np.testing.assert_allclose(1.0 / some.stiffness_tangent_Nm_per_rad, slope, rtol=1e-3)


def test_a_helix_slope_of_one_tooth() -> None:
    """Metal is missing at larger z of tooth 5 alone, of shaft or hub."""
    slopes = [0.0] * 5 + [20.0] + [0.0] * 18
    width = {f"body_{body}__face_width_mm": 16.0 for body in (1, 2)}
    even = solve(**width).slice_line_load_N_per_mm[0]
    for z in (1, 2):
        loads = solve(
            **width, **{f"body_{z}__tooth_helix_slope_um": slopes}
        ).slice_line_load_N_per_mm[0]
        assert loads[5, -1] < 0.3 * even[5, -1]
        assert loads[5, -1] < loads[5, 0]
        assert (np.delete(loads, 5, axis=0) > 0.97 * np.delete(even, 5, axis=0)).all()


# --- scene ----------------------------------------------------------------------------------------


def test_a_tilt_that_takes_up_the_backlash_is_said() -> None:
    """100 um of normal backlash: 6 mrad move the ends of 16 mm by 48 um, 7 mrad by 56 um."""
    enough, few = (
        [
            note
            for note in build_bodies(scene(pair__misalignment_mrad=angle)).notes
            if "coast" in note
        ]
        for angle in (6.0, 7.0)
    )
    assert not enough
    assert few[0].startswith("the normal backlash of 100.0 um is less than twice the 56.0 um")


def test_misaligned_couplings_have_positions() -> None:
    """Positions are equal on a common axis, but not at an angle."""
    many = {"positions__angles_deg": None, "positions__count": 3}
    assert solve(**CROWNED, **many).position_rad.size == 1
    found = solve(**CROWNED, **MISALIGNED, **many)
    assert found.position_rad.size == 3
    assert not found.stands_alike
    # a pitch later each tooth is where its neighbour was
    turned = solve(**CROWNED, **MISALIGNED, positions__angles_deg=[0.0, 360.0 / TEETH])
    loads = turned.slice_line_load_N_per_mm
    assert deviation(loads[1], np.roll(loads[0], -1, axis=0)) < 1e-8


@pytest.mark.parametrize(
    ("changes", "key", "expected"),
    [
        (
            {"body_1__profile_crowning_um": 3.0},
            "body_1.profile_crowning_um",
            (
                "nothing, since body_1.lead_crowning_um requires three dimensions: flanks of "
                "splines conform over their height there (lead modifications vary along it)"
            ),
        ),
        (
            {"pair__inclination_um_per_mm": 0.1},
            "pair.inclination_um_per_mm",
            "nothing: a spline_shaft and a spline_hub have pair.misalignment_mrad",
        ),
        (
            {"pair__misalignment_direction_deg": 10.0},
            "pair.misalignment_direction_deg",
            "nothing, unless pair.misalignment_mrad is > 0",
        ),
        (
            {"body_2__tooth_helix_slope_um": [1.0, 2.0]},
            "body_2.tooth_helix_slope_um",
            "one entry per tooth: 24, as in body_2.teeth",
        ),
    ],
)
def test_refusals(changes: dict[str, Any], key: str, expected: str) -> None:
    with pytest.raises(fl.SceneError) as caught:
        scene(**CROWNED, **changes)
    assert caught.value.key == key
    assert caught.value.expected == expected


def test_gears_have_no_misalignment_of_splines() -> None:
    with pytest.raises(fl.SceneError) as caught:
        fl.Scene.from_dict(tree_of("helical_gear", {"pair__misalignment_mrad": 1.0}))
    assert caught.value.expected == (
        "nothing: a gear and a gear have pair.inclination_um_per_mm and deviation_um_per_mm"
    )


def test_cells_are_refused_in_one_line() -> None:
    with pytest.raises(fl.SceneError, match=r"effects\.contact.*one unknown each"):
        scene(effects__contact="pairs")
