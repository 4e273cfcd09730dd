"""Forces on the coast flanks of a result, if these can carry load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flankload.base.card import Card
from flankload.base.read_only import KeepsReadOnly
from flankload.result.pairs import PairTable

Floats = NDArray[np.float64]

#: Arrays over positions and sites that only results with coast flanks have, with their units.
OVER_SITES = {"coast_force_N": "N", "coast_peak_pressure_MPa": "MPa"}


@dataclass(frozen=True, eq=False, repr=False)
class CoastContact(KeepsReadOnly, Card):
    """Contact on coast flanks at P positions, for the S pair numbers of the working flanks.

    Pair j is the tooth of body 1 whose working flank belongs to pair j; its coast flank faces the
    tooth of body 2 that meets the next tooth, or, if body 2 is an internal gear, the other side of
    its own space.

    Attributes
    ----------
    force_N, peak_pressure_MPa : (P, S) arrays
        Force and largest pressure; 0 if open.
    corner_contact : (P, S) array of bool
        Contact on a sharp corner, where the peak pressure is meaningless.
    pair_tables : sequence of PairTable, one per position
        Their forces turn body 1 against its torque.
    """

    force_N: Floats
    peak_pressure_MPa: Floats
    corner_contact: NDArray[np.bool_]
    pair_tables: Sequence[PairTable]

    @property
    def loaded(self) -> NDArray[np.int64]:
        """(P,) Number of coast flanks that carry load."""
        return np.asarray((self.force_N > 0).sum(axis=1))
