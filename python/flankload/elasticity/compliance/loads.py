"""Unit loads on the flanks of a body (pressure modes, forces at nodes) and readings of it.

The normal displacement at (s, z) of a flank under a normal unit force at (s', z') is

    near field + V(s, z) g V(s', z')',  V = P_a(xi_s) P_b(xi_z) at index a (q_z + 1) + b

with g = `smooth[t]` for the tooth at t pitches, xi_s over `mode_range_mm` and xi_z over the width.
A plane body has the constant mode along its axis alone, q_z = 0, and loads per mm of width. With
the loads B of the modes, the response C of the elements and the near field of the same flank
(`near_field` in the plane, `prism.flank_potential`)

    g_0 = D⁻¹ (B'CB - <P, near P>) D⁻¹,  g_t = D⁻¹ B'C_t B D⁻¹,  D = <P, P>

In three dimensions with area elements ds dz/cos(beta_b), which the loads n/cos(beta_b) =
(n_t, -kappa l) per ds dz include, D_ab = L_s b/((2a + 1)(2b + 1) cos(beta_b)) without a tip.

With friction, loads along the profile are further columns of the same elimination; `tangential` is
their g, without the near field of `jump` and `wedge_along`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.bodies.free_corner import along_strengths, image_strengths
from flankload.elasticity.axial_basis import mode_norms_z
from flankload.elasticity.compliance.contributions import FlankModes, NearField
from flankload.elasticity.near_field import (
    jump_strength,
    logarithm_strength,
    mirrored_loads,
    mode_loads,
)
from flankload.elasticity.nodal_loads import nodal_unit_loads, nodes_of

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Body, MeshedFlank, SectorMesh
    from flankload.cost import Account
    from flankload.elasticity.compliance.contributions import NearProducts
    from flankload.elasticity.compliance.plane_extent import PlaneExtent
    from flankload.elasticity.prism import Prism

#: Directions of unit loads.
Along = Literal["normal", "tangent"]
DIRECTIONS: tuple[Along, ...] = ("normal", "tangent")


class FlankLoads(ABC):
    """Normal unit loads on the flanks of a body, with friction followed by as many tangential ones.

    `extent` is that of the body along its axis.
    """

    body: Body
    extent: PlaneExtent | Prism
    friction: bool

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of normal loads of a flank."""

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

    @abstractmethod
    def coefficients(self, moments: Floats) -> Floats:
        """Mode coefficients from moments (k, r, …), along the second axis."""

    def between(self, moments: Floats) -> Floats:
        """Response (k, r, q) as a map between mode coefficients, from that between moments."""
        return self.by_coefficients(self.coefficients(moments))

    def by_coefficients(self, readings: Floats) -> Floats:
        """Readings (k, r, q) under modes, from those under unit loads."""
        return self.coefficients(readings.swapaxes(1, 2)).swapaxes(1, 2)


