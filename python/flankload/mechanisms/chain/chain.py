"""The kind "chain": rollers on links, a truss with the stiffness of its tension."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Chain:
    """A chain as such.

    Attributes
    ----------
    pitch_mm : float
        Of the new chain.
    elongation : float
        By which wear has lengthened every link, relative.
    link_stiffness_N : float
        Force over strain of a link.
    contact_stiffness_N_per_mm : float
        Of a roller against its pocket, in every direction.
    span_mm : float
        Length of the free strands, whose tension holds the outer rollers sideways.
    """

    pitch_mm: float
    elongation: float
    link_stiffness_N: float
    contact_stiffness_N_per_mm: float
    span_mm: float

    @property
    def link_mm(self) -> float:
        """Length of a link without tension."""
        return self.pitch_mm * (1 + self.elongation)

    def tensions(self, place: Floats) -> Floats:
        """(n - 1,) Tensions of the links between n rollers at their places (n, 2), N."""
        length = np.hypot(*np.diff(place, axis=0).T)
        return self.link_stiffness_N * (length / self.link_mm - 1.0)

    def truss(self, place: Floats, tension: Floats) -> tuple[Floats, Floats]:
        """Stiffness and inner forces of the links between n rollers.

        K = EA/l t tᵀ + T/l (1 - t tᵀ) for each link with the direction t.

        Parameters
        ----------
        place : (n, 2) array
            Of the rollers, mm.
        tension : (n - 1,) array
            Of the links, for the stiffness sideways, N; links that push have none.

        Returns
        -------
        stiffness : (2n, 2n) array
            N/mm.
        force : (2n,) array
            With which the links at these places pull on the rollers, N.
        """
        n = len(place)
        link = np.diff(place, axis=0)
        length = np.hypot(*link.T)
        t = link / length[:, None]
        along = t[:, :, None] * t[:, None, :]
        blocks = (self.link_stiffness_N / self.link_mm) * along + (
            np.maximum(tension, 0.0) / length
        )[:, None, None] * (np.eye(2) - along)
        stiffness = np.zeros((n, 2, n, 2))
        first = np.arange(n - 1)
        for i, j, sign in ((0, 0, 1), (1, 1, 1), (0, 1, -1), (1, 0, -1)):
            stiffness[first + i, :, first + j, :] += sign * blocks
        pull = self.tensions(place)[:, None] * t
        force = np.zeros((n, 2))
        force[:-1] += pull
        force[1:] -= pull
        return stiffness.reshape(2 * n, 2 * n), force.ravel()
