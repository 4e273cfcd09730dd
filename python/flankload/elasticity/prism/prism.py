"""Extent of a prism along its axis, and its discretization in this direction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.blas_threads import one_blas_thread
from flankload.bodies.axial_shape import share_middle
from flankload.bodies.body import SectorMesh
from flankload.elasticity.axial_basis import AxialBasis, functions_of
from flankload.elasticity.compliance.contributions import AxialModes, NearProducts, RootResponse
from flankload.elasticity.finite_elements import section_stiffness
from flankload.elasticity.prism.flank_potential import projected_potential, projected_tangential
from flankload.elasticity.prism.flank_surface import flank_surface
from flankload.elasticity.prism.root_surface import root_surface_stress
from flankload.errors import SceneError

if TYPE_CHECKING:
    from flankload.base.arrays import Floats
    from flankload.bodies.body import Body, Material, WholeMesh
    from flankload.bodies.root_fillet import RootFillets
    from flankload.bodies.shaft import FlexibleShaft
    from flankload.elasticity.compliance.contributions import NearField
    from flankload.elasticity.compliance.loads import FlankLoads
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.prism.flexible_bore import FlexibleBore

#: Least excess of the degree of displacements in z over that of loads: the error of the highest
#: mode is 0.06 %.
DEGREES_ABOVE_LOADS = 4
#: Degree of the cuts of a sector of one width: 0.005 % of the mean mode.
CUT_DEGREE = 4


@dataclass(frozen=True)
class Prism:
    """Extent of a plane body along its axis, and the discretization in this direction.

    Attributes
    ----------
    range_mm : (float, float)
        Axial range, ascending.
    twist : float
        kappa, rad/mm: counter-clockwise rotation of the section along z; for a gear h tan(beta)/r
        with h = 1 for a right hand, -1 for a left hand.
    degree : int
        Degree p of displacements in z.
    load_degree : int
        Degree of pressure modes in z, at most p - 4.
    cut_degree : int or None
        Degree of the displacements of the cuts between sectors in z, at most p; by default 4, and p
        with regions of other width, whose rings are thin.
    regions : tuple of (str, (float, float))
        Axial ranges of regions of the mesh that differ from `range_mm`, by name.
    shaft : FlexibleShaft or None
        Shaft that the bore follows; None: fixed bore.
    """

    range_mm: tuple[float, float]
    twist: float = 0.0
    degree: int = 8
    load_degree: int = 4
    cut_degree: int | None = None
    regions: tuple[tuple[str, tuple[float, float]], ...] = ()
    shaft: FlexibleShaft | None = None
    plane = "strain"
    components = 3
    rigid_motions = 6
    recovers_stress = False

    @property
    def factorisations(self) -> int:
        """Number of uncoupled sets of unknowns: two with a plane of symmetry across the axis."""
        extents = [self.range_mm, *(extent for _, extent in self.regions)]
        return 1 + (not self.twist and share_middle(extents))

    @property
    def axial(self) -> AxialBasis:
        """Functions of z over the width."""
        return AxialBasis(self.range_mm, self.degree)

    def section(self, mesh: SectorMesh | WholeMesh, material: Material) -> SectionStiffness:
        """Stiffness of a mesh."""
        regions, functions = functions_of(mesh, self.axial, dict(self.regions))
        section = section_stiffness(mesh.nodes, mesh.cells, material, self.twist, regions)
        cut_degree = self.cut_degree
        if cut_degree is None:
            cut_degree = CUT_DEGREE if functions == self.axial else self.degree
        cut_degree = min(cut_degree, self.degree)
        return replace(section, functions=functions, cut_degree=cut_degree)

    def bore(self, section: SectionStiffness, mesh: SectorMesh | WholeMesh) -> FlexibleBore | None:
        """The bore that follows the shaft; None if it is fixed or free."""
        if self.shaft is None:
            return None
        assert isinstance(mesh, SectorMesh)
        if mesh.has_free_bore:
            return None
        from flankload.elasticity.prism.flexible_bore import FlexibleBore

        return FlexibleBore.of(self.shaft, section, mesh)

    @one_blas_thread()
    def near_products(self, body: Body, near: NearField, n: int, *, friction: bool) -> NearProducts:
        """Products of the modes: half-space with k = kernel/2, images, and jump; mm⁵/N."""
        surface, degree, along = flank_surface(body, self), self.load_degree, np.zeros(())
        axial = AxialModes(self.range_mm, degree, self.twist, surface.cos_base_helix, surface.end)
        normal = 0.5 * near.kernel * projected_potential(surface, n, degree)
        if friction:
            along = projected_tangential(surface, n, degree, kernel=near.kernel, jump=near.jump)
        return NearProducts(axial, surface.products(n), normal, along)

    def root_columns(
        self, fillets: RootFillets, flank: int, section: SectionStiffness, material: Material
    ) -> Floats:
        """Stress (N, u, r) across the root line, by point and function of z."""
        nodes = fillets.on_elements
        stress = root_surface_stress(nodes, section.functions, self.axial, material, self.twist)
        columns = np.zeros((section.nodes, section.unknowns, len(stress)))
        columns[nodes.nodes] = stress.T.reshape(nodes.nodes.size, -1, len(stress))
        return columns

    def roots(self, fillets: RootFillets, readings: Floats, loads: FlankLoads) -> RootResponse:
        """Stress in the roots from the readings (k, r, q), by mode coefficients of forces."""
        found, points = loads.by_coefficients(readings), fillets.points
        shape = len(found), points.arc_length_mm.size, self.axial.count, found.shape[2]
        return RootResponse(points, found.reshape(shape), self.range_mm)

    def check(self, body: Body) -> None:
        """Raise a SceneError for an invalid width or load degree."""
        low, high = self.range_mm
        if not low < high:
            raise SceneError(key="face_width_mm", expected="above 0", found=f"{high - low:g}")
        most = self.degree - DEGREES_ABOVE_LOADS
        if not 0 <= self.load_degree <= most:
            raise SceneError(
                key="load_degree_z",
                expected=f"0 to {most} (axial_degree {self.degree} minus {DEGREES_ABOVE_LOADS})",
                found=self.load_degree,
            )
