"""Unit loads on the flanks of a body (pressure modes, forces at nodes) and readings of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.bodies.free_corner import along_strengths, image_strengths
from flankload.elasticity.compliance.contributions import FlankModes, NearField, RootResponse
from flankload.elasticity.near_field import (
    jump_strength,
    logarithm_strength,
    mirrored_loads,
    mode_loads,
    projected_near_field,
    projected_sign,
    to_coefficients,
)
from flankload.elasticity.nodal_loads import nodal_unit_loads

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Body, MeshedFlank, SectorMesh
    from flankload.bodies.root_fillet import RootFillets
    from flankload.cost import Account
    from flankload.elasticity.finite_elements import SectionStiffness

#: Directions of unit loads.
Along = Literal["normal", "tangent"]
DIRECTIONS: tuple[Along, ...] = ("normal", "tangent")


class FlankLoads(ABC):
    """Normal unit loads on the flanks of a body, with friction followed by as many tangential ones.

    Attributes
    ----------
    count : int
        Number of normal loads of a flank.
    functions_of_roots : int
        Number of functions of z of the stress at a point of a root.
    """

    body: Body
    count: int
    friction: bool
    functions_of_roots = 1

    @property
    @abstractmethod
    def modes(self) -> FlankModes:
        """Modes, or nodes, of the loads."""

    @property
    @abstractmethod
    def near_field(self) -> NearField:
        """Near field that the modes do not include."""

    @abstractmethod
    def columns(self, flank: SectorMesh | MeshedFlank) -> Floats:
        """Loads (N, u, q) of a flank by node and unknown."""

    def on_coast(self, mesh: SectorMesh) -> tuple[Floats, int]:
        """Loads (N, u, q) on the coast flank of a sector, and the tooth of this flank."""
        raise NotImplementedError

    @abstractmethod
    def subtract_near_field(self, response: Floats, own: Numbers, account: Account) -> None:
        """Subtract the near field from a response and convert it to mode coefficients, in place.

        The response (k, q, q) consists of moments; `own`: indices of the responses of flanks to
        their own loads.
        """

    def along_near(self) -> Floats | None:
        """Near field of tangential loads for normal displacements (p, p), as mode coefficients."""
        return None

    def from_section(self, fe_error: Floats) -> Floats:
        """Estimated error of the elements, from that of a plane section."""
        return fe_error

    @abstractmethod
    def root_columns(self, fillets: RootFillets, flank: int, section: SectionStiffness) -> Floats:
        """Columns (N, u, r) that read the stress in the roots of a flank's tooth."""

    @abstractmethod
    def roots(self, fillets: RootFillets, readings: Floats) -> RootResponse:
        """Stress in the roots from the readings (k, r, q) under unit loads."""

    @abstractmethod
    def coefficients(self, moments: Floats) -> Floats:
        """Mode coefficients from moments (k, r, …), along the second axis."""

    def between(self, moments: Floats) -> Floats:
        """Response (k, r, q) as a map between mode coefficients, from that between moments."""
        return self.by_coefficients(self.coefficients(moments))

    def by_coefficients(self, readings: Floats) -> Floats:
        """Readings (k, r, q) under modes, from those under unit loads."""
        return self.coefficients(readings.swapaxes(1, 2)).swapaxes(1, 2)


class PlaneLoads(FlankLoads):
    """Unit loads on the flanks of a plane body.

    Attributes
    ----------
    plane : {"strain", "stress"}
    """

    plane: str

    def root_columns(self, fillets: RootFillets, flank: int, section: SectionStiffness) -> Floats:
        """Strain (N, 2, r) along the free surface times E, in plane strain E/(1 - nu²)."""
        modulus = self.body.material.young_modulus_MPa
        if self.plane == "strain":
            modulus /= 1 - self.body.material.poisson_ratio**2
        strains = fillets.columns(flank, 2 * section.nodes)
        return modulus * strains.reshape(section.nodes, 2, -1)

    def roots(self, fillets: RootFillets, readings: Floats) -> RootResponse:
        """Stress under unit loads."""
        return RootResponse(fillets.points, readings)


