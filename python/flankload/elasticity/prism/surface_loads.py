"""Unit loads on the flanks of a prism: a plane section over a width, straight or twisted.

The normal displacement at (s, z) of a flank under a normal unit force at (s', z') is

    near field + V(s, z) g V(s', z')',  V = P_a(xi_s) P_b(xi_z) at index a (q_z + 1) + b

with g = `smooth[t]` for the tooth at t pitches, xi_s over `mode_range_mm` and xi_z over
`axial.range_mm`. The near field on the same flank is that of `flank_potential`: a half-space with
k = `kernel`/2, and images behind both end faces with the strengths `axial.end` and behind free
corners with `wedge`. Hence

    g_0 = D⁻¹ (B'CB - <P, near P>) D⁻¹,  g_t = D⁻¹ B'C_t B D⁻¹
    D_ab = L_s b/((2a + 1)(2b + 1) cos(beta_b))

with area elements ds dz/cos(beta_b), included in the loads n/cos(beta_b) = (n_t, -kappa l) per
ds dz. With a tip rounding or chamfer, D = <P, P> over flank and tip, including the modes of the tip
(`bodies.tip_modes`) times the same polynomials of z.

With friction, loads along the profile, t/cos(beta_b) per ds dz, are further columns of the same
elimination; `tangential` is their g, without the near field with `jump` and `wedge_along`.

Loads on coast flanks are those on working flanks rotated by 180 degrees about the centre line of
the tooth: they lean out of the other end face, so that the near field is that of reversed z.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.axial_basis import mode_norms_z
from flankload.elasticity.compliance.contributions import (
    AxialModes,
    FlankModes,
    NearField,
    RootResponse,
)
from flankload.elasticity.compliance.loads import DIRECTIONS, FlankLoads
from flankload.elasticity.near_field import (
    jump_strength,
    logarithm_strength,
    mirrored_loads,
    mode_loads,
)
from flankload.elasticity.prism.flank_potential import projected_potential, projected_tangential
from flankload.elasticity.prism.flank_surface import flank_surface
from flankload.elasticity.prism.prism import COMPONENTS
from flankload.elasticity.prism.root_surface import root_surface_stress

if TYPE_CHECKING:
    from flankload.base.arrays import Floats, Numbers
    from flankload.bodies.body import Body, MeshedFlank, SectorMesh
    from flankload.bodies.root_fillet import RootFillets
    from flankload.cost import Account
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.prism.flank_surface import FlankSurface
    from flankload.elasticity.prism.prism import Prism


@dataclass(frozen=True, eq=False)
class SurfaceLoads(FlankLoads):
    """Products of pressure modes along the profile and Legendre polynomials of z.

    Attributes
    ----------
    n_modes : int
        Number of modes along the profile, including those of its tip.
    """

    body: Body
    prism: Prism
    n_modes: int
    friction: bool

    @property
    def count(self) -> int:  # type: ignore[override]
        """Number of products."""
        return self.n_modes * (self.prism.load_degree + 1)

    @property
    def functions_of_roots(self) -> int:  # type: ignore[override]
        """Those of the displacements."""
        return self.prism.degree + 1

    @cached_property
    def surface(self) -> FlankSurface:
        """The working flank."""
        return flank_surface(self.body, self.prism)

    @property
    def modes(self) -> FlankModes:
        """Modes of the flank over the width."""
        prism, surface = self.prism, self.surface
        axial = AxialModes(
            prism.range_mm, prism.load_degree, prism.twist, surface.cos_base_helix, surface.end
        )
        return FlankModes(self.body.mode_range_mm, tip=self.body.tip, axial=axial)

    @property
    def near_field(self) -> NearField:
        """That of a half-space with k = kernel/2, and images behind free corners."""
        material, surface = self.body.material, self.surface
        return NearField(
            logarithm_strength(material, "strain"),
            jump=jump_strength(material, "strain") if self.friction else 0.0,
            wedge=surface.wedge,
            wedge_along=surface.wedge_along if self.friction else (0.0, 0.0),
        )

    def columns(self, flank: SectorMesh | MeshedFlank) -> Floats:
        """Loads (N, 3 (p + 1), q) of the products."""
        return self._over_width(self._in_section(flank))

    def on_coast(self, mesh: SectorMesh) -> tuple[Floats, int]:
        """The same of the flank rotated about the centre line of the tooth, and its tooth."""
        assert self.body.involute is not None
        images, tooth = mirrored_loads(mesh, self._in_section(mesh), self.body.involute.turn_rad)
        return self._over_width(images), tooth

    def root_columns(self, fillets: RootFillets, flank: int, section: SectionStiffness) -> Floats:
        """Stress across the root line, by point and function of z."""
        nodes, prism = fillets.on_elements, self.prism
        stress = root_surface_stress(
            nodes, section.functions, prism.axial, self.body.material, prism.twist
        )
        columns = np.zeros((section.nodes, section.unknowns, len(stress)))
        columns[nodes.nodes] = stress.T.reshape(nodes.nodes.size, -1, len(stress))
        return columns

    def roots(self, fillets: RootFillets, readings: Floats) -> RootResponse:
        """Stress by mode coefficients of forces."""
        found = self.by_coefficients(readings)
        points, prism = fillets.points, self.prism
        shape = len(found), points.arc_length_mm.size, self.functions_of_roots, found.shape[2]
        return RootResponse(points, found.reshape(shape), prism.range_mm)

    def coefficients(self, moments: Floats) -> Floats:
        """Mode coefficients from moments (k, r, …), along the second axis."""
        n, inverse = self.count, self._inverse_products
        blocks = moments.reshape(len(moments), moments.shape[1] // n, n, -1)
        return np.asarray((inverse @ blocks).reshape(moments.shape))

    def subtract_near_field(self, response: Floats, own: Numbers, account: Account) -> None:
        """Subtract the potential of the flank, and of tangential loads."""
        p, kernel = self.count, self.near_field.kernel
        potential = projected_potential(self.surface, self.n_modes, self.prism.load_degree)
        response[own, :p, :p] -= 0.5 * kernel * potential
        if self.friction:
            response[own, :p, p:] -= self._along_near
            response[own, p:, :p] -= self._along_near.T
        response[:] = self.between(response)

    def along_near(self) -> Floats | None:
        """That of loads along the profile."""
        return self.between(self._along_near[None])[0] if self.friction else None

    @cached_property
    def _along_near(self) -> Floats:
        """As `along_near`, moments."""
        near, degree = self.near_field, self.prism.load_degree
        return projected_tangential(
            self.surface, self.n_modes, degree, kernel=near.kernel, jump=near.jump
        )

    @cached_property
    def _inverse_products(self) -> Floats:
        """Inverse of the products of the modes <P_ab, P_cd>."""
        along_axis = mode_norms_z(self.surface.width_mm, self.prism.load_degree)
        in_section = np.linalg.inv(self.surface.products(self.n_modes))
        return np.asarray(np.kron(in_section, np.diag(1.0 / along_axis)))

    def from_section(self, fe_error: Floats) -> Floats:
        """Estimated error (1, p, q) from that of line loads per length (1, n, m).

        The error of the plane elements varies within a few of them, over which the load hardly
        changes along the axis.
        """
        along = np.diag(1.0 / mode_norms_z(self.surface.width_mm, self.prism.load_degree))
        cosine = self.surface.cos_base_helix
        found = cosine**2 * np.kron(fe_error[0], along)
        found[:, len(found) :] /= cosine  # loads along the profile are in the section
        return np.asarray(found[None])

    def _in_section(self, flank: SectorMesh | MeshedFlank) -> Floats:
        """Loads (3 N, m) of the modes along the profile, per length of z."""
        span, tip, twist = self.body.mode_range_mm, self.body.tip, self.prism.twist
        found = [
            mode_loads(flank, span, self.n_modes, along=each, tip=tip, twist=twist)
            for each in DIRECTIONS[: 1 + self.friction]
        ]
        return np.hstack(found)

    def _over_width(self, in_section: Floats) -> Floats:
        """Products of loads (3 N, m) with the polynomials of z, by node and unknown."""
        along = self.prism.axial.load_vectors(self.prism.load_degree)
        m, (functions, n_z) = in_section.shape[1], along.shape
        of_nodes = in_section.reshape(-1, COMPONENTS, m)
        loads = np.einsum("ica,kb->ikcab", of_nodes, along)
        return loads.reshape(len(of_nodes), COMPONENTS * functions, m * n_z)
