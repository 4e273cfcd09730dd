"""One position from points and compliances, the way of the paper, through the flat interface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import flankload as fl
from flankload import _core
from tests.support.nodal_position import NodalPosition, nodal_position, spoilt
from tests.support.tolerances import ROUND_OFF, SOLVER

# Errors with points 0.05 mm apart (a third of the half-width of the contact): of the rotation, of
# the part of the load on a flank, and of the ratio of both torques (the circles leave that alone).
ROTATION = 5e-4
SHARE = 1e-3
RATIO = 1.5e-3
TEETH = (16, 24)


@pytest.fixture(scope="module")
def position() -> NodalPosition:
    return nodal_position(25)


def solved(position: NodalPosition) -> tuple[fl.ContactState, tuple[np.ndarray, ...]]:
    pairs = position.pairs()
    _, _, gap_angle, lever, row, _, matrix = pairs
    return (
        fl.solve_contact_general(
            matrix, lever * gap_angle, lever, position.torque_Nmm, load_rows=row
        ),
        pairs,
    )


def spline_of(points: np.ndarray) -> tuple[CubicSpline, np.ndarray]:
    chord = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return CubicSpline(chord, points), chord


def on_circle(points: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Point, unit tangent and weights of the points where a flank meets a circle about O1."""
    spline, chord = spline_of(points)
    radii = np.linalg.norm(points, axis=1)
    k = int(np.searchsorted(np.sort(radii), radius, side="right")) - 1
    k = min(max(k, 0), len(radii) - 2)  # an end of the flank is on the circle to rounding
    if radii[0] > radii[-1]:
        k = len(radii) - 2 - k
    ends = chord[k : k + 2]
    exact = [
        end
        for end, r in zip(ends, radii[k : k + 2], strict=True)
        if abs(r - radius) < ROUND_OFF * r
    ]
    s = exact[0] if exact else brentq(lambda u: np.hypot(*spline(u)) - radius, *ends, xtol=1e-15)
    tangent = spline(s, 1)
    weights = np.zeros(len(radii))
    part = (s - ends[0]) / (ends[1] - ends[0])
    weights[k : k + 2] = 1.0 - part, part
    return spline(s), tangent / np.linalg.norm(tangent), weights


@pytest.mark.parametrize("n_circles", [0, 1, 7])
def test_against_an_independent_way(position: NodalPosition, n_circles: int) -> None:
    flank, radius, gap_angle, lever, row, row_2, matrix = position.pairs(n_circles)
    ends = np.cumsum(position.sizes[0])
    expected = np.zeros((2, flank.size, ends[-1]))
    for i, (f, r) in enumerate(zip(flank, radius, strict=True)):
        own = slice(ends[f - 1] - position.sizes[0][f - 1], ends[f - 1])
        (a, t_1, w_1), (b, t_2, w_2) = (on_circle(points[own], r) for points in position.points)
        expected[0, i, own], expected[1, i, own] = w_1, w_2
        angle = np.arctan2(b[1], b[0]) - np.arctan2(a[1], a[0])
        np.testing.assert_allclose(gap_angle[i], angle, rtol=0, atol=SOLVER * 1e-3)
        levers = abs(a @ t_1), abs(b @ t_2)
        np.testing.assert_allclose(row[i], levers[0], rtol=SOLVER, atol=0)
        np.testing.assert_allclose(lever[i], sum(levers) / 2, rtol=SOLVER, atol=0)
        about_2 = abs((a - position.axes[1]) @ t_1)
        np.testing.assert_allclose(row_2[i], about_2, rtol=SOLVER, atol=0)
    tables = sum(w @ c @ w.T for w, c in zip(expected, position.compliances, strict=True))
    np.testing.assert_allclose(matrix, tables, rtol=1e-8, atol=0)


def test_load_distribution_is_that_of_the_scene(position: NodalPosition) -> None:
    state, (flank, *_, row_2, _) = solved(position)
    np.testing.assert_allclose(state.rotation, position.rotation_rad, rtol=ROTATION, atol=0)
    share = [state.normal_forces[flank == f].sum() for f in (1, 2)] / state.normal_forces.sum()
    expected = position.site_force_N / position.site_force_N.sum()
    np.testing.assert_allclose(share, expected, rtol=0, atol=SHARE)
    ratio = row_2 @ state.normal_forces / position.torque_Nmm
    np.testing.assert_allclose(ratio, TEETH[1] / TEETH[0], rtol=RATIO, atol=0)


