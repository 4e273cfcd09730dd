"""The polynomials of a prism's width against Gauss's rule."""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import Legendre, leggauss

from flankload.elasticity.axial_basis import AxialBasis
from tests.support.tolerances import ROUND_OFF

BASIS = AxialBasis((-3.0, 11.0), 7)


def _gauss() -> tuple[np.ndarray, np.ndarray]:
    points, weights = leggauss(BASIS.count + 4)
    return 4.0 + 7.0 * points, 7.0 * weights


def test_matrices_are_the_integrals_of_the_functions_and_their_slopes() -> None:
    z, weights = _gauss()
    values = BASIS.values(z)
    slopes = np.stack(
        [
            np.sqrt((2 * k + 1) / 14.0) * Legendre.basis(k, domain=BASIS.range_mm).deriv()(z)
            for k in range(BASIS.count)
        ],
        axis=1,
    )
    pairs = ((values, values), (values, slopes), (slopes, values), (slopes, slopes))
    for found, (one, two) in zip(BASIS.terms, pairs, strict=True):
        expected = one.T @ (weights[:, None] * two)
        np.testing.assert_allclose(found, expected, rtol=0, atol=ROUND_OFF * abs(expected).max())


def test_load_vectors_are_the_integrals_with_the_modes() -> None:
    z, weights = _gauss()
    modes = np.polynomial.legendre.legvander((z - 4.0) / 7.0, 4)
    expected = BASIS.values(z).T @ (weights[:, None] * modes)
    np.testing.assert_allclose(
        BASIS.load_vectors(4), expected, rtol=0, atol=ROUND_OFF * abs(expected).max()
    )
