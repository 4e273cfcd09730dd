"""Displacements of the coast flanks under loads on the working flanks of a sector mesh."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.near_field import mirrored_loads

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import Body, SectorMesh
    from flankload.elasticity.compliance.modes import ModeLoads

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CoastReadings:
    """Columns that read displacements of the coast flank of a sector.

    Attributes
    ----------
    columns : (2 N, p) array
    tooth : int
        Tooth of this coast flank.
    """

    columns: Floats
    tooth: int

    def taken_from(self, response: Floats, modes: ModeLoads) -> tuple[Floats, Floats]:
        """Separate the readings of the coast flank from a response.

        Parameters
        ----------
        response : (z, r, p) array
            These readings follow those of the working flank.

        Returns
        -------
        response : (z, r - n, p) array
            Without these readings.
        crossing : (z, n, p) array
            From the coefficients of loads on the working flank of tooth 0 to those of displacements
            on the coast flank of tooth t.
        """
        first, n = response.shape[2], modes.count
        crossing = np.roll(response[:, first : first + n], self.tooth, axis=0)
        crossing = modes.between(crossing)
        # reciprocity (Betti): exchanging load and reading gives a load on the coast flank, which
        # is the mirror image of a load on the working flank
        pressures = crossing[..., :n]
        crossing[..., :n] = 0.5 * (pressures + pressures.transpose(0, 2, 1))
        return np.delete(response, slice(first, first + n), axis=1), crossing


def coast_readings(body: Body, mesh: SectorMesh, loads: Floats) -> CoastReadings:
    """Readings of the coast flank by the loads of the working flank, in the mirror of a sector.

    Parameters
    ----------
    body : Body
        With an involute.
    loads : (2 N, n) array
        Along the normal of the working flank.
    """
    assert body.involute is not None
    return CoastReadings(*mirrored_loads(mesh, loads, body.involute.turn_rad))
