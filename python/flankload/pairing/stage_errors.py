"""Errors of a planetary stage that displace whole bodies: pins, run-outs, thicknesses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import directions, turned

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flankload.base.arrays import Floats
    from flankload.pairing.stage import StagePairing


@dataclass(frozen=True)
class StageErrors:
    """Errors of a stage of n planets.

    Attributes
    ----------
    pins_mm : (n, 2) array
        Displacement of each pin in the frame of the carrier.
    thickness_mm : (n,) array
        Excess of the normal thickness of the teeth of each planet.
    sun_mm, ring_mm : (float, float)
        Eccentricity of the teeth, and its direction at position zero, rad.
    sun_at_mm : (float, float)
        Displacement of the sun by its weight on a support.
    tilts_rad : (n, 2) array or None
        Rotations of the pins about x and y, if any.
    """

    pins_mm: Floats
    thickness_mm: Floats
    sun_mm: tuple[float, float] = (0.0, 0.0)
    ring_mm: tuple[float, float] = (0.0, 0.0)
    sun_at_mm: tuple[float, float] = (0.0, 0.0)
    tilts_rad: Floats | None = None

    @property
    def any(self) -> bool:
        """Whether there is any error."""
        return bool(
            self.pins_mm.any()
            or self.thickness_mm.any()
            or self.turns
            or any(self.sun_at_mm)
            or self.tilts_rad is not None
        )

    @property
    def turns(self) -> bool:
        """Whether an error turns with a body, relative to the carrier."""
        return bool(self.sun_mm[0] or self.ring_mm[0])

    def thickness(self, body: int) -> float:
        """Excess of the normal thickness of the teeth of a planet, mm; none of sun and ring."""
        return float(self.thickness_mm[body - 1]) if 0 < body <= len(self.thickness_mm) else 0.0

    def tilt(self, body: int) -> Floats | None:
        """(2,) Rotation of a planet with its pin about x and y, rad, if any is tilted."""
        if self.tilts_rad is None or not 0 < body <= len(self.tilts_rad):
            return None
        return self.tilts_rad[body - 1]

    def displacements(self, pairing: StagePairing, position_rad: Floats) -> Floats:
        """(P, n + 2, 3) Displacements x, y (mm) and rotation of sun, planets and ring."""
        n, ratio = len(self.pins_mm), pairing.teeth[0] / pairing.teeth[2]
        found = np.zeros((position_rad.size, n + 2, 3))
        found[:, 1 : n + 1, :2] = self.pins_mm
        for body, (amount, at), turn in ((0, self.sun_mm, 1.0), (n + 1, self.ring_mm, -ratio)):
            found[:, body, :2] = amount * directions(at + turn * position_rad)
        found[:, 0, :2] += self.sun_at_mm
        return found


def pin_directions(angles_rad: Floats) -> Floats:
    """(n, 2, 2) Directions in which errors of pins count: towards the axis, clockwise."""
    inward = turned(np.array([-1.0, 0.0]), angles_rad)
    against = turned(np.array([0.0, -1.0]), angles_rad)
    return np.stack([inward, against], axis=1)


def pin_displacements(
    angles_rad: Floats,
    radial_mm: Sequence[float] | Floats,
    tangential_mm: Sequence[float] | Floats,
) -> Floats:
    """(n, 2) Displacements of pins: radial errors inwards, tangential ones clockwise."""
    errors = np.column_stack([radial_mm, tangential_mm])
    return np.einsum("nk,nkx->nx", errors, pin_directions(angles_rad))
