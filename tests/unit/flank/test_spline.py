"""Interpolating splines compared with those of scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_interp_spline

from flankload.bodies.cam.cam import _closed_spline
from flankload.flank import interpolating_spline
from tests.support.tolerances import ROUND_OFF


def uneven(n: int) -> np.ndarray:
    """Ascending places whose distances differ by up to ten times, from 0 to 1."""
    places = np.cumsum(np.random.default_rng(n).uniform(0.1, 1.0, n))
    return (places - places[0]) / (places[-1] - places[0])


@pytest.mark.parametrize(
    ("n", "degree"), [(2, 3), (3, 3), (4, 3), (5, 3), (40, 3), (6, 5), (7, 5), (40, 5)]
)
def test_a_spline_is_that_of_scipy(n: int, degree: int) -> None:
    """Values and two derivatives, also beyond the ends; two and three places have a polynomial."""
    places = uneven(n)
    values = np.random.default_rng(1).normal(size=(n, 2))
    if degree == 3:
        expected = CubicSpline(places, values)
    else:
        expected = make_interp_spline(places, values, k=degree)
    u = np.append(np.linspace(-0.05, 1.05, 200), places)
    for order, found in enumerate(interpolating_spline(places, values, degree).derivatives(u)):
        wanted = expected(u, order)
        np.testing.assert_allclose(
            found, wanted, rtol=0, atol=ROUND_OFF * np.abs(wanted).max(initial=1.0)
        )


@pytest.mark.parametrize("rows", [13, 90])
def test_the_profile_of_a_cam_is_the_periodic_spline_of_scipy(rows: int) -> None:
    angle = 0.3 + 2 * np.pi * uneven(rows)
    radius = np.random.default_rng(2).uniform(20.0, 30.0, rows)
    radius[-1] = radius[0]
    expected = CubicSpline(angle, radius, bc_type="periodic")
    u = np.linspace(angle[0], angle[-1], 300)
    out = np.stack([np.cos(u), np.sin(u)], axis=1)
    along = np.stack([-np.sin(u), np.cos(u)], axis=1)
    r, r_1, r_2 = (expected(u, order)[:, None] for order in range(3))
    for found, wanted in zip(
        _closed_spline(angle, radius)(u),
        (r * out, r_1 * out + r * along, (r_2 - r) * out + 2 * r_1 * along),
        strict=True,
    ):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=ROUND_OFF * np.abs(wanted).max())
