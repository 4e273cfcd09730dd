"""Pressure modes and the analytic near field against quadrature and strips."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import toeplitz

from flankload.elasticity.near_field import (
    logarithm_strength,
    mode_loads,
    mode_norms,
    mode_values,
    projected_logarithm,
)
from tests.support.cells_near_field import strip_kernel
from tests.support.plane_sectors import STEEL, ring_sector
from tests.support.tolerances import ROUND_OFF, SOLVER


@pytest.mark.parametrize("closed", [False, True])
def test_modes_are_orthogonal_with_the_stated_norms(*, closed: bool) -> None:
    span, n_modes = (1.5, 8.25), 7
    points, weights = np.polynomial.legendre.leggauss(40)
    half = 0.5 * (span[1] - span[0])
    values = mode_values(span[0] + half * (points + 1), span, n_modes, closed=closed)
    gram = values.T @ (half * weights[:, None] * values)
    norms = mode_norms(span, n_modes, closed=closed)
    np.testing.assert_allclose(gram, np.diag(norms), rtol=0, atol=1e-13)


def test_projected_logarithm_is_the_limit_of_strips() -> None:
    """1200 strips, extrapolated: their own error falls with the square of the width."""
    length, n_modes = 7.3, 7
    exact = projected_logarithm(n_modes, length)
    sums = []
    for strips in (600, 1200):
        cell = length / strips
        s = (np.arange(strips) + 0.5) * cell
        kernel = toeplitz(strip_kernel(s - s[0], cell, -1.0))
        values = mode_values(s, (0.0, length), n_modes)
        sums.append(values.T @ kernel @ values * cell**2)
    error = np.abs(sums[1] - exact).max() / np.abs(exact).max()
    assert error < 1e-5
    extrapolated = sums[1] + (sums[1] - sums[0]) / 3
    assert np.abs(extrapolated - exact).max() < 0.2 * error * np.abs(exact).max()


@pytest.mark.parametrize(("a", "b"), [(0, 0), (0, 2), (1, 1), (2, 2), (1, 3), (2, 3)])
def test_projected_logarithm_agrees_with_quadrature(a: int, b: int) -> None:
    length = 3.0
    legendre = [np.polynomial.legendre.Legendre.basis(k, [0, length]) for k in (a, b)]

    def inner(s: float) -> float:
        """Both sides of the logarithm's pole, with quadpack's weight for it."""
        value = 0.0
        if s > 0.0:
            value += quad(legendre[1], 0.0, s, weight="alg-logb", wvar=(0, 0))[0]
        if s < length:
            value += quad(legendre[1], s, length, weight="alg-loga", wvar=(0, 0))[0]
        return value

    found, _ = quad(lambda s: legendre[0](s) * inner(s), 0.0, length, epsabs=1e-9)
    assert projected_logarithm(4, length)[a, b] == pytest.approx(found, abs=1e-7)


def test_unit_of_length_changes_only_the_constant_mode() -> None:
    """K = -ln(s) in other units is K plus a constant, which affects only P_0."""
    ratio, length = 25.4, 2.0
    scaled = projected_logarithm(5, ratio * length) / ratio**2
    expected = projected_logarithm(5, length)
    expected[0, 0] += np.log(ratio) * length**2
    np.testing.assert_allclose(scaled, expected, rtol=0, atol=1e-12)


def test_strip_kernel_is_the_mean_of_the_logarithm() -> None:
    for distance in (0.0, 0.3, 1.0, 5.0):
        mean, _ = quad(lambda t, x=distance: -np.log(abs(x - t)), -0.5, 0.5, points=[0.0, 0.3, 0.5])
        assert strip_kernel(np.array(distance), 1.0, 1.0) == pytest.approx(mean, abs=1e-7)


def test_mode_loads_carry_the_resultant_of_their_pressure() -> None:
    """Sum of the nodal loads = integral of P_a n ds, along x and y, for every mode."""
    mesh, span = ring_sector(7, columns=12)
    loads = mode_loads(mesh, span, 4).reshape(-1, 2, 4)
    edges = mesh.flank_edges
    total = np.zeros((2, 4))
    points, weights = np.polynomial.legendre.leggauss(24)
    for first, last, middle in edges:
        shape = np.stack([points * (points - 1) / 2, points * (points + 1) / 2, 1 - points**2], 1)
        slope = np.stack([points - 0.5, points + 0.5, -2 * points], 1)
        nodes = [first, last, middle]
        along = slope @ mesh.nodes[nodes]
        modes = mode_values(shape @ mesh.flank_arc_length[nodes], span, 4)
        normal = np.stack([-along[:, 1], along[:, 0]], 1)
        total += np.einsum("g,gd,ga->da", weights, normal, modes)
    np.testing.assert_allclose(loads.sum(axis=0), total, rtol=0, atol=SOLVER)
    outside = np.setdiff1d(np.arange(len(mesh.nodes)), edges)
    assert not loads[outside].any()
    # the flank's normal points out of the material: away from the axis on this rim
    assert np.sum(loads[edges[3], :, 0] * mesh.nodes[edges[3]]) > 0


def test_logarithm_strength_of_both_plane_states() -> None:
    strain, stress = (logarithm_strength(STEEL, plane) for plane in ("strain", "stress"))
    assert stress == pytest.approx(2 / (np.pi * 206000.0), rel=ROUND_OFF)
    assert strain / stress == pytest.approx(1 - 0.3**2, rel=ROUND_OFF)
