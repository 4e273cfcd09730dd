"""Root stress of the planets over a turn: each tooth is bent by the sun, then back by the ring."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flankload.base.card import Card
from flankload.base.read_only import KeepsReadOnly

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.root_fillet import RootPoints

#: Sides of a planet's tooth: that of its working flank, in mesh with the sun, and the other one.
SIDES = ("ring", "sun")


@dataclass(frozen=True, eq=False, repr=False)
class PlanetBending(KeepsReadOnly, Card):
    """Extremes of the root stress of the teeth of n planets over a turn relative to the carrier.

    All teeth of a planet pass all positions of a mesh period, so that the extremes are those over
    all its teeth and all positions. They are those of a turn if the positions cover the period.

    Attributes
    ----------
    points : RootPoints
        The q points of both fillets, those on the side of the sun's flank (working) first.
    largest_MPa, least_MPa : (n, q) arrays
        Positive in tension; in three dimensions across the root line.
    z_mm : (n, q) array or None
        Place along the axis, in the middle of the slice with the largest range; None in the plane.
    """

    points: RootPoints
    largest_MPa: Floats
    least_MPa: Floats
    z_mm: Floats | None = None

    @property
    def range_MPa(self) -> Floats:
        """(n, q) Largest minus least stress: twice the amplitude."""
        return np.asarray(self.largest_MPa - self.least_MPa)

    @property
    def mean_MPa(self) -> Floats:
        """(n, q) Mean of the largest and the least stress."""
        return np.asarray(0.5 * (self.largest_MPa + self.least_MPa))

    def as_dict(self) -> dict[str, Any]:
        """The extremes in the form of the JSON result."""
        return {
            "arc_length_mm": self.points.arc_length_mm,
            "side": [SIDES[int(working)] for working in self.points.working],
            "largest_MPa": self.largest_MPa,
            "least_MPa": self.least_MPa,
            **({} if self.z_mm is None else {"z_mm": self.z_mm}),
        }

    def words(self) -> str:
        """Text of a report."""
        found = self.summary()
        return (
            f"root stress of planet {found['planet']} over a turn: range {found['range_MPa']:.4g} "
            f"MPa, mean {found['mean_MPa']:.4g} MPa"
        )

    def summary(self) -> dict[str, Any]:
        """The point with the largest range of all planets."""
        planet, q = np.unravel_index(self.range_MPa.argmax(), self.range_MPa.shape)
        return {
            "range_MPa": float(self.range_MPa[planet, q]),
            "mean_MPa": float(self.mean_MPa[planet, q]),
            "planet": int(planet) + 1,
            "side": SIDES[int(self.points.working[q])],
            "arc_length_mm": float(self.points.arc_length_mm[q]),
            **({} if self.z_mm is None else {"z_mm": float(self.z_mm[planet, q])}),
        }
