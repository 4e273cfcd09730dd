"""Forces on the coast flanks of a result, if these can carry load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from flankload.base.card import Card
from flankload.base.read_only import KeepsReadOnly
from flankload.result.pairs import PairTable

if TYPE_CHECKING:
    from flankload.result.result import Result

Floats = NDArray[np.float64]

#: Forces and pressures that differ by less, relative to the largest, are equal.
SAME = 1e-9
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


def coast_arrays(result: Result) -> dict[str, tuple[Any, str]]:
    """Arrays (P, S) of the coast flanks, with their units; empty if these cannot carry load."""
    if result.coast is None:
        return {}
    return {key: (getattr(result, key), unit) for key, unit in OVER_SITES.items()}


def coast_summary(result: Result) -> dict[str, Any]:
    """Summary of the coast flanks; empty if these cannot carry load.

    Least and largest number of them that carry load at once, the largest force and the largest
    pressure off corners, with the position and pair of each (None if no coast flank carries load).
    """
    coast = result.coast
    if coast is None:
        return {}
    smooth = np.where(coast.corner_contact, 0.0, coast.peak_pressure_MPa)
    return {
        "coast_flanks_loaded_min": int(coast.loaded.min()),
        "coast_flanks_loaded_max": int(coast.loaded.max()),
        **_largest(result, "coast_force", coast.force_N, "N"),
        **_largest(result, "coast_peak_pressure_off_corners", smooth, "MPa"),
    }


def _largest(result: Result, key: str, values: Floats, unit: str) -> dict[str, Any]:
    # of equal values the first one, independent of roundoff
    p, s = np.unravel_index(np.argmax(values >= (1.0 - SAME) * values.max()), values.shape)
    found = float(values[p, s])
    return {
        f"{key}_{unit}": found,
        f"{key}_position_rad": float(result.position_rad[p]) if found > 0 else None,
        f"{key}_pair": int(result.sites[s]) if found > 0 else None,
    }
