"""Fields at the nodes of a loaded body, and its teeth and flanks as results number them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.pairing.coast_sites import coast_sites

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies import Body

    Floats = NDArray[np.float64]
    Numbers = NDArray[np.int64]

#: Points of a contact cell at which its force acts on the elements (Gauss).
POINTS = 4


@dataclass(frozen=True, eq=False)
class NodalFields:
    """Fields at the M nodes of a body at one position, in the world frame.

    Attributes
    ----------
    points_mm : (M, 2) array; (M, 3) in three dimensions
        Undeformed places.
    displacement_mm : array of that shape
        By the contact forces; not by temperature, speed, a press fit or shafts.
    stress_MPa : (M, 4) array; (M, 6)
        xx, yy, zz, xy, then yz, xz; averaged over the elements of a node.
    contact_pressure_MPa : (M,) array
        Normal force of a flank node over its part of the flank; 0 elsewhere.
    force_N : array of the shape of the places
        Consistent nodal forces of the contacts, over the face width.
    """

    points_mm: Floats
    displacement_mm: Floats
    stress_MPa: Floats
    contact_pressure_MPa: Floats
    force_N: Floats

    @property
    def von_mises_MPa(self) -> Floats:
        """(M,) Equivalent stress."""
        xx, yy, zz, *shear = self.stress_MPa.T
        apart = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
        return np.asarray(np.sqrt(0.5 * apart + 3.0 * sum(part**2 for part in shear)))


@dataclass(frozen=True, eq=False)
class BodyOfPair:
    """One body of a pair, on which contact forces of results act.

    Attributes
    ----------
    number : int
        0 or 1.
    body, other : Body
        This body of the scene, and the other one.
    """

    number: int
    body: Body
    other: Body

    def teeth(self, sites: Numbers, coast: bool) -> Numbers:
        """Teeth of the body at pair numbers."""
        one, two = (self.body, self.other) if self.number == 0 else (self.other, self.body)
        if coast:
            return coast_sites(sites, one, two).site_teeth[self.number]
        sense = 1 if self.number == 0 else -self.body.outward
        return np.asarray(sense * sites % self.body.teeth)

    def on_elements(self, s: Floats, elements: Body) -> Floats:
        """Arc lengths on the flank that the elements follow, of those on the flank of the body."""
        low, high = self.body.mode_range_mm
        first, last = elements.mode_range_mm
        return np.asarray(first + (s - low) * ((last - first) / (high - low)))
