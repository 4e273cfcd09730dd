"""Flank curves: exact pieces, their fit by arc length, and curves through nodes."""

from __future__ import annotations

import numpy as np
import pytest

from flankload.flank import (
    CurvePiece,
    FlankCurve,
    curve_through_nodes,
    fit_flank_curve,
    nodes_deviation,
    turned_along,
)
from tests.support.tolerances import ROUND_OFF, SOLVER

RADIUS = 10.0
BASE_RADIUS = 33.8


def arc(center: tuple[float, float], radius: float, start: float, end: float, **more) -> CurvePiece:
    def place(u):
        out = np.stack([np.cos(u), np.sin(u)], axis=1)
        along = np.stack([-out[:, 1], out[:, 0]], axis=1)
        return np.asarray(center) + radius * out, radius * along, -radius * out

    return CurvePiece("flank", place, start, end, **more)


def involute(start: float, end: float) -> CurvePiece:
    def place(roll):
        angle = 0.2 - roll
        radial = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        normal = np.stack([-radial[:, 1], radial[:, 0]], axis=1)
        t = roll[:, None]
        return (
            BASE_RADIUS * (radial + t * normal),
            BASE_RADIUS * t * radial,
            BASE_RADIUS * (radial - t * normal),
        )

    return CurvePiece("flank", place, start, end)


@pytest.fixture
def top() -> FlankCurve:
    """The top of a circle about the origin, clockwise: the material lies inside."""
    return fit_flank_curve([arc((0.0, 0.0), RADIUS, np.pi / 2 + 0.3, np.pi / 2 - 0.3)])


def test_arc_has_its_length_place_normal_and_curvature(top: FlankCurve) -> None:
    s = np.linspace(0.0, top.length_mm, 500)
    angle = np.pi / 2 + 0.3 - s / RADIUS
    exact = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert top.length_mm == pytest.approx(0.6 * RADIUS, rel=ROUND_OFF)
    np.testing.assert_allclose(top.point(s), RADIUS * exact, rtol=0, atol=1e-10)
    np.testing.assert_allclose(top.normal(s), exact, rtol=0, atol=SOLVER)
    np.testing.assert_allclose(top.curvature(s), 1 / RADIUS, rtol=0, atol=1e-7)


def test_hollow_curve_has_negative_curvature() -> None:
    hollow = fit_flank_curve([arc((0.0, 0.0), RADIUS, -2.0, -1.0)])
    assert hollow.curvature([1.0])[0] == pytest.approx(-1 / RADIUS, rel=1e-6)


def test_involute_is_within_the_tolerance_at_equal_arc_length() -> None:
    curve = fit_flank_curve([involute(0.15, 0.7)])
    s = np.linspace(0.0, curve.length_mm, 999)
    # the arc length of an involute is r_b t²/2
    roll = np.sqrt(0.15**2 + 2 * s / BASE_RADIUS)
    assert curve.length_mm == pytest.approx(BASE_RADIUS * (0.7**2 - 0.15**2) / 2, rel=ROUND_OFF)
    exact = involute(0.15, 0.7).place(roll)[0]
    np.testing.assert_allclose(curve.point(s), exact, rtol=0, atol=1.5e-10)


def test_involute_from_its_base_circle_is_fitted_too() -> None:
    curve = fit_flank_curve([involute(1e-6, 0.7)])
    s = np.linspace(0.0, curve.length_mm, 999)
    exact = involute(1e-6, 0.7).place(np.sqrt(1e-12 + 2 * s / BASE_RADIUS))[0]
    np.testing.assert_allclose(curve.point(s), exact, rtol=0, atol=SOLVER)


def test_pieces_join_with_labels_and_corners() -> None:
    first = arc((0.0, -10.0), 10.0, np.pi / 2 + 0.2, np.pi / 2)
    second = arc((0.0, -2.0), 2.0, np.pi / 2, 0.0, corner_before=True)._replace(label="tip_radius")
    curve = fit_flank_curve([first, second], corner_at_end=True)
    at = curve.labels.index("tip_radius")
    assert np.flatnonzero(curve.corners).tolist() == [at, len(curve.labels)]
    assert curve.breaks[at] == pytest.approx(2.0, rel=ROUND_OFF)
    assert curve.range_of("tip_radius") == (curve.breaks[at], curve.length_mm)
    assert curve.range_of("flank", "tip_radius") == (0.0, curve.length_mm)
    with pytest.raises(ValueError, match=r"expected some of .*found"):
        curve.range_of("fillet")


def test_rotated_curve_is_the_curve_turned(top: FlankCurve) -> None:
    s = np.linspace(0.0, top.length_mm, 50)
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    np.testing.assert_allclose(
        top.rotated(0.7).point(s), top.point(s) @ turn.T, rtol=0, atol=RADIUS * ROUND_OFF
    )


def test_closest_places_are_found(top: FlankCurve) -> None:
    s = np.linspace(0.0, top.length_mm, 73)
    above = top.point(s) + 0.25 * top.normal(s)
    found, distance = top.arc_length_of(above)
    np.testing.assert_allclose(found, s, rtol=0, atol=SOLVER)
    np.testing.assert_allclose(distance, 0.25, rtol=0, atol=SOLVER)


