"""Curves through positions: exact on cubics, kinks where both sides meet, doubt that is enough."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flankload.analysis.adaptive_positions import Window
from flankload.analysis.sampling_error import between_positions
from flankload.contact.sweep import UnloadedStates
from flankload.result.interpolant import curve_through, loaded_pair_changes
from tests.support.tolerances import ROUND_OFF

PERIOD = 0.4


def uneven(n: int, seed: int = 5) -> np.ndarray:
    """Ascending positions in a period, the first at 0."""
    return np.append(0.0, np.sort(np.random.default_rng(seed).uniform(0, PERIOD, n - 1)))


def broken_line(x: np.ndarray, kinks: tuple[float, ...], values: tuple[float, ...]) -> np.ndarray:
    """Straight between kinks, closed over the period."""
    return np.interp(x, kinks, values, period=PERIOD)


def amplitudes_of_broken_line(
    kinks: tuple[float, ...], values: tuple[float, ...], orders: range
) -> np.ndarray:
    """Fourier amplitudes of a closed line, from the jumps of its slope."""
    place, height = np.array(kinks), np.array(values)
    slope = np.diff(height, append=height[0]) / np.diff(place, append=place[0] + PERIOD)
    jump = slope - np.roll(slope, 1)
    wave = 2 * np.pi / PERIOD
    return np.array(
        [
            2 / PERIOD * abs((jump * np.exp(-1j * k * wave * place)).sum()) / (k * wave) ** 2
            for k in orders
        ]
    )


def test_cubic_is_met_exactly_without_a_period() -> None:
    x = uneven(9)
    cubic = np.polynomial.Polynomial([1.0, -3.0, 20.0, 90.0])
    curve = curve_through(x, cubic(x), np.zeros(9, dtype=bool))
    where = np.linspace(0.0, x[-1], 57)
    np.testing.assert_allclose(curve.values(where), cubic(where), rtol=0, atol=10 * ROUND_OFF)
    integral = cubic.integ()
    expected = (integral(x[-1]) - integral(0.0)) / x[-1]
    assert curve.mean() == pytest.approx(expected, rel=ROUND_OFF)
    # the doubt is the whole cubic term: the error of a parabola through three of the points
    assert curve.doubt_integrals().min() > 0
    parabola = curve_through(x, 1 + x**2, np.zeros(9, dtype=bool))
    assert parabola.doubt_integrals().max() < ROUND_OFF


def test_harmonics_of_a_line_with_kinks_are_exact() -> None:
    """Four kinks, none of them at a position: both sides are known to be straight."""
    kinks, values = (0.03, 0.11, 0.24, 0.33), (1.0, 4.0, -2.0, 2.5)
    x = PERIOD * np.arange(24) / 24
    stretch = np.searchsorted(kinks, x) % 4
    changes = stretch != np.roll(stretch, -1)
    curve = curve_through(x, broken_line(x, kinks, values), changes, period_rad=PERIOD)
    found = curve.kinks()
    np.testing.assert_allclose(found[~np.isnan(found)], kinks, rtol=0, atol=ROUND_OFF)
    np.testing.assert_allclose(
        curve.amplitudes(range(1, 8)),
        amplitudes_of_broken_line(kinks, values, range(1, 8)),
        rtol=0,
        atol=100 * ROUND_OFF,
    )
    overlooked = curve_through(
        x, broken_line(x, kinks, values), np.zeros(24, dtype=bool), period_rad=PERIOD
    )
    wrong = np.abs(overlooked.amplitudes([1]) - curve.amplitudes([1]))[0]
    assert wrong > 1e-4
    assert 2 / PERIOD * overlooked.doubt_integrals().sum() > wrong


def test_even_cosine_has_its_amplitude_at_fourth_order() -> None:
    errors, doubts = [], []
    for n in (16, 32, 64):
        x = PERIOD * np.arange(n) / n
        y = 3 + 2 * np.cos(2 * np.pi * x / PERIOD + 0.4)
        curve = curve_through(x, y, np.zeros(n, dtype=bool), period_rad=PERIOD)
        errors.append(abs(curve.amplitudes([1])[0] - 2))
        doubts.append(2 / PERIOD * curve.doubt_integrals().sum())
        assert curve.mean() == pytest.approx(3, rel=ROUND_OFF)
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(rates, 4.0, rtol=0, atol=0.2)
    assert all(doubt > error for doubt, error in zip(doubts, errors, strict=True))


@pytest.mark.parametrize("seed", range(6))
def test_doubt_bounds_the_error_of_random_curves(seed: int) -> None:
    """Smooth stretches between the kinks that pairs cause, at uneven positions."""
    rng = np.random.default_rng(seed)
    kinks = np.sort(rng.uniform(0, PERIOD, 3))
    phase, height = rng.uniform(0, 6, 2), rng.uniform(1, 3, 2)

    def exact(x: np.ndarray) -> np.ndarray:
        line = broken_line(x, tuple(kinks), (0.0, 1.0, -0.5))
        waves = sum(
            h * np.sin((k + 1) * 2 * np.pi * x / PERIOD + p)
            for k, (h, p) in enumerate(zip(height, phase, strict=True))
        )
        return np.asarray(line + waves)

    x = uneven(40, seed)
    stretch = np.searchsorted(kinks, x) % 3
    changes = stretch != np.roll(stretch, -1)
    curve = curve_through(x, exact(x), changes, period_rad=PERIOD)
    dense = PERIOD * np.arange(2**15) / 2**15
    wanted = 2 / dense.size * np.abs(np.fft.rfft(exact(dense)))[1:6]
    bound = 2 / PERIOD * curve.doubt_integrals().sum()
    assert np.abs(curve.amplitudes(range(1, 6)) - wanted).max() < bound
    least, greatest = curve.bounds()
    # between the places that bounds look at, a parabola goes on by this much
    unseen = np.ptp(exact(dense)) * 1e-3
    assert least.min() <= exact(dense).min() + unseen
    assert greatest.max() >= exact(dense).max() - unseen


def test_single_point_between_two_kinks_is_in_doubt() -> None:
    """Regression: the peak of a section with a single position was overlooked."""
    x = PERIOD * np.arange(16) / 16
    y = np.where(np.arange(16) == 5, 1.0, 0.0)
    changes = np.isin(np.arange(16), [4, 5])
    curve = curve_through(x, y, changes, period_rad=PERIOD)
    assert np.isnan(curve.kinks()).all()
    np.testing.assert_allclose(curve.doubt_integrals()[[4, 5]], PERIOD / 16, rtol=ROUND_OFF, atol=0)


def test_step_of_a_stiffness_is_found_at_the_kink_of_the_rotation() -> None:
    """A stiffness that rises evenly and falls where one pair gives way to the next.

    With the step at a part f of its interval, n samples miss (1/2 - f)/n of it in the mean.
    """
    n, kink = 24, 0.03
    x = PERIOD * np.arange(n) / n
    along = np.mod((x - kink) / PERIOD, 1.0)
    before = x < kink
    part = SimpleNamespace(
        site_force_N=np.stack([~before, before], axis=1).astype(float),
        slices=SimpleNamespace(plane=True, force_N=np.stack([~before, before], axis=1)[..., None]),
        rotation_rad=3.0 + along * (1.0 - along),
        turned_rad=np.full(n, -1.0),
        tangent_rad_per_Nmm=1.0 / (2.0 + along),
    )
    window = Window(PERIOD, 1, closed=True, sites=np.array([-1, 0]), cyclic=False)
    error, doubt = between_positions(part, window, x)["stiffness_tangent"]  # type: ignore[arg-type]
    missed = np.mean(2.0 + along) - 2.5
    assert missed == pytest.approx((0.5 - 0.8) / n, rel=ROUND_OFF)
    # between two samples it falls by its rise over one interval less
    assert error * np.mean(2.0 + along) == pytest.approx((1 - 1 / n) * missed, rel=1e-9)
    assert doubt > abs(error - missed / 2.5)


@pytest.mark.parametrize("adaptive", [False, True])
def test_secant_stiffness_has_a_kink_where_another_pair_touches_without_torque(
    adaptive: bool,
) -> None:
    """Regression: the mean was reported as exact, since the rotation has no kink there."""
    n, kink, loaded = 24, 0.035, 0.21
    x = PERIOD * np.arange(n) / n
    along = [np.mod((x - at) / PERIOD, 1.0) for at in (kink, loaded)]
    secant = 1.0 + sum(part * (1.0 - part) for part in along)
    sites = [np.stack([x >= at, x < at], axis=1) for at in (kink, loaded)]
    part = SimpleNamespace(
        site_force_N=sites[1].astype(float),
        slices=SimpleNamespace(plane=True, force_N=sites[1][..., None]),
        unloaded=UnloadedStates(np.zeros(n), sites[0]),
        rotation_rad=3.0 + np.cos(2 * np.pi * x / PERIOD),
        turned_rad=1.0 / secant,
        tangent_rad_per_Nmm=np.full(n, -1.0),
    )
    window = Window(PERIOD, 1, closed=True, sites=np.array([-1, 0]), cyclic=False)
    found = between_positions(part, window, x, adaptive=adaptive)  # type: ignore[arg-type]
    mean = secant.mean()
    if adaptive:
        mean = window.curve_of(x, secant, window.changes(sites[1])).mean()
    error, doubt = found["stiffness_secant"]
    assert error == pytest.approx(1.0 - (1.0 + 2.0 / 6.0) / mean, rel=1e-6)
    assert doubt >= 0.5 * abs(error) > 0
    assert ("transmission_error_peak_to_peak" in found) is not adaptive


def test_pairs_move_up_over_a_period() -> None:
    sites = np.array([-1, 0, 1])
    loaded = np.array([[0, 1, 0], [1, 1, 0], [1, 0, 0]], dtype=bool)
    changes = loaded_pair_changes(loaded, sites, pitches=1)
    np.testing.assert_array_equal(changes, [True, True, False])
    # the third, a period later
    later = np.array([[0, 1, 0], [1, 0, 0]], dtype=bool)
    changes = loaded_pair_changes(later, sites, pitches=1, periods=np.array([0, 1]))
    np.testing.assert_array_equal(changes, [False, True])
    # all around: tooth 2 is beside tooth 0
    circle = np.array([[1, 0, 0], [0, 0, 1]], dtype=bool)
    changes = loaded_pair_changes(circle, np.arange(3), pitches=1, cyclic=True)
    np.testing.assert_array_equal(changes, [True, False])
    # the one flank of a cam is its own neighbour
    cam = np.ones((3, 1), dtype=bool)
    changes = loaded_pair_changes(cam, np.array([0]), pitches=1, cyclic=True)
    np.testing.assert_array_equal(changes, False)
