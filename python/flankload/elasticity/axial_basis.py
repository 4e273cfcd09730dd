"""Axial shape functions of the displacements of a prism: orthonormal Legendre polynomials.

    phi_k(z) = sqrt((2k + 1)/b) P_k(xi), xi in [-1, 1] over the width b, k = 0 ... p

M = 1, a load over P_b(xi) acts on phi_b only, and the degrees up to q on a cut are its first q + 1
coefficients.

With regions of different widths (`AxialRegions`), a node has the functions of the widest region
that contains it; polynomials of the whole width would be nearly dependent on a thin web. Elements
of a region integrate over its width, with the functions of their nodes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legvander

from flankload.base.gauss import leggauss
from flankload.bodies.axial_shape import share_middle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import SectorMesh
    from flankload.elasticity.finite_elements import SectionStiffness


class AxialFunctions(ABC):
    """Functions of z of the nodes of a section, p + 1 per node."""

    @abstractmethod
    def of_nodes(self, nodes: Numbers) -> tuple[tuple[AxialBasis, ...], Numbers]:
        """Bases of one degree, the widest first, and number of the basis of each node (n,)."""

    @property
    def _bases(self) -> tuple[AxialBasis, ...]:
        return self.of_nodes(np.zeros(0, dtype=np.int64))[0]

    @property
    def count(self) -> int:
        """Number of functions of a node, p + 1."""
        return self._bases[0].degree + 1

    @property
    def symmetric(self) -> bool:
        """Whether each function is even or odd about one plane."""
        return share_middle([basis.range_mm for basis in self._bases])

    def products(self, section: SectionStiffness) -> tuple[Numbers, Floats]:
        """Axial matrices of each pair of nodes of a section, over the width of its region.

        Returns for each pair the number (n,) of its matrices, and the distinct matrices
        (k, 4, p + 1, p + 1), each as `AxialBasis.terms`.
        """
        bases, row = self.of_nodes(section.rows)
        _, column = self.of_nodes(section.columns)
        k = len(bases)
        used, number = np.unique((section.regions * k + row) * k + column, return_inverse=True)
        terms = [
            cross_terms(bases[code // k % k], bases[code % k], bases[code // k**2])
            for code in used.tolist()
        ]
        return number, np.stack(terms)


@dataclass(frozen=True)
class AxialBasis(AxialFunctions):
    """Polynomials of degree p over the width of a prism.

    Attributes
    ----------
    range_mm : (float, float)
        Axial range.
    degree : int
        p.
    """

    range_mm: tuple[float, float]
    degree: int

    def of_nodes(self, nodes: Numbers) -> tuple[tuple[AxialBasis, ...], Numbers]:
        """The same functions for all nodes."""
        return (self,), np.zeros(nodes.size, dtype=np.int64)

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
        """M, D1, D1' and S1 = integral of phi_a' phi_b' dz = D1' D1, (4, p + 1, p + 1)."""
        mixed = self.mixed
        return np.stack([np.eye(self.count), mixed, mixed.T, mixed.T @ mixed])

    def load_vectors(self, degree: int) -> Floats:
        """Integrals of phi_k P_b(xi) dz for b = 0 ... degree, (p + 1, degree + 1), sqrt(mm)."""
        return np.eye(self.count, degree + 1) * np.sqrt(mode_norms_z(self.width_mm, degree))

    def values(self, z: Floats) -> Floats:
        """phi_k at z (n,), mm: (n, p + 1), 1/sqrt(mm)."""
        low, high = self.range_mm
        legendre = legvander((2.0 * np.asarray(z) - low - high) / (high - low), self.degree)
        return np.asarray(legendre * np.sqrt((2.0 * np.arange(self.count) + 1.0) / self.width_mm))

    def derivatives(self, z: Floats) -> Floats:
        """phi_k' at z (n,), mm: (n, p + 1), 1/mm^(3/2)."""
        return self.values(z) @ self.mixed  # phi_b' is the sum of D1[a, b] phi_a

    def means(self, spans: Floats) -> Floats:
        """Means of phi_k over spans (n, 2) along z, mm: (n, p + 1), 1/sqrt(mm)."""
        points, weights = leggauss(self.degree // 2 + 1)
        middle, half = spans.mean(axis=1), 0.5 * np.diff(spans, axis=1)[:, 0]
        places = middle[:, None] + half[:, None] * points
        values = self.values(places.ravel()).reshape(*places.shape, self.count)
        return np.asarray(np.einsum("g,ngk->nk", 0.5 * weights, values))


#: Functions of a plane body: constant displacements, per mm of width.
PLANE = AxialBasis((0.0, 1.0), 0)


@dataclass(frozen=True, eq=False)
class AxialRegions(AxialFunctions):
    """Functions of z of a body whose regions have different widths.

    Attributes
    ----------
    bases : tuple of AxialBasis
        Bases of one degree, the widest first.
    of_node : (N,) array
        Number of the basis of each node.
    """

    bases: tuple[AxialBasis, ...]
    of_node: Numbers

    def of_nodes(self, nodes: Numbers) -> tuple[tuple[AxialBasis, ...], Numbers]:
        """Functions of the widest region that contains each node."""
        return self.bases, self.of_node[nodes]


def cross_terms(one: AxialBasis, two: AxialBasis, over: AxialBasis) -> Floats:
    """Integrals of a b, a b', a' b and a' b' over a width: (4, p + 1, p + 1).

    a: functions of basis `one` (rows), b: of `two`, over the width of `over`.
    """
    if one.range_mm == two.range_mm == over.range_mm:
        return one.terms
    points, weights = leggauss(max(one.count, two.count))  # exact to degree 2 p + 1
    low, high = over.range_mm
    z, weights = 0.5 * (low + high + (high - low) * points), 0.5 * (high - low) * weights
    (a, slope_a), (b, slope_b) = ((part.values(z), part.derivatives(z)) for part in (one, two))
    pairs = ((a, b), (a, slope_b), (slope_a, b), (slope_a, slope_b))
    return np.stack([row.T * weights @ column for row, column in pairs])


def mode_norms_z(width_mm: float, degree: int) -> Floats:
    """Integrals of P_b(xi)² dz, mm: b/(2b + 1), (degree + 1,)."""
    return np.asarray(width_mm / (2.0 * np.arange(degree + 1) + 1.0))


def functions_of(
    mesh: SectorMesh, axial: AxialBasis, extents_mm: Mapping[str, tuple[float, float]]
) -> tuple[tuple[int, ...], AxialFunctions]:
    """Region of each entry of the mesh's cells, and the functions of its nodes.

    `axial`: functions over the width of the teeth; `extents_mm`: axial ranges of named regions;
    others are as wide as the teeth. The ranges of regions that share nodes are nested.
    """
    of_cells = [extents_mm.get(name, axial.range_mm) for name in mesh.regions]
    if all(extent == axial.range_mm for extent in of_cells):
        return (0,) * len(mesh.cells), axial
    ranges = sorted({axial.range_mm, *of_cells}, key=lambda extent: extent[0] - extent[1])
    numbers = tuple(ranges.index(extent) for extent in of_cells)
    of_node = np.zeros(len(mesh.nodes), dtype=np.int64)
    for number in range(len(ranges) - 1, -1, -1):  # wider regions after narrower ones
        for own, (_, cells) in zip(numbers, mesh.cells, strict=True):
            if own == number:
                of_node[cells] = number
    return numbers, AxialRegions(
        tuple(AxialBasis(extent, axial.degree) for extent in ranges), of_node
    )
