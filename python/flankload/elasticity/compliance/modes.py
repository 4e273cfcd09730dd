"""Unit loads as pressure modes: what a flank's response to them leaves without the near field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.free_corner import image_strengths
from flankload.elasticity.near_field import (
    jump_strength,
    logarithm_strength,
    mode_norms,
    projected_logarithm,
    projected_near_field,
    projected_sign,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import Body
    from flankload.cost import Account

    Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ModeLoads:
    """Pressure modes on the flanks of a body; with friction as many along the flank behind them.

    Attributes
    ----------
    body : Body
    count : int
        Of the modes of a flank.
    plane : {"strain", "stress"}
    friction : bool
    """

    body: Body
    count: int
    plane: str
    friction: bool

    #: Modes are no forces at nodes.
    nodes = None

    @property
    def kernel(self) -> float:
        """Strength of the logarithm, mm²/N."""
        return logarithm_strength(self.body.material, self.plane)

    @property
    def wedge(self) -> tuple[float, float]:
        """Strengths psi of the mirror images behind free corners at both ends of the modes."""
        return image_strengths(self.body)

    @property
    def jump(self) -> float:
        """Strength of the jump, mm²/N; 0 without friction."""
        return jump_strength(self.body.material, self.plane) if self.friction else 0.0

    @property
    def norms(self) -> Floats:
        """Integrals of the squared modes, mm: what is projected over them is a coefficient."""
        body = self.body
        return mode_norms(body.mode_range_mm, self.count, closed=body.curve.closed)

    def settle(
        self,
        response: Floats,
        own: NDArray[np.int64],
        account: Account,
    ) -> None:
        """Leave what modes carry, as mode coefficients.

        Parameters
        ----------
        response : (k, p, p) array
            Projected on the modes; changed in place.
        own : array
            Which of the k are of flanks to loads on themselves.
        account : Account
        """
        low, high = self.body.mode_range_mm
        n, norms = self.count, self.norms
        closed = self.body.curve.closed
        near = projected_near_field(n, high - low, wedge=self.wedge, closed=closed)
        response[own, :n, :n] += self.kernel * near
        if response.shape[1] > n:
            logarithm = self.kernel * projected_logarithm(n, high - low, closed=closed)
            sign = self.jump * projected_sign(n, high - low)
            response[own, :n, n:] += sign
            response[own, n:, :n] += sign.T
            response[own, n:, n:] += logarithm
            norms = np.tile(norms, 2)
        response /= norms[:, None] * norms[None, :]

    def missed(self, missed: Floats) -> Floats:
        """What elements miss of displacements out of the material, between coefficients."""
        loads = np.tile(self.norms, missed.shape[2] // self.count)
        return missed[:, : self.count] / (self.norms[:, None] * loads)
