"""Tilt of the teeth by shafts and bearings, and the forces on the bearings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flankload.base.card import Card
from flankload.base.read_only import KeepsReadOnly

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class ShaftLoads(KeepsReadOnly, Card):
    """Shafts and bearings of both bodies at P positions.

    Attributes
    ----------
    tilt_um_per_mm : (P,) array
        Slope of the gap between the flanks by both shafts, along the base tangent; positive if the
        gap opens towards larger z, as a positive `helix_slope_um` over the face width does.
    bearing_force_1_N, bearing_force_2_N : (P, B, 3) arrays
        Force (x, y, z) of the shaft on each of its B bearings; x from axis 1 to axis 2, z along the
        axes. B = 0 if the shaft is known by its compliance only, and without a shaft.
    k_h_beta_iso : float or None
        Face load factor by the formulas of ISO 6336-1, method C, for comparison only; None without
        a shaft that bends and twists under the teeth of the pinion, and where they do not apply.
    """

    tilt_um_per_mm: Floats
    bearing_force_1_N: Floats
    bearing_force_2_N: Floats
    k_h_beta_iso: float | None = None

    @property
    def bearing_forces(self) -> dict[str, Floats]:
        """Forces on the bearings of the shafts with known bearings, by name."""
        names = ("bearing_force_1_N", "bearing_force_2_N")
        return {name: getattr(self, name) for name in names if getattr(self, name).size}
