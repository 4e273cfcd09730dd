"""The paths of force of a planetary stage: levers on its lines of action, by their formulas.

Rows are those of g = K F + g0 - B q: one for each gear mesh of a stage, with its force on the line
of action. Columns are motions of the members in the frame of the carrier. The torque on the sun is
positive, counter-clockwise; the planets turn clockwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned

if TYPE_CHECKING:
    from flankload.base.arrays import Floats


@dataclass(frozen=True)
class StagePaths:
    """Lines of action of a stage of n planets.

    Attributes
    ----------
    angles_rad : (n,) array
        Polar angles of the planets.
    pressure_angles_rad : (float, float)
        Working pressure angles of the meshes with the sun and with the ring.
    base_radii_mm : (float, float, float)
        Of sun, planet and ring.
    """

    angles_rad: Floats
    pressure_angles_rad: tuple[float, float]
    base_radii_mm: tuple[float, float, float]

    @property
    def sun_pushes(self) -> Floats:
        """(n, 2) Directions of the forces of the sun on the planets."""
        alpha = self.pressure_angles_rad[0]
        return turned(np.array([sin(alpha), cos(alpha)]), self.angles_rad)

    @property
    def ring_pushes(self) -> Floats:
        """(n, 2) Directions of the forces of the planets on the ring."""
        alpha = self.pressure_angles_rad[1]
        return turned(np.array([sin(alpha), -cos(alpha)]), self.angles_rad)

    @property
    def sun_rows(self) -> Floats:
        """(2n, 3) Columns of the sun: rotation, displacement x and y."""
        own = np.column_stack(
            [np.full(len(self.angles_rad), self.base_radii_mm[0]), self.sun_pushes]
        )
        return np.concatenate([own, np.zeros_like(own)])

    @property
    def ring_rows(self) -> Floats:
        """(2n, 3) Columns of the ring: rotation, displacement x and y."""
        lever = np.full(len(self.angles_rad), self.base_radii_mm[2])
        own = np.column_stack([lever, -self.ring_pushes])
        return np.concatenate([np.zeros_like(own), own])

    @property
    def planet_rows(self) -> Floats:
        """(2n, n, 3) Columns of the planets: rotation, positive clockwise, displacement x and y."""
        n, radius = len(self.angles_rad), self.base_radii_mm[1]
        found, own = np.zeros((2, n, n, 3)), np.arange(n)
        found[0, own, own] = np.column_stack([np.full(n, -radius), -self.sun_pushes])
        found[1, own, own] = np.column_stack([np.full(n, radius), self.ring_pushes])
        return found.reshape(2 * n, n, 3)
