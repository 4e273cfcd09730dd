"""Gap between the flanks that do not work.

In the mirror image of `coast_sites` the gap follows from the search for working flanks, without
load.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flankload.contact.sweep import FlankContact, sweep
from flankload.errors import ContactError
from flankload.pairing.pairing import coast_sites

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import Body
    from flankload.elasticity.compliance import BodyCompliance
    from flankload.pairing.body_pair import BodyPair
    from flankload.pairing.pairing import Pairing
    from flankload.scene.discretization import Grid


@dataclass(frozen=True, eq=False)
class CoastSide:
    """Mirror image of a pair; its gaps are computed on first use.

    Attributes
    ----------
    bodies : two Body
    pairing : Pairing
        Pairing of the mirrored pair.
    position_rad : (P,) array
        Positions of the mirrored pair.
    base_radius_mm : float
        Base radius of body 1.
    grid : Grid
    compliances : two BodyCompliance
        Without forces; for bodies that expand.
    """

    bodies: tuple[Body, Body]
    pairing: Pairing
    position_rad: NDArray[np.float64]
    base_radius_mm: float
    grid: Grid
    compliances: tuple[BodyCompliance, BodyCompliance]

    @cached_property
    def gap_rad(self) -> NDArray[np.float64]:
        """(P,) Angle by which body 1 can turn back without load before coast flanks touch.

        Negative if they overlap; NaN if no coast flanks face each other.
        """
        try:
            return self._gaps(self.position_rad)
        except ContactError:
            return np.array([self._gap_or_nan(p) for p in range(self.position_rad.size)])

    def _gap_or_nan(self, p: int) -> float:
        try:
            return float(self._gaps(self.position_rad[p : p + 1])[0])
        except ContactError:
            return float("nan")

    def _gaps(self, position_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        contact = FlankContact(self.bodies, self.compliances, self.pairing, 1.0, self.grid)
        (found,) = sweep(contact, position_rad, (0.0,), keep_pairs=False)
        return found.rotation_rad


def coast_side(
    pair: BodyPair, compliances: tuple[BodyCompliance, BodyCompliance]
) -> tuple[CoastSide | None, str]:
    """Return the coast flanks of a pair; None and the reason if they are unknown.

    Both flanks of a tooth are assumed to be equal, and to expand equally; pitch errors apply to
    working flanks only.

    Parameters
    ----------
    pair : BodyPair
    compliances : two BodyCompliance

    Returns
    -------
    coast : CoastSide or None
    unknown : str
    """
    one, two = pair.body_1.involute, pair.body_2.involute
    for z, involute in enumerate((one, two)):
        if involute is None:
            return None, f"body_{z + 1} has no known coast flank"
        if any(len(shift) > 1 for shift in compliances[z].expansion.shifts.values()):
            return None, f"the expansion of body_{z + 1} is known on the working flanks only"
    assert one is not None
    coast = CoastSide(
        bodies=(pair.body_1, pair.body_2),
        pairing=_mirrored(pair.pairing, pair.body_1, pair.body_2),
        position_rad=-pair.position_rad,
        base_radius_mm=one.base_radius_mm,
        grid=pair.discretization.grid,
        compliances=(compliances[0].unyielding(), compliances[1].unyielding()),
    )
    return coast, ""


def _mirrored(pairing: Pairing, body_1: Body, body_2: Body) -> Pairing:
    """The pairing of coast flanks in the mirror image."""
    numbers = pairing.sites
    if body_2.outward > 0:
        numbers = np.union1d(numbers, numbers + 1)
    coast = coast_sites(numbers, body_1, body_2)
    turn_1, turn_2 = pairing.turns_at_zero_rad
    none = np.zeros(numbers.size)
    return replace(
        pairing,
        turns_at_zero_rad=(-turn_1, -turn_2),
        sites=numbers,
        site_teeth=coast.site_teeth,
        site_angles_rad=coast.site_angles_rad,
        site_deviations_mm=(none, none),
        coast=None,
    )
