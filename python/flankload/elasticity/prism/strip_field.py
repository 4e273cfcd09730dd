"""Displacement of a body under forces on strips of its flanks, in slices, for conforming flanks.

The displacement of a strip under a force on another one is (S1) of `docs/theory/slices.md` with the
mean (S3) of 1/R; the logarithm of x is the mean logarithm of the distances of their points.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import legint, legval

from flankload.elasticity.near_field import mode_values

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.elasticity.compliance import BodyCompliance

#: Distance, over the length of segments, above which second moments suffice, to 1e-5 of the mean.
FAR = 10.0


@dataclass(frozen=True, eq=False)
class StripField:
    """Displacement field of a body under forces on N strips of J slices.

    Attributes
    ----------
    along : (N, n_s) array
        Modes along the profile at the strips.
    over : (J, n_z) array
        Means of the modes along the axis over the slices.
    near : (N, J, J) array
        Near field of strips at a distance n, with the images behind end faces, mm/N.
    corners, corners_along : (2, N, N, J, J) or empty arrays
        Images behind free corners, of normal forces and of those along the profile.
    weight : (J,) array
        Width of each slice over the common width.
    """

    compliance: BodyCompliance
    teeth: int
    along: Floats
    over: Floats
    near: Floats
    corners: Floats
    corners_along: Floats
    weight: Floats

    @classmethod
    def of(
        cls, compliance: BodyCompliance, teeth: int, s_mm: Floats, strip_mm: float, edges_mm: Floats
    ) -> StripField:
        """Field of a body in three dimensions.

        For strips with middles (N,) along the profile and equal widths, in slices between edges
        (J + 1,).
        """
        modes, s = compliance.modes, s_mm
        width, z = np.diff(edges_mm), 0.5 * (edges_mm[1:] + edges_mm[:-1])
        axial = modes.axial
        n_s = compliance.smooth.shape[1] // axial.count
        k = 0.5 * compliance.near.kernel
        apart = strip_distances(s.size, strip_mm)[:, None, None]
        lengths = width[:, None], width[None, :]
        near = mean_potential(z[:, None] - z, *lengths, apart)
        for end, strength in zip(axial.range_mm, axial.end, strict=True):
            if strength:
                image = z[:, None] + z - 2.0 * end
                near = near + strength * mean_potential(image, *lengths, apart)

        def behind_corners(strengths: tuple[float, float]) -> Floats:
            images = np.zeros((0, s.size, s.size, *near.shape[1:]))
            for place, strength in zip(modes.range_mm, strengths, strict=True):
                if strength:
                    from_corner = np.abs(s - place)
                    apart = (from_corner[:, None] + from_corner)[..., None, None]
                    image = strength * k * mean_potential(z[:, None] - z, *lengths, apart)
                    images = np.concatenate([images, image[None]])
            return images

        has_friction = compliance.tangential is not None
        return cls(
            compliance=compliance,
            teeth=teeth,
            along=mode_values(s, modes.range_mm, n_s, tip=modes.tip),
            over=_axial_means(axial.range_mm, axial.count, edges_mm),
            near=k * near,
            corners=behind_corners(compliance.near.wedge),
            corners_along=behind_corners(compliance.near.wedge_along if has_friction else (0, 0)),
            weight=width / width.sum(),
        )

    def of_even_load(self) -> Floats:
        """Mean displacement of strips (N, N) over all slices under uniform loads on all teeth."""
        modes = np.einsum("ia,b->iab", self.along, self.weight @ self.over)
        modes = modes.reshape(len(self.along), -1)
        found = modes @ self.compliance.smooth.sum(axis=0) @ modes.T
        number = np.arange(len(self.along))
        near = np.einsum("njk,j,k->n", self.near, self.weight, self.weight)
        found += near[np.abs(number[:, None] - number)]
        found += np.einsum("cihjk,j,k->ih", self.corners, self.weight, self.weight)
        return np.asarray(found)

    def expansion(self, shifts: Floats) -> Floats:
        """Displacements (n, N, J) of the strips in all slices, from mode coefficients (n, p)."""
        modes = shifts.reshape(len(shifts), self.along.shape[1], self.over.shape[1])
        return np.asarray(np.einsum("ia,sab,jb->sij", self.along, modes, self.over))

    def between_sites(
        self, spread: Floats, teeth: Numbers, n_working: int, *, along: bool = False
    ) -> Floats:
        """Compliance (S, J, S, J) between slices with forces that are distributed over strips.

        Parameters
        ----------
        spread : (N,) array
            Part of the force on each strip.
        teeth, n_working : (S,) array and int
            Teeth of the sites, `n_working` of working flanks, then those of coast flanks.
        along : bool
            Normal displacements under forces along the profile, towards increasing arc length,
            instead of normal forces. The field of Cerruti (S4) is antisymmetric: with the same
            distribution of both its mean is 0.
        """
        modes = np.einsum("a,jb->jab", spread @ self.along, self.over)
        modes = modes.reshape(len(self.over), -1)
        response = self.compliance.all_blocks()[1 if along else 0]
        if response is None:  # a rigid body
            return np.zeros((teeth.size, len(self.over)) * 2)
        number = self.compliance.blocks_of_sites(teeth, n_working, self.teeth)
        found = (modes @ response @ modes.T)[number].transpose(0, 2, 1, 3).copy()
        images = self.corners_along if along else self.corners
        own = np.einsum("cihjk,i,h->jk", images, spread, spread)
        if not along:
            apart = np.abs(np.arange(spread.size)[:, None] - np.arange(spread.size))
            products = np.bincount(apart.ravel(), weights=np.outer(spread, spread).ravel())
            own += np.einsum("n,njk->jk", products, self.near)
        sites = np.arange(teeth.size)
        found[sites, :, sites, :] += own
        return np.asarray(found)


def _axial_means(ends_mm: tuple[float, float], count: int, edges_mm: Floats) -> Floats:
    """Means (J, count) of Legendre polynomials over slices."""
    low, high = ends_mm
    places = (2.0 * edges_mm - low - high) / (high - low)
    integrals = np.stack([legval(places, legint(row)) for row in np.eye(count)], axis=1)
    return np.asarray(np.diff(integrals, axis=0) / np.diff(places)[:, None])


def strip_distances(count: int, width_mm: float) -> Floats:
    """Distances (n,) of strips 0, 1, ... widths apart by the mean logarithm between points, mm.

    The second integral of ln x is x²/2 ln x - 3 x²/4; the mean logarithm of strips n widths apart
    is

        ln w - 3/2 + [(n + 1)² ln(n + 1) - 2 n² ln n + (n - 1)² ln|n - 1|]/2
    """
    n = np.arange(count, dtype=float)

    def square_log(x: Floats) -> Floats:
        return np.where(x > 0, x**2 * np.log(np.where(x > 0, x, 1.0)), 0.0)

    terms = square_log(n + 1.0) - 2.0 * square_log(n) + square_log(np.abs(n - 1.0))
    return np.asarray(width_mm * np.exp(0.5 * terms - 1.5))


def mean_potential(distance: Floats, length: Floats, other: Floats, across: Floats) -> Floats:
    """Mean of 1/R over two parallel segments, 1/mm, Eq. (S3); arguments broadcast, in mm."""
    square = distance**2 + across**2
    far = square > (FAR * np.maximum(length, other)) ** 2
    moments = (length**2 + other**2) * (2.0 * distance**2 - across**2) / (24.0 * square**2)
    half_sum, half_difference = 0.5 * (length + other), 0.5 * (length - other)
    near = (
        _twice_integrated(distance + half_sum, across)
        - _twice_integrated(distance + half_difference, across)
        - _twice_integrated(distance - half_difference, across)
        + _twice_integrated(distance - half_sum, across)
    ) / (length * other)
    return np.asarray(np.where(far, (1.0 + moments) / np.sqrt(square), near))


def _twice_integrated(along: Floats, across: Floats) -> Floats:
    """Second integral of 1/sqrt(y² + x²) over y."""
    radius = np.hypot(along, across)
    return np.asarray(np.abs(along) * np.log((np.abs(along) + radius) / across) - radius)