def test_closest_place_beyond_an_end_is_the_end(top: FlankCurve) -> None:
    beyond = top.point([0.0]) - 0.5 * top.tangent([0.0])
    found, distance = top.arc_length_of(beyond)
    assert found[0] == 0.0
    assert distance[0] == pytest.approx(0.5, rel=ROUND_OFF)


def test_jump_is_refused() -> None:
    def place(u):
        zero = np.zeros_like(u)
        return (
            np.stack([u, 1.0 * (u > 0.1)], axis=1),
            np.stack([zero + 1, zero], axis=1),
            np.stack([zero, zero], axis=1),
        )

    with pytest.raises(ValueError, match=r"found a jump near u = 0\.1"):
        fit_flank_curve([CurvePiece("flank", place, -1.0, 0.7)])


def test_no_pieces_are_refused() -> None:
    with pytest.raises(ValueError, match="at least one piece"):
        fit_flank_curve([])


def nodes_of_involute(n: int) -> np.ndarray:
    return fit_flank_curve([involute(0.25, 0.7)]).point(
        np.linspace(0.0, BASE_RADIUS * (0.7**2 - 0.25**2) / 2, n)
    )


def test_curve_through_nodes_converges_at_fourth_order_or_better() -> None:
    exact = fit_flank_curve([involute(0.25, 0.7)])
    errors = []
    for n in (9, 17, 33):
        curve = curve_through_nodes(nodes_of_involute(n))
        s = np.linspace(0.0, curve.length_mm, 400)
        errors.append(exact.arc_length_of(curve.point(s))[1].max())
    slopes = -np.diff(np.log2(errors))
    assert (slopes > 3.5).all()


def test_curve_goes_through_its_nodes_by_arc_length() -> None:
    nodes = nodes_of_involute(13)
    curve = curve_through_nodes(nodes)
    assert curve.arc_length_of(nodes)[1].max() < SOLVER
    speed = np.linalg.norm(curve.derivatives(np.linspace(0, curve.length_mm, 300))[1], axis=1)
    np.testing.assert_allclose(speed, 1.0, rtol=0, atol=1e-7)
    assert curve.corners.tolist() == [False] * (curve.corners.size - 1) + [True]


@pytest.mark.parametrize("n", [13, 16, 25])
def test_deviation_of_nodes_is_of_the_right_size(n: int) -> None:
    nodes = nodes_of_involute(n)
    curve = curve_through_nodes(nodes)
    s = np.linspace(0.0, curve.length_mm, 400)
    exact = fit_flank_curve([involute(0.25, 0.7)])
    true = exact.arc_length_of(curve.point(s))[1].max()
    assert 0.3 < nodes_deviation(nodes) / true < 10


def test_deviation_of_too_few_nodes_is_unknown() -> None:
    assert nodes_deviation(nodes_of_involute(6)) == np.inf


@pytest.mark.parametrize("count", [8, 13])
def test_the_deviation_is_that_of_the_curve_through_every_second_node(count: int) -> None:
    nodes = nodes_of_involute(count)
    left_out = np.arange(1, count - 1, 2)
    coarse = curve_through_nodes(np.delete(nodes, left_out, axis=0))
    apart = coarse.arc_length_of(nodes[left_out])[1].max() / 15.0
    # both by a fit that is off by 1e-11 of the length
    np.testing.assert_allclose(nodes_deviation(nodes), apart, rtol=0, atol=1e-10)


def test_bad_nodes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"m >= 4, found \(3, 2\)"):
        curve_through_nodes(nodes_of_involute(3))
    twin = nodes_of_involute(6)
    twin[3] = twin[2]
    with pytest.raises(ValueError, match="two that coincide"):
        curve_through_nodes(twin)


def test_a_curve_turned_by_a_varying_angle(top: FlankCurve) -> None:
    """Each point turns about the origin by the angle at its place; derivatives follow."""

    def turn(s: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return 1e-3 * s**2, 2e-3 * s, np.full_like(s, 2e-3)

    knots = np.array([top.breaks[1] + 1e-9, 0.77, top.length_mm + 1.0])
    turned = turned_along(top, turn, knots)
    assert 0.77 in turned.breaks
    assert turned.breaks.size == top.breaks.size + 1
    s = np.linspace(0.0, top.length_mm, 97)
    one, two = (curve.point(s) @ [1.0, 1.0j] for curve in (top, turned))
    np.testing.assert_allclose(two, one * np.exp(1e-3j * s**2), rtol=0.0, atol=1e-8)
    flat = turned_along(top, lambda s: (0 * s, 0 * s, 0 * s), knots)
    np.testing.assert_allclose(flat.point(s), top.point(s), rtol=0.0, atol=1e-13)


def test_corners_and_labels_of_a_turned_curve_stay() -> None:
    first = arc((0.0, 5.0), 3.0, 1.7, 1.0)._replace(label="fillet")
    second = arc((0.0, 5.0), 3.0, 1.0, 0.3, corner_before=True)
    curve = fit_flank_curve([first, second], corner_at_end=True)
    middle = curve.range_of("flank")[0]
    knots = np.array([0.1, middle, middle + 0.2])
    turned = turned_along(curve, lambda s: (0 * s, 0 * s, 0 * s), knots)
    assert turned.range_of("flank") == curve.range_of("flank")
    np.testing.assert_array_equal(turned.breaks[turned.corners], curve.breaks[curve.corners])
