"""Displacement and stress in a whole prism under forces on its flanks.

The ring of sectors is solved by `recovered_ring`. The solid mesh for output has layers of quadratic
elements along the axis, enough for the degree of the displacements.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import SectorMesh
from flankload.elasticity.fe_error import recovered_strains
from flankload.elasticity.finite_elements import lame_parameters
from flankload.elasticity.loaded_body import coast_edges, node_widths, on_edges, ring_of
from flankload.elasticity.near_field import loaded_edges
from flankload.elasticity.prism.prism import COMPONENTS
from flankload.elasticity.recovered_ring import RecoveredRing

if TYPE_CHECKING:
    from flankload.base.arrays import Cells, Flags, Floats, Numbers
    from flankload.bodies.body import Body
    from flankload.elasticity.axial_basis import AxialBasis
    from flankload.elasticity.prism.prism import Prism

#: Solid element of each plane element, by name in meshio.
SOLIDS = {"quad9": "hexahedron27", "triangle6": "wedge18"}
#: Node of the plane element, and axial station, of each node of a solid: corners below and above,
#: edges below and above, axial edges; then faces and middle in the order of VTK.
SOLID_NODES = {
    "quad9": (
        (0, 1, 2, 3, 0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 7, 0, 1, 2, 3, 7, 5, 4, 6, 8, 8, 8),
        (0, 0, 0, 0, 2, 2, 2, 2, 0, 0, 0, 0, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 0, 2, 1),
    ),
    "triangle6": (
        (0, 1, 2, 0, 1, 2, 3, 4, 5, 3, 4, 5, 0, 1, 2, 3, 4, 5),
        (0, 0, 0, 2, 2, 2, 0, 0, 0, 2, 2, 2, 1, 1, 1, 1, 1, 1),
    ),
}


@dataclass(frozen=True, eq=False)
class SolidPart:
    """Solid elements of one width: n nodes of the whole section at J axial stations.

    Attributes
    ----------
    nodes : (n,) array
        Numbers in the section of the whole body.
    cells : ((kind, (E, k) array), ...)
        Plane elements, by nodes of the part.
    z_mm : (J,) array
        Stations, ascending.
    values, slopes : (b, J, p + 1) arrays
        Axial functions of each basis at the stations, and their derivatives.
    """

    nodes: Numbers
    cells: Cells
    z_mm: Floats
    values: Floats
    slopes: Floats

    @property
    def solids(self) -> Cells:
        """Solid elements, with points numbered by node, then station."""
        count, found = self.z_mm.size, []
        for kind, cells in self.cells:
            node, level = map(np.array, SOLID_NODES[kind])
            first = 2 * np.arange(count // 2)[:, None, None]
            points = cells[:, node] * count + level + first
            found.append((SOLIDS[kind], points.reshape(-1, node.size)))
        return tuple(found)


@dataclass(frozen=True, eq=False)
class LoadedPrism:
    """The condensed elements of a whole prism, for forces on its flanks.

    Attributes
    ----------
    body : Body
        From `Body.for_elements`.
    nodes : (M, 2) array
        Section of the whole body at z = 0, mm, without duplicate nodes on the cuts.
    numbers : (z, N) array
        Node of the whole body for each node of each sector.
    basis_of : (M,) array
        Number of the axial basis of each node.
    parts : tuple of SolidPart
        One for each width of regions.
    ring : RecoveredRing
        Solver for forces on the nodes of its sectors.
    """

    body: Body
    prism: Prism
    nodes: Floats
    numbers: Numbers
    basis_of: Numbers
    parts: tuple[SolidPart, ...]
    ring: RecoveredRing

    @property
    def mesh(self) -> SectorMesh:
        """Mesh of a sector."""
        assert isinstance(self.body.mesh, SectorMesh)
        return self.body.mesh

    def on_flank(
        self, tooth: Numbers, s_mm: Floats, coast: Flags | None = None
    ) -> tuple[Numbers, Numbers, Floats]:
        """Sectors (n,), nodes (n, 3) of the edges at points of flanks, and shape functions.

        `coast` (n,): whether a point is on a coast flank.
        """
        edges, s = loaded_edges(self.mesh)
        at, shapes = on_edges(s, s_mm)
        nodes, sector = edges[at], tooth
        if coast is not None and coast.any():
            images, of_sector = coast_edges(self.body, self.mesh, edges)
            nodes, sector = np.where(coast[:, None], images[at], nodes), tooth - of_sector * coast
        return sector % self.mesh.teeth, nodes, shapes

    def flank_widths(self, *, coast: bool = False) -> tuple[Numbers, Floats]:
        """Nodes (k,) of the flank of a sector, and the area (k,) of each per mm along z, mm."""
        edges, s = loaded_edges(self.mesh)
        if coast:
            edges, _ = coast_edges(self.body, self.mesh, edges)
        nodes, widths = node_widths(edges, s)
        return nodes, widths * np.hypot(1.0, self.prism.twist * self.body.normal_lever_mm)

    def displacements(
        self,
        tooth: Numbers,
        s_mm: Floats,
        spans_mm: Floats,
        force_N: Floats,
        *,
        coast: Flags | None = None,
    ) -> Floats:
        """Displacements (M, p + 1, 3) under forces (n, 3), N, uniform over spans on flanks.

        Forces act on teeth (n,) at arc lengths (n,), between the axial ends (n, 2) of their spans,
        on coast flanks where `coast` (n,) is true.
        Components are in the section rotated with the helix, in the frame of the body;
        displacements are by node and function of z.
        """
        means = self.prism.axial.means(spans_mm)
        sector, nodes, shapes = self.on_flank(tooth, s_mm, coast)
        forces = np.zeros((len(self.nodes), self.prism.degree + 1, COMPONENTS))
        parts = np.einsum("na,nk,nc->nakc", shapes, means, force_N)
        np.add.at(forces, self.numbers[sector[:, None], nodes], parts)
        return self.ring.in_body(forces, self.numbers)

    def fields(self, part: SolidPart, moved: Floats) -> tuple[Floats, Floats]:
        """Displacement (n, J, 3), mm, and stress (n, J, 6), MPa, at the points of a part.

        In the section rotated with the helix, from the result of `displacements`. The stress xx,
        yy, zz, xy, yz, xz is averaged over the elements of a node.
        """
        own, basis, twist = moved[part.nodes], self.basis_of[part.nodes], self.prism.twist
        v, by_z = (
            np.einsum("njk,nkc->njc", functions[basis], own)
            for functions in (part.values, part.slopes)
        )
        places = self.nodes[part.nodes]
        columns = np.zeros((len(places), 2, v[0].size))
        columns[:, 0] = v.reshape(len(places), -1)  # in x: e_xx and 2 e_xy are its derivatives
        strains = recovered_strains(places, part.cells, columns.reshape(2 * len(places), -1))
        slopes = strains.reshape(len(places), 3, *v.shape[1:])
        by_x, by_y = slopes[:, 0], slopes[:, 2]
        x, y = places.T[:, :, None, None]
        about = np.stack([-v[..., 1], v[..., 0], np.zeros_like(v[..., 0])], axis=-1)
        along = by_z + twist * (y * by_x - x * by_y + about)
        normal = np.stack([by_x[..., 0], by_y[..., 1], along[..., 2]])
        shear = np.stack(
            [
                by_y[..., 0] + by_x[..., 1],
                by_y[..., 2] + along[..., 1],
                by_x[..., 2] + along[..., 0],
            ]
        )
        first, second = lame_parameters(self.body.material, "strain")
        stress = [first * normal.sum(axis=0) + 2.0 * second * normal, second * shear]
        return v, np.concatenate(stress).transpose(1, 2, 0)


def loaded_prism(body: Body, prism: Prism) -> LoadedPrism:
    """Factorise the elements of an elastic body of equal sectors for forces on its flanks."""
    body = body.for_elements()
    mesh = body.mesh
    assert isinstance(mesh, SectorMesh)
    section = prism.section(mesh, body.material)
    ring = RecoveredRing.of(section, mesh, body.material)
    nodes, whole, numbers = ring_of(mesh)
    basis_of = np.empty(len(nodes), dtype=np.int64)
    bases, basis_of[numbers] = section.functions.of_nodes(np.arange(len(mesh.nodes)))
    parts = _parts(whole, section.region_of_cells, bases)
    return LoadedPrism(body, prism, nodes, numbers, basis_of, parts, ring)


def _parts(
    whole: Cells, regions: tuple[int, ...], bases: tuple[AxialBasis, ...]
) -> tuple[SolidPart, ...]:
    """Parts of the whole body by width."""
    found = []
    for region in sorted(set(regions)):
        low, high = bases[region].range_mm
        z = np.linspace(low, high, 2 * -(-bases[region].degree // 2) + 1)
        cells = [block for own, block in zip(regions, whole, strict=True) if own == region]
        nodes = np.unique(np.concatenate([data.ravel() for _, data in cells]))
        found.append(
            SolidPart(
                nodes,
                tuple((kind, np.searchsorted(nodes, data)) for kind, data in cells),
                z,
                np.stack([basis.values(z) for basis in bases]),
                np.stack([basis.derivatives(z) for basis in bases]),
            )
        )
    return tuple(found)
