"""All positions and torques from points and compliances, through the flat interface."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import flankload as fl
from flankload import _core
from tests.support.nodal_position import DATA, NodalPosition, read_data, spoilt
from tests.support.nodal_sweep import NAMES, NodalSweep, nodal_sweep
from tests.support.tolerances import SOLVER

SPACING = 0.075
# Errors with points at half of the half-width of the contact: of the rotation and of the
# part of the load on a flank, off tip edges and where a sharp one works: there the pressure has no
# limit, and the error falls with the spacing itself.
ROTATION, ROTATION_ON_EDGES = 2e-3, 2.5e-2
SHARE, SHARE_ON_EDGES = 1e-3, 2.5e-2
# Moment about O2 by that about O1, in the ratio of the teeth: circles about O1 leave that much.
RATIO = 1.5e-3
# Compliances in a file of nine digits whose sides of the diagonal differ in the last one.
LAST_DIGIT = 1e-8


@pytest.fixture(scope="module")
def sweep() -> NodalSweep:
    return nodal_sweep(SPACING)


@pytest.fixture(scope="module")
def found(sweep: NodalSweep) -> dict[str, Any]:
    found = sweep.solve()
    assert found["info"] == 0
    assert (found["status"] == 0).all()
    return found


def on_edges(sweep: NodalSweep) -> np.ndarray:
    """(P, T): where a sharp tip works by the scene itself."""
    return np.array([r.corner_contact.any(axis=1) for r in sweep.results]).T


def errors_of(sweep: NodalSweep) -> tuple[np.ndarray, np.ndarray]:
    """Errors of rotation (P, T) and load shares of the flanks (P, T), relative to the scene."""
    found = sweep.solve()
    rotation = np.array([result.rotation_rad for result in sweep.results]).T
    force = found["flank_force"]
    share = np.array([result.load_share.T for result in sweep.results]).transpose(1, 2, 0)
    return (
        np.abs(found["rotation"] / rotation - 1.0),
        np.abs(force / force.sum(axis=0) - share).max(axis=0),
    )


def test_the_sweep_is_that_of_the_scene(sweep: NodalSweep) -> None:
    rotation, share = errors_of(sweep)
    edges = on_edges(sweep)
    full = (slice(None), -1)
    assert edges[full].any()
    assert not edges[full].all()
    assert rotation[full][~edges[full]].max() < ROTATION
    assert rotation[full][edges[full]].max() < ROTATION_ON_EDGES
    assert share[full][~edges[full]].max() < SHARE
    assert share[full][edges[full]].max() < SHARE_ON_EDGES


def test_errors_fall_with_the_spacing(sweep: NodalSweep) -> None:
    coarse, _ = errors_of(sweep)
    fine, _ = errors_of(nodal_sweep(0.5 * SPACING))
    assert (fine.max(axis=0) < 0.75 * coarse.max(axis=0)).all()


def test_both_torques_are_in_the_ratio_of_the_teeth(
    sweep: NodalSweep, found: dict[str, Any]
) -> None:
    ratio = found["torque_2"] / sweep.torques_Nmm
    np.testing.assert_allclose(ratio[~on_edges(sweep)], 24 / 16, rtol=RATIO, atol=0)


def test_a_position_has_the_bits_of_a_position_alone() -> None:
    """The bits of flankload_position followed by flankload_solve_contact."""
    still = read_data(DATA)
    torques = np.array([1.0, 0.5]) * still.torque_Nmm
    found = NodalSweep(still, np.zeros((2, 1)), torques).solve()
    flank, radius, gap_angle, lever, row, row_2, matrix = still.pairs()
    n = flank.size
    assert found["n_pairs"].tolist() == [n]
    np.testing.assert_array_equal(found["flank"][:n, 0], flank)
    np.testing.assert_array_equal(found["radius"][:n, 0], radius)
    np.testing.assert_array_equal(found["gap_angle"][:n, 0], gap_angle)
    for t, torque in enumerate(torques):
        forces, gaps, motion, tangent, _, _, certificate, info = _core.flankload_solve_contact(
            np.asfortranarray(matrix),
            lever * gap_angle,
            np.asfortranarray(lever[:, None]),
            np.asfortranarray(row[:, None]),
            np.array([torque]),
            1,
            0,
            np.empty(0, dtype=np.int32),
        )
        assert found["status"][0, t] == info == 0
        np.testing.assert_array_equal(found["force"][:n, 0, t], forces)
        np.testing.assert_array_equal(found["final_gap"][:n, 0, t], gaps)
        assert found["rotation"][0, t] == motion[0]
        assert found["tangent"][0, t] == tangent[0, 0]
        np.testing.assert_array_equal(found["certificate"][:, 0, t], certificate[[2, 0, 3]])
        np.testing.assert_allclose(found["torque_2"][0, t], row_2 @ forces, rtol=SOLVER, atol=0)
        sums = [forces[flank == f].sum() for f in (1, 2)]
        np.testing.assert_allclose(found["flank_force"][:, 0, t], sums, rtol=SOLVER, atol=0)


def test_turned_bodies_are_bodies_at_their_angles(sweep: NodalSweep, found: dict[str, Any]) -> None:
    for p in range(0, sweep.angles_rad.shape[1], 3):
        flank, radius, gap_angle, lever, row, _, matrix = sweep.at(p).pairs()
        n = found["n_pairs"][p]
        np.testing.assert_array_equal(found["flank"][:n, p], flank)
        np.testing.assert_allclose(found["radius"][:n, p], radius, rtol=SOLVER, atol=0)
        np.testing.assert_allclose(found["gap_angle"][:n, p], gap_angle, rtol=0, atol=SOLVER)
        state = fl.solve_contact_general(
            matrix, lever * gap_angle, lever, sweep.torques_Nmm[-1], load_rows=row
        )
        np.testing.assert_allclose(
            found["rotation"][p, -1], state.rotation, rtol=10 * SOLVER, atol=0
        )


@pytest.mark.parametrize("changes", [{"n_threads": 3}, {"n_threads": 0}, {"max_pairs": 0}])
def test_nothing_else_changes_a_bit(
    sweep: NodalSweep, found: dict[str, Any], changes: dict[str, int]
) -> None:
    again = sweep.solve(**changes)
    for name in NAMES[: NAMES.index("flank")]:
        np.testing.assert_array_equal(again[name], found[name])
    if "max_pairs" in changes:
        assert all(again[name].size == 0 for name in NAMES[NAMES.index("flank") : -1])
    else:
        np.testing.assert_array_equal(again["force"], found["force"])


def test_states_depend_on_no_other_state(sweep: NodalSweep, found: dict[str, Any]) -> None:
    some = replace(
        sweep,
        angles_rad=np.ascontiguousarray(sweep.angles_rad[:, 5:2:-2]),
        torques_Nmm=sweep.torques_Nmm[1:2],
    ).solve()
    np.testing.assert_array_equal(some["rotation"], found["rotation"][5:2:-2, 1:2])
    np.testing.assert_array_equal(some["force"], found["force"][:, 5:2:-2, 1:2])


def test_a_mirrored_sweep_has_the_same_numbers(sweep: NodalSweep, found: dict[str, Any]) -> None:
    still = sweep.still
    one, two = (np.asfortranarray((points * [1.0, -1.0]).T) for points in still.points)
    mirrored = sweep.solve(
        turn=-1,
        points_1=one,
        points_2=two,
        angles_1=-sweep.angles_rad[0],
        angles_2=-sweep.angles_rad[1],
    )
    for name in NAMES:
        np.testing.assert_array_equal(mirrored[name], found[name])


def test_the_common_frame_is_free(sweep: NodalSweep, found: dict[str, Any]) -> None:
    shift = np.array([30.0, -20.0])
    moved = replace(
        sweep,
        still=replace(
            sweep.still,
            axes=tuple(axis + shift for axis in sweep.still.axes),
            points=tuple(points + shift for points in sweep.still.points),
        ),
    ).solve()
    np.testing.assert_allclose(moved["rotation"], found["rotation"], rtol=SOLVER, atol=SOLVER)
    np.testing.assert_allclose(moved["torque_2"], found["torque_2"], rtol=10 * SOLVER, atol=0)


def test_without_torque_the_rotation_is_the_least_gap(
    sweep: NodalSweep, found: dict[str, Any]
) -> None:
    idle = sweep.solve(torques=np.zeros(1))
    least = np.nanmin(found["gap_angle"], axis=0)
    np.testing.assert_allclose(idle["rotation"][:, 0], least, rtol=SOLVER, atol=0)
    assert not idle["flank_force"].any()


def test_a_table_that_is_not_quite_symmetric(sweep: NodalSweep, found: dict[str, Any]) -> None:
    table = np.array(sweep.still.compliances[0], order="F")
    rng = np.random.default_rng(20261121)
    table *= 1.0 + LAST_DIGIT * rng.uniform(-0.5, 0.5, table.shape)
    crooked = sweep.solve(compliance_1=table)
    np.testing.assert_allclose(crooked["rotation"], found["rotation"], rtol=10 * LAST_DIGIT, atol=0)


def test_positions_without_a_state_say_why(sweep: NodalSweep) -> None:
    apart = np.array(sweep.angles_rad)
    apart[:, 2] += np.pi  # both flanks on the far sides of their axes
    lost = replace(sweep, angles_rad=apart).solve()
    assert lost["info"] == sweep.torques_Nmm.size
    assert (lost["status"][2] == -11).all()
    assert np.isnan(lost["rotation"][2]).all()
    assert np.isnan(lost["force"][:, 2]).all()
    assert lost["n_pairs"][2] == 0
    assert (np.delete(lost["status"], 2, axis=0) == 0).all()
    arc = np.array(sweep.still.points[1])
    arc[3] = arc[1]
    unsteady = sweep.solve(points_2=np.asfortranarray(arc.T))
    assert (unsteady["status"] == -19).all()
    assert unsteady["info"] == unsteady["status"].size


def test_refused_arguments_have_their_number(sweep: NodalSweep) -> None:
    still: NodalPosition = sweep.still
    few = int(still.sizes[0].sum()) - 1
    cases: dict[int, dict[str, Any]] = {
        6: {"n_circles": -1},
        7: {"max_pairs": few},
        8: {"turn": 2},
        9: {"n_threads": -1},
        10: {"angles_1": spoilt(sweep.angles_rad[0])},
        11: {"angles_2": spoilt(sweep.angles_rad[1], np.inf)},
        12: {"torques": spoilt(sweep.torques_Nmm, -1.0)},
        13: {"axis_1": spoilt(still.axes[0])},
        14: {"axis_2": spoilt(still.axes[1])},
        15: {"sizes_1": spoilt(still.sizes[0], 1)},
        16: {"points_1": spoilt(still.points[0].T)},
        17: {"compliance_1": spoilt(still.compliances[0])},
        18: {"sizes_2": spoilt(still.sizes[1], 1)},
        19: {"points_2": spoilt(still.points[1].T)},
        20: {"compliance_2": spoilt(still.compliances[1])},
    }
    for argument, change in cases.items():
        refused = sweep.solve(**change)
        assert refused["info"] == -100 - argument
        assert np.isnan(refused["rotation"]).all()
        assert (refused["status"] == -4).all()
    assert sweep.solve(n_circles=20, max_pairs=39)["info"] == -107
    assert sweep.solve(n_circles=20, max_pairs=40)["info"] == 0
