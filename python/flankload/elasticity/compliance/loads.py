"""Unit loads on the flanks of a body: pressure modes, or forces at nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.bodies.free_corner import along_strengths, image_strengths
from flankload.bodies.tip_modes import Tip
from flankload.elasticity.compliance.contributions import NearField
from flankload.elasticity.near_field import (
    jump_strength,
    logarithm_strength,
    mode_loads,
    projected_near_field,
    projected_sign,
    to_coefficients,
)
from flankload.elasticity.nodal_loads import nodal_unit_loads

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Body, MeshedFlank, SectorMesh
    from flankload.cost import Account


@dataclass(frozen=True, eq=False)
class ModeLoads:
    """Pressure modes on the flanks of a body, with friction followed by as many tangential ones.

    Attributes
    ----------
    count : int
        Number of modes of a flank, including those of its tip.
    plane : {"strain", "stress"}
    """

    body: Body
    count: int
    plane: str
    friction: bool

    #: None: no unit forces at nodes.
    nodes = None

    @property
    def near_field(self) -> NearField:
        """Near field that the modes do not include."""
        body = self.body
        return NearField(
            logarithm_strength(body.material, self.plane),
            jump=jump_strength(body.material, self.plane) if self.friction else 0.0,
            wedge=image_strengths(body),
            wedge_along=along_strengths(body),
        )

    @property
    def tip(self) -> Tip | None:
        """The tip, whose modes are the last ones and included in `count`."""
        return self.body.tip

    def columns(
        self, flank: SectorMesh | MeshedFlank, along: Literal["normal", "tangent"]
    ) -> Floats:
        """Nodal forces (2 N, count) of the normal or tangential modes of a flank."""
        span, closed = self.body.mode_range_mm, self.body.curve.closed
        return mode_loads(flank, span, self.count, along=along, closed=closed, tip=self.tip)

    def coefficients(self, moments: Floats) -> Floats:
        """Mode coefficients from moments (k, r, …), along the second axis."""
        body, n = self.body, self.count
        parts = [moments[:, k : k + n].swapaxes(0, 1) for k in range(0, moments.shape[1], n)]
        closed = body.curve.closed
        found = [
            to_coefficients(part, body.mode_range_mm, closed=closed, tip=body.tip) for part in parts
        ]
        return np.concatenate(found).swapaxes(0, 1)

    def subtract_near_field(self, response: Floats, own: Numbers, account: Account) -> None:
        """Subtract the near field from a response and convert it to mode coefficients, in place.

        The response (k, p, p) consists of moments; `own`: indices of the responses of flanks to
        their own loads.
        """
        low, high = self.body.mode_range_mm
        n, tip = self.count, self.tip
        behind = None if tip is None else tip.behind(low)
        closed, field = self.body.curve.closed, self.near_field
        near = projected_near_field(n, high - low, wedge=field.wedge, closed=closed, tip=behind)
        response[own, :n, :n] += field.kernel * near
        if response.shape[1] > n:
            along = self._along_near()
            response[own, :n, n:] -= along
            response[own, n:, :n] -= along.T
            near = projected_near_field(n, high - low, closed=closed, tip=behind)
            response[own, n:, n:] += field.kernel * near
        response[:] = self.between(response)

    def along_near(self) -> Floats:
        """Near field of tangential loads for normal displacements (p, p), as mode coefficients."""
        return self.between(self._along_near()[None])[0]

    def _along_near(self) -> Floats:
        """As `along_near`, moments: jump, and images behind free corners."""
        low, high = self.body.mode_range_mm
        n, field, length = self.count, self.near_field, high - low
        tip = None if self.tip is None else self.tip.behind(low)
        found = -field.jump * projected_sign(n, length, tip=tip)
        if any(field.wedge_along):
            near = projected_near_field(n, length, tip=tip)
            image = projected_near_field(n, length, wedge=field.wedge_along, tip=tip)
            found = found - field.kernel * (image - near)
        return np.asarray(found)

    def between(self, moments: Floats) -> Floats:
        """Response (k, r, p) as a map between mode coefficients, from that between moments."""
        rows = self.coefficients(moments)
        return self.coefficients(rows.swapaxes(1, 2)).swapaxes(1, 2)

    def fe_error(self, fe_error: Floats) -> Floats:
        """Estimated error of the normal displacements, as a map between mode coefficients."""
        return self.between(fe_error[:, : self.count])


@dataclass(frozen=True, eq=False)
class NodeLoads:
    """Unit forces at nodes, with friction followed by as many tangential ones.

    The response includes the near field.

    Attributes
    ----------
    nodes : (n,) array
        Arc lengths, mm.
    plane : {"strain", "stress"}
    """

    body: Body
    nodes: Floats
    plane: str

    #: None: no modes of a tip.
    tip = None

    @property
    def count(self) -> int:
        """Number of nodes of a flank."""
        return self.nodes.size

    @property
    def near_field(self) -> NearField:
        """Strength of the logarithm, for the expected width of contacts."""
        return NearField(logarithm_strength(self.body.material, self.plane))

    def columns(
        self, flank: SectorMesh | MeshedFlank, along: Literal["normal", "tangent"]
    ) -> Floats:
        """Nodal forces (2 N, n) of the normal or tangential unit forces on a flank."""
        return nodal_unit_loads(flank, self.nodes, along=along)

    def along_near(self) -> None:
        """None: the response includes the near field."""

    def subtract_near_field(self, response: Floats, own: Numbers, account: Account) -> None:
        """Count the unit forces; the response includes the near field and is unchanged."""
        assert self.body.mesh is not None
        account.count(unit_loads_nodal=response.shape[2] * len(self.body.mesh.flanks))