@dataclass(frozen=True, eq=False)
class ModeLoads(FlankLoads):
    """Products of pressure modes along the profile and Legendre polynomials of z.

    Attributes
    ----------
    n_modes : int
        Number of modes along the profile, including those of its tip.
    """

    body: Body
    extent: PlaneExtent | Prism
    n_modes: int
    friction: bool

    @property
    def count(self) -> int:
        """Number of products."""
        return self.n_modes * (self.extent.load_degree + 1)

    @cached_property
    def _near(self) -> NearProducts:
        return self.extent.near_products(
            self.body, self.near_field, self.n_modes, friction=self.friction
        )

    @property
    def modes(self) -> FlankModes:
        """Modes of the flank over the width."""
        body = self.body
        return FlankModes(
            body.mode_range_mm, closed=body.curve.closed, tip=body.tip, axial=self._near.axial
        )

    @property
    def near_field(self) -> NearField:
        """Near field that the modes do not include."""
        material, plane = self.body.material, self.extent.plane
        return NearField(
            logarithm_strength(material, plane),
            jump=jump_strength(material, plane) if self.friction else 0.0,
            wedge=image_strengths(self.body),
            wedge_along=along_strengths(self.body),
        )

    def columns(self, flank: SectorMesh | MeshedFlank) -> Floats:
        """Loads (N, u, q) of the products, in the plane per mm of width."""
        return self._over_width(self._in_section(flank), len(flank.nodes))

    def on_coast(self, mesh: SectorMesh) -> tuple[Floats, int]:
        """Mirror images of the loads, and the tooth of the coast flank in a sector.

        In three dimensions loads are rotated by 180 degrees about the centre line of the tooth:
        they lean out of the other end face, so that the near field is that of reversed z.
        """
        assert self.body.involute is not None
        images, tooth = mirrored_loads(mesh, self._in_section(mesh), self.body.involute.turn_rad)
        return self._over_width(images, len(mesh.nodes)), tooth

    def coefficients(self, moments: Floats) -> Floats:
        """Mode coefficients from moments (k, r, …), along the second axis."""
        n, inverse = self.count, self._inverse_products
        blocks = moments.reshape(len(moments), moments.shape[1] // n, n, -1)
        return np.asarray((inverse @ blocks).reshape(moments.shape))

    def subtract_near_field(self, response: Floats, own: Numbers, account: Account) -> None:
        """Subtract the near field of the flank, and of tangential loads."""
        p, near = self.count, self._near
        response[own, :p, :p] -= near.normal
        if response.shape[1] > p:
            response[own, :p, p:] -= near.along
            response[own, p:, :p] -= near.along.T
            response[own, p:, p:] -= near.tangential
        response[:] = self.between(response)

    def along_near(self) -> Floats | None:
        """Near field of loads along the profile."""
        return self.between(self._near.along[None])[0] if self.friction else None

    def from_section(self, fe_error: Floats) -> Floats:
        """Estimated error (1, p, p) of the elements from that of line loads per length (1, n, n).

        The error of the plane elements varies within a few of them, over which the load hardly
        changes along the axis.
        """
        cosine = self._near.axial.cos_base_helix
        return np.asarray(cosine**2 * np.kron(fe_error, np.diag(self._inverse_norms_z)))

    @property
    def _inverse_norms_z(self) -> Floats:
        return 1.0 / mode_norms_z(self.extent.axial.width_mm, self.extent.load_degree)

    @cached_property
    def _inverse_products(self) -> Floats:
        """Inverse of the products of the modes <P_ab, P_cd>."""
        in_section = np.linalg.inv(self._near.modes)
        return np.asarray(np.kron(in_section, np.diag(self._inverse_norms_z)))

    def _in_section(self, flank: SectorMesh | MeshedFlank) -> Floats:
        """Loads (c N, m) of the modes along the profile, per length of z."""
        body = self.body
        found = [
            mode_loads(
                flank,
                body.mode_range_mm,
                self.n_modes,
                along=each,
                closed=body.curve.closed,
                tip=body.tip,
                twist=self.extent.twist,
            )
            for each in DIRECTIONS[: 1 + self.friction]
        ]
        return np.hstack(found)

    def _over_width(self, in_section: Floats, nodes: int) -> Floats:
        """Products of loads (c N, m) with the polynomials of z, by node and unknown."""
        along = self.extent.axial.load_vectors(self.extent.load_degree)
        of_nodes = in_section.reshape(nodes, -1, in_section.shape[1])
        loads = np.einsum("ica,kb->ikcab", of_nodes, along)
        return loads.reshape(nodes, -1, in_section.shape[1] * along.shape[1])


@dataclass(frozen=True, eq=False)
class NodeLoads(FlankLoads):
    """Unit forces at the nodes of a flank of a plane body; the response includes the near field."""

    body: Body
    extent: PlaneExtent
    friction: bool

    @property
    def nodes(self) -> Floats:
        """Arc lengths (n,), mm."""
        assert self.body.mesh is not None
        return nodes_of(self.body.mesh)

    @property
    def count(self) -> int:
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
        return NearField(logarithm_strength(self.body.material, self.extent.plane))

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
