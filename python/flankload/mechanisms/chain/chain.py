"""The kind "chain": rollers on links, a truss with geometric stiffness."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Chain:
    """A chain without its sprocket.

    Attributes
    ----------
    pitch_mm : float
        Pitch of the new chain.
    elongation : float
        Relative increase of the length of every link by wear.
    link_stiffness_N : float
        Force divided by strain of a link.
    contact_stiffness_N_per_mm : float
        Stiffness of the contact between roller and pocket, equal in all directions.
    span_mm : float
        Length of the free strands, whose tension stabilises the outer rollers laterally.
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
        """(n - 1,) Tensions of the links between n rollers at places (n, 2), N."""
        length = np.hypot(*np.diff(place, axis=0).T)
        return self.link_stiffness_N * (length / self.link_mm - 1.0)

    def truss(self, place: Floats, tension: Floats) -> tuple[Floats, Floats]:
        """Stiffness and internal forces of the links between n rollers.

        K = EA/l t tᵀ + T/l (1 - t tᵀ) for each link with the direction t.

        Parameters
        ----------
        place : (n, 2) array
            Places of the rollers, mm.
        tension : (n - 1,) array
            Tensions for the lateral stiffness of the links, N; compressed links have none.

        Returns
        -------
        stiffness : (2n, 2n) array
            N/mm.
        force : (2n,) array
            Forces of the links on the rollers at these places, N.
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
