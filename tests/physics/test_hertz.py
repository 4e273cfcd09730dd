"""Line contact of two cylinders through the whole core against Hertz's closed form."""

from __future__ import annotations

import numpy as np
import pytest

from flankload.scene.discretization import Grid
from tests.support.pressed_cylinders import CASE, LEVER, contact


def half_width(state) -> float:
    """Half-width from the zero of the parabola through the squared pressures, within a cell."""
    _, table = state.pairs.at(0)
    x, squared = table[:, 3] - LEVER, (table[:, 7] / table[:, 8]) ** 2
    inside = np.abs(x) < 0.8 * np.abs(x[squared > 0]).max()
    curvature, slope, top = np.polyfit(x[inside], squared[inside], 2)
    return float(np.sqrt(slope**2 - 4 * curvature * top) / (2 * abs(curvature)))


@pytest.mark.parametrize("load", [0.1, 1.0])
def test_pressure_and_half_width_are_those_of_hertz(load: float) -> None:
    state = contact(load * CASE["line_load_N_per_mm"], Grid())
    scale = np.sqrt(load)
    assert state.site_peak_N_per_mm[0, 0] == pytest.approx(
        scale * CASE["peak_pressure_MPa"], rel=5e-3
    )
    assert half_width(state) == pytest.approx(scale * CASE["half_width_mm"], rel=5e-3)
    assert state.site_force_N[0, 0] == pytest.approx(load * CASE["line_load_N_per_mm"], rel=1e-4)


def test_pressure_converges_with_the_cells() -> None:
    """Error against Hertz below 0.05 (d/b)^1.5 over a factor of eight in the cell width."""
    for strips in (4, 8, 16, 32):
        state = contact(CASE["line_load_N_per_mm"], Grid(strips_per_half_width=strips))
        error = abs(state.site_peak_N_per_mm[0, 0] / CASE["peak_pressure_MPa"] - 1)
        assert error < 0.05 * strips**-1.5


def test_contact_at_rest_has_no_force_outside() -> None:
    state = contact(CASE["line_load_N_per_mm"], Grid())
    _, table = state.pairs.at(0)
    outside = np.abs(table[:, 3] - LEVER) > 1.05 * CASE["half_width_mm"]
    assert outside.any()
    assert not table[outside, 7].any()
    assert (table[outside, 9] > 0).all()