def test_error_falls_with_the_spacing() -> None:
    errors = []
    for points in (9, 25, 65):
        fine = nodal_position(points)
        errors.append(abs(solved(fine)[0].rotation / fine.rotation_rad - 1.0))
    assert errors[0] > 4 * errors[1] > 8 * errors[2]


def test_mirrored_bodies_give_the_same_numbers(position: NodalPosition) -> None:
    mirrored = replace(
        position,
        points=tuple(points * [1.0, -1.0] for points in position.points),
    )
    expected = position.pairs()
    n, *found, info = call(mirrored, turn=-1)
    assert info == 0
    for mine, other in zip(found, expected[:-1], strict=False):
        np.testing.assert_array_equal(mine[:n], other)
    assert n == expected[0].size


def test_points_from_tip_to_root_are_the_same_flank(position: NodalPosition) -> None:
    size = int(position.sizes[1][0])
    order = np.concatenate([np.arange(size)[::-1], size + np.arange(size)[::-1]])
    turned = replace(
        position,
        points=(position.points[0], position.points[1][order]),
        compliances=(position.compliances[0], position.compliances[1][np.ix_(order, order)]),
    )
    for mine, other in zip(turned.pairs(), position.pairs(), strict=True):
        np.testing.assert_allclose(mine, other, rtol=SOLVER, atol=SOLVER * np.abs(other).max())


def test_straight_flanks_by_hand() -> None:
    """Two lines x = 10 and y = 0.5 + 0.1 (x - 10), bodies of one spring a point."""
    lines = NodalPosition(
        torque_Nmm=1.0,
        axes=(np.zeros(2), np.array([20.0, 0.0])),
        sizes=(np.array([2], dtype=np.int32), np.array([3], dtype=np.int32)),
        points=(
            np.array([[10.0, 2.0], [10.0, 4.0]]),
            np.array([[9.0, 3.0], [10.0, 3.5], [12.0, 4.5]]),
        ),
        compliances=(np.diag([2.0, 4.0]), np.diag([1.0, 3.0, 5.0])),
    )
    flank, radius, gap_angle, lever, row, row_2, matrix = lines.pairs(1)
    assert flank.tolist() == [1]
    middle = 0.5 * (np.hypot(10, 2) + np.hypot(10, 4))
    low, high = max(np.hypot(10, 2), np.hypot(9, 3)), np.hypot(10, 4)
    middle = 0.5 * (low + high)
    np.testing.assert_allclose(radius[0], middle, rtol=ROUND_OFF, atol=0)
    y = np.sqrt(middle**2 - 100.0)
    x_2 = brentq(lambda x: np.hypot(x, 3.0 + 0.5 * (x - 9.0)) - middle, 9.0, 12.0, xtol=1e-15)
    y_2 = 3.0 + 0.5 * (x_2 - 9.0)
    angle = np.arctan2(y_2, x_2) - np.arctan2(y, 10.0)
    np.testing.assert_allclose(gap_angle[0], angle, rtol=SOLVER, atol=0)
    lever_2 = (x_2 + 0.5 * y_2) / np.sqrt(1.25)
    np.testing.assert_allclose(row[0], y, rtol=SOLVER, atol=0)
    np.testing.assert_allclose(lever[0], 0.5 * (y + lever_2), rtol=SOLVER, atol=0)
    np.testing.assert_allclose(row_2[0], y, rtol=SOLVER, atol=0)
    part = (y - 2.0) / 2.0
    one = 2.0 * (1 - part) ** 2 + 4.0 * part**2
    k = int(x_2 > 10.0)
    part = (x_2 - [9.0, 10.0][k]) / [1.0, 2.0][k]
    two = [1.0, 3.0, 5.0][k] * (1 - part) ** 2 + [1.0, 3.0, 5.0][k + 1] * part**2
    np.testing.assert_allclose(matrix[0, 0], one + two, rtol=SOLVER, atol=0)