@dataclass(frozen=True, eq=False)
class ModeLoads(PlaneLoads):
    """Pressure modes on the flanks of a plane body.

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

    @property
    def modes(self) -> FlankModes:
        """Modes of the flank."""
        body = self.body
        return FlankModes(body.mode_range_mm, closed=body.curve.closed, tip=body.tip)

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

    def columns(self, flank: SectorMesh | MeshedFlank) -> Floats:
        """Loads (N, 2, q) of the modes, per mm of width."""
        span, closed, tip = self.body.mode_range_mm, self.body.curve.closed, self.body.tip
        found = [
            mode_loads(flank, span, self.count, along=each, closed=closed, tip=tip)
            for each in DIRECTIONS[: 1 + self.friction]
        ]
        return np.hstack(found).reshape(len(flank.nodes), 2, -1)

    def on_coast(self, mesh: SectorMesh) -> tuple[Floats, int]:
        """Mirror images of the loads, and the tooth of the coast flank in a sector."""
        assert self.body.involute is not None
        loads = self.columns(mesh)
        images, tooth = mirrored_loads(
            mesh, loads.reshape(-1, loads.shape[2]), self.body.involute.turn_rad
        )
        return images.reshape(loads.shape), tooth

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
        """Subtract the logarithm, its images and the jump."""
        low, high = self.body.mode_range_mm
        n, tip = self.count, self.body.tip
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

    def along_near(self) -> Floats | None:
        """Jump, and images behind free corners."""
        return self.between(self._along_near()[None])[0] if self.friction else None

    def _along_near(self) -> Floats:
        """As `along_near`, moments: jump, and images behind free corners."""
        low, high = self.body.mode_range_mm
        n, field, length = self.count, self.near_field, high - low
        tip = None if self.body.tip is None else self.body.tip.behind(low)
        found = -field.jump * projected_sign(n, length, tip=tip)
        if any(field.wedge_along):
            near = projected_near_field(n, length, tip=tip)
            image = projected_near_field(n, length, wedge=field.wedge_along, tip=tip)
            found = found - field.kernel * (image - near)
        return np.asarray(found)


@dataclass(frozen=True, eq=False)
class NodeLoads(PlaneLoads):
    """Unit forces at the nodes of a flank; the response includes the near field.

    Attributes
    ----------
    nodes : (n,) array
        Arc lengths, mm.
    plane : {"strain", "stress"}
    """

    body: Body
    nodes: Floats
    plane: str
    friction: bool

    @property
    def count(self) -> int:  # type: ignore[override]
        """Number of nodes of a flank."""
        return self.nodes.size

    @property
    def modes(self) -> FlankModes:
        """The nodes, which replace modes."""
        body = self.body
        return FlankModes(body.mode_range_mm, closed=body.curve.closed, nodes=self.nodes)

    @property
    def near_field(self) -> NearField:
        """Strength of the logarithm, for the expected width of contacts."""
        return NearField(logarithm_strength(self.body.material, self.plane))

    def columns(self, flank: SectorMesh | MeshedFlank) -> Floats:
        """Loads (N, 2, q) of the unit forces, per mm of width."""
        directions = DIRECTIONS[: 1 + self.friction]
        found = [nodal_unit_loads(flank, self.nodes, along=each) for each in directions]
        return np.hstack(found).reshape(len(flank.nodes), 2, -1)

    def coefficients(self, moments: Floats) -> Floats:
        """The displacements at the nodes."""
        return moments

    def subtract_near_field(self, response: Floats, own: Numbers, account: Account) -> None:
        """Count the unit forces; the response includes the near field and is unchanged."""
        assert self.body.mesh is not None
        account.count(unit_loads_nodal=response.shape[2] * len(self.body.mesh.flanks))
