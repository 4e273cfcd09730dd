"""Functions of z in which the displacements of a prism are written: orthonormal Legendre.

    phi_k(z) = sqrt((2k + 1)/b) P_k(xi), xi in [-1, 1] over the width b, k = 0 ... p

With these M = 1, a load over P_b(xi) meets phi_b alone, and to keep the degrees up to q on a cut is
to keep its first q + 1 coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legvander

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class AxialBasis:
    """Polynomials of degree p over the width of a prism.

    Attributes
    ----------
    range_mm : (float, float)
        The width, along the axis.
    degree : int
        p.
    """

    range_mm: tuple[float, float]
    degree: int

    @property
    def count(self) -> int:
        """Number of functions, p + 1."""
        return self.degree + 1

    @property
    def width_mm(self) -> float:
        """b."""
        return self.range_mm[1] - self.range_mm[0]

    @property
    def mixed(self) -> Floats:
        """D1, integral of phi_a phi_b' dz, (p + 1, p + 1), 1/mm.

        With P_b' = sum of (2k + 1) P_k over k = b - 1, b - 3, ... the entries are
        2 sqrt((2a + 1)(2b + 1))/b for a < b and odd a + b, else 0.
        """
        k = np.arange(self.count)
        root = np.sqrt(2.0 * k + 1.0)
        meets = (k[:, None] < k) & ((k[:, None] + k) % 2 == 1)
        return np.where(meets, 2.0 / self.width_mm * np.outer(root, root), 0.0)

    @property
    def terms(self) -> Floats:
        """M, D1, D1' and S1 = integral of phi_a' phi_b' dz, (4, p + 1, p + 1).

        A derivative has lower degree, so it is exact in the basis: S1 = D1' D1.
        """
        mixed = self.mixed
        return np.stack([np.eye(self.count), mixed, mixed.T, mixed.T @ mixed])

    def load_vectors(self, degree: int) -> Floats:
        """Integrals of phi_k P_b(xi) dz for b = 0 ... degree, (p + 1, degree + 1), sqrt(mm)."""
        return np.eye(self.count, degree + 1) * np.sqrt(mode_norms_z(self.width_mm, degree))

    def values(self, z: Floats) -> Floats:
        """phi_k at places z (n,), mm: (n, p + 1), 1/sqrt(mm)."""
        low, high = self.range_mm
        legendre = legvander((2.0 * np.asarray(z) - low - high) / (high - low), self.degree)
        return np.asarray(legendre * np.sqrt((2.0 * np.arange(self.count) + 1.0) / self.width_mm))


def mode_norms_z(width_mm: float, degree: int) -> Floats:
    """Integrals of P_b(xi)² dz, mm: b/(2b + 1), (degree + 1,)."""
    return np.asarray(width_mm / (2.0 * np.arange(degree + 1) + 1.0))
