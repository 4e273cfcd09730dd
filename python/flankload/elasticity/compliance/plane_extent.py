"""A plane body along its axis: the constant functions of z of a prism, per mm of width."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.compliance.contributions import AxialModes, NearProducts, RootResponse
from flankload.elasticity.finite_elements import plane_moduli, stiffness
from flankload.elasticity.near_field import mode_products, projected_near_field, projected_sign

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body, Material, SectorMesh, WholeMesh
    from flankload.bodies.root_fillet import RootFillets
    from flankload.elasticity.compliance.contributions import NearField
    from flankload.elasticity.compliance.loads import FlankLoads
    from flankload.elasticity.finite_elements import SectionStiffness


@dataclass(frozen=True)
class PlaneExtent:
    """Extent of a plane body along its axis; its methods are those of `Prism`.

    Attributes
    ----------
    plane : {"strain", "stress"}
    width_mm : float
        Width of loads and displacements.
    components : int
        Components of a displacement.
    rigid_motions : int
        Motions of a rigid body.
    factorisations : int
        Number of sets of unknowns that are not coupled.
    recovers_stress : bool
        Whether stress recovery estimates the error of its elements, else that of a plane section.
    """

    plane: str = "strain"
    width_mm: float = 1.0
    load_degree = 0
    twist = None
    regions = ()
    components = 2
    rigid_motions = 3
    factorisations = 1
    recovers_stress = True

    @property
    def axial(self) -> AxialBasis:
        """The constant function of z."""
        return AxialBasis((0.0, self.width_mm), 0)

    def check(self, body: Body) -> None:
        """Every body is valid."""

    def section(self, mesh: SectorMesh | WholeMesh, material: Material) -> SectionStiffness:
        """Stiffness of a mesh."""
        found = stiffness(mesh.nodes, mesh.cells, material, self.plane)
        return replace(found, functions=self.axial)

    def bore(self, section: SectionStiffness, mesh: SectorMesh | WholeMesh) -> None:
        """No bore follows a shaft."""

    def near_products(self, body: Body, near: NearField, n: int, *, friction: bool) -> NearProducts:
        """Products of n modes: logarithm, images behind free corners, and jump; mm⁴/N."""
        (low, high), tip, closed = body.mode_range_mm, body.tip, body.curve.closed
        length, behind = high - low, None if tip is None else tip.behind(low)

        def logarithm(wedge: tuple[float, float] = (0.0, 0.0)) -> Floats:
            return -near.kernel * projected_near_field(
                n, length, wedge=wedge, closed=closed, tip=behind
            )

        along, apart = np.zeros((n, n)), logarithm()
        if friction:
            along = -near.jump * projected_sign(n, length, tip=behind)
            along += logarithm(near.wedge_along) - apart
        modes = mode_products((low, high), n, tip, closed=closed)
        return NearProducts(AxialModes(), modes, logarithm(near.wedge), along, apart)

    def root_columns(
        self, fillets: RootFillets, flank: int, section: SectionStiffness, material: Material
    ) -> Floats:
        """Strain (N, 2, r) along the free surface times E'."""
        modulus, _ = plane_moduli(material, self.plane)
        strains = fillets.columns(flank, 2 * section.nodes)
        return modulus * strains.reshape(section.nodes, 2, -1)

    def roots(self, fillets: RootFillets, readings: Floats, loads: FlankLoads) -> RootResponse:
        """Stress in the roots from the readings (k, r, q) under unit loads."""
        return RootResponse(fillets.points, readings)