def call(position: NodalPosition, **changes: object) -> tuple:
    """The flat procedure itself, with changes by name."""
    arguments: dict[str, object] = {
        "n_circles": 0,
        "max_pairs": 100,
        "turn": 1,
        "axis_1": position.axes[0],
        "axis_2": position.axes[1],
        "sizes_1": position.sizes[0],
        "points_1": np.asfortranarray(position.points[0].T),
        "compliance_1": np.asfortranarray(position.compliances[0]),
        "sizes_2": position.sizes[1],
        "points_2": np.asfortranarray(position.points[1].T),
        "compliance_2": np.asfortranarray(position.compliances[1]),
    }
    return _core.flankload_position(*(arguments | changes).values())


def test_refused_arguments_have_their_number(position: NodalPosition) -> None:
    points = np.asfortranarray(position.points[0].T)
    steps = np.array(points, order="F")
    steps[:, 1] = steps[:, 0]
    cases = {
        4: {"n_circles": -1},
        5: {"max_pairs": 0},
        6: {"turn": 0},
        7: {"axis_1": spoilt(position.axes[0])},
        8: {"axis_2": spoilt(position.axes[1], np.inf)},
        9: {"sizes_1": np.array([1, 49], dtype=np.int32)},
        10: {"points_1": spoilt(points)},
        11: {"compliance_1": spoilt(position.compliances[0])},
        12: {"sizes_2": np.array([25, 24], dtype=np.int32)},
        13: {"points_2": spoilt(points, -np.inf)},
        14: {"compliance_2": spoilt(position.compliances[1])},
    }
    for argument, change in cases.items():
        n, *arrays, info = call(position, **change)
        assert info == -100 - argument
        assert n == 0
        assert not any(array.any() for array in arrays)
    assert call(position, points_1=steps)[-1] == -110
    assert call(position, points_2=steps)[-1] == -113


def test_a_normal_through_the_axis_is_refused(position: NodalPosition) -> None:
    along = np.tile(np.linspace(-1.0, 1.0, 25), 2)
    middle = np.linalg.norm(position.points[0].reshape(2, 25, 2).mean(axis=1), axis=1)
    # radii grow by a hair: the flank lies along its circle
    radius, angle = np.repeat(middle, 25) + 1e-3 * along, 0.1 * along
    arc = np.asfortranarray([radius * np.cos(angle), radius * np.sin(angle)])
    assert call(position, points_2=arc, n_circles=3)[-1] == -113


def test_too_little_room_says_how_much_is_wanted(position: NodalPosition) -> None:
    n = call(position)[0]
    assert call(position, max_pairs=n)[-1] == 0
    n_less, *arrays, info = call(position, max_pairs=n - 1)
    assert (n_less, info) == (0, n)
    assert not any(array.any() for array in arrays)


def test_flanks_that_share_no_circle_have_no_pairs(position: NodalPosition) -> None:
    away = np.asfortranarray(3.0 * position.points[1].T)
    n, *_, info = call(position, points_2=away)
    assert (n, info) == (0, 0)


def test_flanks_end_on_circles_of_their_own() -> None:
    """A flank of body 2 that ends anywhere between the points of body 1, at either end."""
    rng = np.random.default_rng(20261121)
    y = np.linspace(1.0, 6.0, 9)
    points = np.asfortranarray([np.full(9, 10.0), y])
    own = np.hypot(10.0, y)
    spacing = np.diff(own)
    for _ in range(200):
        low, high = np.sort(rng.uniform(own[0], own[-1], 2))
        side = np.array([[9.0, 9.0], np.sqrt(np.array([low, high]) ** 2 - 81.0)])
        lines = NodalPosition(
            torque_Nmm=1.0,
            axes=(np.zeros(2), np.array([20.0, 0.0])),
            sizes=(np.array([9], dtype=np.int32), np.array([2], dtype=np.int32)),
            points=(points.T, side.T),
            compliances=(np.eye(9), np.eye(2)),
        )
        _, radius, *_ = lines.pairs(room=9)
        inside = (own > low) & (own < high)
        if radius.size == 1:
            np.testing.assert_allclose(radius[0], 0.5 * (low + high), rtol=SOLVER, atol=0)
            assert high - low < spacing.max()
            continue
        np.testing.assert_allclose(radius[[0, -1]], [low, high], rtol=SOLVER, atol=0)
        kept = [r for r in own[inside] if np.abs(radius - r).min() < SOLVER]
        assert len(kept) == radius.size - 2 >= inside.sum() - 2
        assert np.diff(radius).min() > 0.5 * spacing.min() * (1.0 - SOLVER)
