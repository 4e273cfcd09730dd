"""Axial shape functions of the displacements of a prism: orthonormal Legendre polynomials.

    phi_k(z) = sqrt((2k + 1)/b) P_k(xi), xi in [-1, 1] over the width b, k = 0 ... p

M = 1, a load over P_b(xi) acts on phi_b only, and the degrees up to q on a cut are its first q + 1
coefficients.

With regions of different widths (`AxialRegions`), a node has the functions of the widest region
that contains it; polynomials of the whole width would be nearly dependent on a thin web. Elements
of a region integrate over its width, with the functions of their nodes. On a seam, where narrower
regions end, the last functions are made of powers of the distance beyond their ends,

    (z - z_hi)^k -+ (z_lo - z)^k, k = 1, 2, each base at least 0                            (R2b)
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legvander

from flankload.base.gauss import leggauss
from flankload.bodies.axial_shape import share_middle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import SectorMesh, WholeMesh
    from flankload.elasticity.finite_elements import SectionStiffness

#: Exponents of (R2b), and least degree of the polynomials beside these functions.
POWERS, LEAST_DEGREE = (1, 2), 2
#: Ends of ranges are the same up to this part of the width.
SAME_END = 1e-3


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
    """Polynomials of degree p over the width of a prism, or p + 1 functions with kinks.

    Attributes
    ----------
    range_mm : (float, float)
        Axial range.
    degree : int
        p.
    inside_mm : tuple of (float, float)
        Axial ranges of narrower regions, at whose ends derivatives may jump.
    """

    range_mm: tuple[float, float]
    degree: int
    inside_mm: tuple[tuple[float, float], ...] = ()

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

        For polynomials, P_b' = sum of (2k + 1) P_k over k = b - 1, b - 3, ..., the entries are
        2 sqrt((2a + 1)(2b + 1))/b for a < b and odd a + b, else 0.
        """
        if self.inside_mm:
            return np.asarray(self.terms[1])
        k = np.arange(self.count)
        root = np.sqrt(2.0 * k + 1.0)
        meets = (k[:, None] < k) & ((k[:, None] + k) % 2 == 1)
        return np.where(meets, 2.0 / self.width_mm * np.outer(root, root), 0.0)

    @property
    def terms(self) -> Floats:
        """M, D1, D1' and S1 = integral of phi_a' phi_b' dz, (4, p + 1, p + 1)."""
        if self.inside_mm:
            return _integrals(self, self, self)
        mixed = self.mixed
        return np.stack([np.eye(self.count), mixed, mixed.T, mixed.T @ mixed])

    def load_vectors(self, degree: int) -> Floats:
        """Integrals of phi_k P_b(xi) dz for b = 0 ... degree, (p + 1, degree + 1), sqrt(mm)."""
        return np.eye(self.count, degree + 1) * np.sqrt(mode_norms_z(self.width_mm, degree))

    def values(self, z: Floats) -> Floats:
        """phi_k at z (n,), mm: (n, p + 1), 1/sqrt(mm)."""
        if self.inside_mm:
            return np.asarray(self._raw(z, 0) @ self._orthonormal)
        low, high = self.range_mm
        legendre = legvander((2.0 * np.asarray(z) - low - high) / (high - low), self.degree)
        return np.asarray(legendre * np.sqrt((2.0 * np.arange(self.count) + 1.0) / self.width_mm))

    def derivatives(self, z: Floats) -> Floats:
        """phi_k' at z (n,), mm: (n, p + 1), 1/mm^(3/2)."""
        if self.inside_mm:
            return np.asarray(self._raw(z, 1) @ self._orthonormal)
        return self.values(z) @ self.mixed  # phi_b' is the sum of D1[a, b] phi_a

    def means(self, spans: Floats) -> Floats:
        """Means of phi_k over spans (n, 2) along z, mm: (n, p + 1), 1/sqrt(mm)."""
        points, weights = leggauss(self.degree // 2 + 1)
        middle, half = spans.mean(axis=1), 0.5 * np.diff(spans, axis=1)[:, 0]
        places = middle[:, None] + half[:, None] * points
        values = self.values(places.ravel()).reshape(*places.shape, self.count)
        return np.asarray(np.einsum("g,ngk->nk", 0.5 * weights, values))

    @cached_property
    def _orthonormal(self) -> Floats:
        """Orthonormal combinations (p + 1, p + 1) of `_raw`, each with those before it."""
        z, weights = _gauss((self,), self.range_mm, self.count)
        upper = np.linalg.qr(np.sqrt(weights)[:, None] * self._raw(z, 0), mode="r")
        return np.asarray(np.linalg.inv(upper) * np.sign(np.diagonal(upper)))

    def _raw(self, z: Floats, order: int) -> Floats:
        """Polynomials and powers (R2b) at z, or, with order 1, their derivatives: (n, p + 1).

        Functions are even or odd as their numbers are, if all ranges have the same middle.
        """
        (first, last), half = self.range_mm, 0.5 * self.width_mm
        pairs: list[list[Floats]] = []
        for k in POWERS:
            for low, high in self.inside_mm:
                beyond = ((z - high) / half, (low - z) / half)
                after, before = (np.maximum(each, 0.0) ** k for each in beyond)
                if order:
                    after, before = (
                        sign * k / half * each ** (k - 1) * (each > 0.0)
                        for sign, each in zip((1, -1), beyond, strict=True)
                    )
                least = SAME_END * self.width_mm
                at_low, at_high = low - first > least, last - high > least
                if at_low and at_high:
                    pairs.append([after - before, after + before])
                elif at_low or at_high:
                    pairs.append([after if at_high else before])
        kinks = min(sum(map(len, pairs)), max(self.degree - LEAST_DEGREE, 0))
        if (self.count - kinks) % 2 == 0:  # the next function is even
            pairs = [pair[::-1] for pair in pairs]
        polynomials = AxialBasis(self.range_mm, self.degree - kinks)
        found = polynomials.derivatives(z) if order else polynomials.values(z)
        return np.column_stack([found, *[part for pair in pairs for part in pair][:kinks]])


#: Functions of a plane body: constant displacements, per mm of width.
PLANE = AxialBasis((0.0, 1.0), 0)


@dataclass(frozen=True, eq=False)
class AxialRegions(AxialFunctions):
    """Functions of z of a body whose regions have different widths.

    Attributes
    ----------
    bases : tuple of AxialBasis
        Bases of one degree, those of the regions first, by their numbers, the widest first.
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
    if one == two and one.range_mm == over.range_mm:
        return one.terms
    return _integrals(one, two, over)


def _integrals(one: AxialBasis, two: AxialBasis, over: AxialBasis) -> Floats:
    """As `cross_terms`, by Gauss quadrature: exact."""
    z, weights = _gauss((one, two), over.range_mm, max(one.count, two.count))
    (a, slope_a), (b, slope_b) = ((part.values(z), part.derivatives(z)) for part in (one, two))
    pairs = ((a, b), (a, slope_b), (slope_a, b), (slope_a, slope_b))
    return np.stack([row.T * weights @ column for row, column in pairs])


def _gauss(
    bases: tuple[AxialBasis, ...], range_mm: tuple[float, float], count: int
) -> tuple[Floats, Floats]:
    """Points and weights of Gauss rules between the kinks of bases: exact to degree 2 count - 1."""
    low, high = range_mm
    kinks = np.array([end for basis in bases for extent in basis.inside_mm for end in extent])
    ends = np.unique([low, high, *kinks[(kinks > low) & (kinks < high)]])
    points, weights = leggauss(count)
    half, middle = 0.5 * np.diff(ends)[:, None], 0.5 * (ends[1:] + ends[:-1])[:, None]
    return (middle + half * points).ravel(), (half * weights).ravel()


def mode_norms_z(width_mm: float, degree: int) -> Floats:
    """Integrals of P_b(xi)² dz, mm: b/(2b + 1), (degree + 1,)."""
    return np.asarray(width_mm / (2.0 * np.arange(degree + 1) + 1.0))


def functions_of(
    mesh: SectorMesh | WholeMesh, axial: AxialBasis, extents_mm: Mapping[str, tuple[float, float]]
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
    touched = np.zeros((len(mesh.nodes), len(ranges)), dtype=bool)
    for own, (_, cells) in zip(numbers, mesh.cells, strict=True):
        touched[cells, own] = True
    bases, of_node = [AxialBasis(extent, axial.degree) for extent in ranges], touched.argmax(axis=1)
    seams, place = np.unique(touched, axis=0, return_inverse=True)
    for number, regions in enumerate(seams):  # of a seam the widest region, with kinks
        widest, *inside = np.flatnonzero(regions).tolist()
        if inside:
            of_node[place.ravel() == number] = len(bases)
            within = tuple(ranges[each] for each in inside)
            bases.append(AxialBasis(ranges[widest], axial.degree, within))
    return numbers, AxialRegions(tuple(bases), of_node)
