"""Displacement and stress in a whole body under forces on its flanks.

A ring of equal sectors is solved by `recovered_ring`, a whole mesh by its stored fronts. Forces act
on edges of elements, which do not resolve contacts that are narrower than an element. A plane body
has one constant function along its axis and is written as its section; a prism is written as layers
of quadratic elements along the axis, enough for the degree of the displacements.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from flankload.bodies.body import SectorMesh
from flankload.elasticity.axial_basis import AxialBasis
from flankload.elasticity.compliance.plane_extent import PlaneExtent
from flankload.elasticity.fe_error import recovered_strains
from flankload.elasticity.finite_elements import lame_parameters
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.fronts.recovery import Recovery
from flankload.elasticity.near_field import coast_nodes, loaded_edges
from flankload.elasticity.recovered_ring import RecoveredRing
from flankload.elasticity.whole_body import parts_of, ring_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flankload.base.arrays import Cells, Flags, Floats, Numbers
    from flankload.bodies.body import Body, WholeMesh
    from flankload.elasticity.finite_elements import SectionStiffness
    from flankload.elasticity.prism import Prism
    from flankload.elasticity.whole_body import BodyPart


@dataclass(frozen=True, eq=False)
class PointForces:
    """Forces (n, 3) at points of the flanks of a body, N.

    Their frame is that of the body, rotated with the helix; `normal_N` (n,) are magnitudes of the
    components normal to the flank, `s_mm` (n,) arc lengths on the flank of the elements, and
    `spans_mm` (n, 2) the ends along the axis of the slice over which a force is uniform; `coast`
    (n,) whether it acts on a coast flank.
    """

    tooth: Numbers
    s_mm: Floats
    spans_mm: Floats
    force_N: Floats
    normal_N: Floats
    coast: Flags

    @classmethod
    def joined(cls, parts: Sequence[PointForces]) -> PointForces:
        """All forces of several sets."""
        names = [item.name for item in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

    @property
    def flanks(self) -> list[tuple[int, bool]]:
        """Tooth of each loaded flank, and whether it is a coast flank."""
        return sorted(set(zip(self.tooth.tolist(), self.coast.tolist(), strict=True)))


@dataclass(frozen=True, eq=False)
class LoadedBody:
    """The condensed elements of a whole body, in its frame, for forces on its flanks.

    Attributes
    ----------
    body : Body
        From `Body.for_elements`.
    section : SectionStiffness
        Section of the mesh of the body, with the functions of z of its nodes.
    plane : {"strain", "stress"}
    axial : AxialBasis
        Functions of z over the width of the teeth.
    nodes : (M, 2) array
        Section of the whole body at z = 0, mm, without duplicate nodes on the cuts.
    numbers : (z, N) array
        Node of the whole body for each node of each sector; one row for a whole mesh.
    parts : tuple of BodyPart
        One for each width of regions.
    solve : callable
        Nodal forces (M, p + 1, c) by function of z and component -> displacements of that shape.
    """

    body: Body
    section: SectionStiffness
    plane: str
    axial: AxialBasis
    nodes: Floats
    numbers: Numbers
    parts: tuple[BodyPart, ...]
    solve: Callable[[Floats], Floats]

    @property
    def cells(self) -> Cells:
        """Elements of all parts, by index of the points of the parts in their order."""
        found, first = [], 0
        for part in self.parts:
            found += [(kind, data + first) for kind, data in part.solids]
            first += part.nodes.size * part.z_mm.size
        return tuple(found)

    def displacements(self, forces: PointForces) -> Floats:
        """Displacements (M, p + 1, 3) under forces on flanks, by node and function of z.

        Components are in the section rotated with the helix, in the frame of the body. Forces
        beyond the elements act on the last node. Coast flanks require involutes and equal sectors.
        """
        components = self.section.components
        on_nodes = np.zeros((len(self.nodes), self.axial.count, components))
        nodes, shapes = self._at(forces)
        means = self.axial.means(forces.spans_mm)
        parts = np.einsum("na,nk,nc->nakc", shapes, means, forces.force_N[:, :components])
        np.add.at(on_nodes, nodes, parts)
        return np.pad(self.solve(on_nodes), ((0, 0), (0, 0), (0, 3 - components)))

    def flank_widths(self, tooth: int, *, coast: bool = False) -> tuple[Numbers, Floats]:
        """Nodes (k,) of a flank, and the area (k,) of each per mm along z, mm."""
        nodes, widths = node_widths(*self._edges(tooth, coast=coast))
        return nodes, widths * np.hypot(1.0, self.section.twist * self.body.normal_lever_mm)

    def nodal(self, part: BodyPart, forces: PointForces) -> tuple[Floats, Floats]:
        """Forces (n, J, 3) at the points of a part, N, and pressures (n, J) on its flanks, MPa."""
        place = np.full(len(self.nodes), -1)
        place[part.nodes] = np.arange(part.nodes.size)
        nodes, shapes = self._at(forces)
        at, along = place[nodes], part.shares(forces.spans_mm)
        columns = np.column_stack([forces.force_N, forces.normal_N])
        found = np.zeros((part.nodes.size, part.z_mm.size, 4))
        parts = np.einsum("na,nj,nc->najc", shapes, along, columns)
        np.add.at(found, at[at >= 0], parts[at >= 0])
        area = np.full((part.nodes.size, 1), np.inf)
        for tooth, coast in forces.flanks:
            nodes, widths = self.flank_widths(tooth, coast=coast)
            own = place[nodes]
            area[own[own >= 0], 0] = widths[own >= 0]
        levels = part.basis.width_mm * part.shares(np.array([part.basis.range_mm]))
        return found[..., :3], found[..., 3] / (area * levels)

    def fields(self, part: BodyPart, moved: Floats) -> tuple[Floats, Floats]:
        """Displacement (n, J, 3), mm, and stress (n, J, 6), MPa, at the points of a part.

        In the section rotated with the helix, from the result of `displacements`. The stress xx,
        yy, zz, xy, yz, xz is averaged over the elements of a node.
        """
        bases, basis_of = self.section.functions.of_nodes(np.arange(self.section.nodes))
        number = np.empty(len(self.nodes), dtype=np.int64)
        number[self.numbers] = basis_of
        own, number, z = moved[part.nodes], number[part.nodes], part.z_mm
        v, by_z = (
            np.einsum("njk,nkc->njc", np.stack(functions)[number], own)
            for functions in zip(
                *((basis.values(z), basis.derivatives(z)) for basis in bases), strict=True
            )
        )
        places, twist = self.nodes[part.nodes], self.section.twist
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
        first, second = lame_parameters(self.body.material, self.plane)
        stress = first * normal.sum(axis=0) + 2.0 * second * normal
        if self.plane == "stress":
            stress[2] = 0.0
        return v, np.concatenate([stress, second * shear]).transpose(1, 2, 0)

    def _at(self, forces: PointForces) -> tuple[Numbers, Floats]:
        """Nodes (n, 3) of the edges at forces, and their shape functions there."""
        nodes = np.empty((forces.tooth.size, 3), dtype=np.int64)
        shapes = np.empty(nodes.shape)
        for tooth, coast in forces.flanks:
            own = (forces.tooth == tooth) & (forces.coast == coast)
            edges, s = self._edges(tooth, coast=coast)
            at, shapes[own] = on_edges(s, forces.s_mm[own])
            nodes[own] = edges[at]
        return nodes, shapes

    def _edges(self, tooth: int, *, coast: bool) -> tuple[Numbers, Floats]:
        """Nodes (m, 3) of the whole body on the edges of a flank, and their arc lengths."""
        mesh = self.body.mesh
        assert mesh is not None
        if not isinstance(mesh, SectorMesh):
            return loaded_edges(next(flank for flank in mesh.flanks if flank.tooth == tooth))
        edges, s = loaded_edges(mesh)
        if coast:
            edges, of_sector = self._coast_edges
            tooth -= of_sector
        return self.numbers[tooth % mesh.teeth][edges], s

    @cached_property
    def _coast_edges(self) -> tuple[Numbers, int]:
        """Edges of the coast flank in a sector (mirror images), and the number of its tooth."""
        mesh, involute = self.body.mesh, self.body.involute
        assert isinstance(mesh, SectorMesh)
        assert involute is not None
        edges, _ = loaded_edges(mesh)
        nodes, place = np.unique(edges, return_inverse=True)
        images, tooth = coast_nodes(mesh, nodes, involute.turn_rad)
        return images[place.reshape(edges.shape)], tooth


def loaded_body(
    body: Body, plane: str = "strain", *, prism: Prism | None = None, width_mm: float = 1.0
) -> LoadedBody:
    """Condense the elements of an elastic body for forces on its flanks.

    `prism`: extent along the axis; without it, a plane body of a width.
    """
    body = body.for_elements()
    mesh = body.mesh
    assert mesh is not None
    extent = prism or PlaneExtent(plane, width_mm)
    axial, section = extent.axial, extent.section(mesh, body.material)
    if isinstance(mesh, SectorMesh):
        nodes, cells, numbers = ring_of(mesh)
        solve = _ring_solver(section, body, numbers)
    else:
        nodes, cells, numbers = mesh.nodes, mesh.cells, np.arange(len(mesh.nodes))[None]
        solve = _whole_solver(section, mesh)
    parts = parts_of(cells, section)
    return LoadedBody(body, section, plane, axial, nodes, numbers, parts, solve)


def on_edges(s: Floats, places: Floats) -> tuple[Numbers, Floats]:
    """Edges of points on a flank, and the shape functions (n, 3) there.

    `s` (m, 3): arc lengths of the first, last and middle nodes, interpolated quadratically.
    """
    ends = np.append(s[:, 0], s[-1, 1])
    if ends[-1] - ends[0] > 0 and (s[:, 1] < s[:, 0]).any():  # closed: the last edge ends at 0
        ends[-1] = s[-1, 0] + 2 * (s[-1, 2] - s[-1, 0])
    at = np.clip(np.searchsorted(ends, places, side="right") - 1, 0, len(s) - 1)
    first, middle = s[at, 0], s[at, 2]
    last = ends[at + 1]
    curved, slope, offset = 0.5 * (first + last) - middle, 0.5 * (last - first), places - middle
    root = np.sqrt(np.maximum(slope**2 + 4 * curved * offset, 0.0))
    x = np.clip(2 * offset / (slope + root), -1.0, 1.0)
    return at, np.stack([0.5 * x * (x - 1), 0.5 * x * (x + 1), 1 - x**2], axis=1)


def node_widths(edges: Numbers, s: Floats) -> tuple[Numbers, Floats]:
    """Nodes (k,) of the edges (m, 3) of a flank, and the arc length (k,) of each, mm."""
    nodes, place = np.unique(edges, return_inverse=True)
    # Simpson weights: integrals of the shape functions of an edge
    parts = np.abs(s[:, 1] - s[:, 0])[:, None] * np.array([1.0, 1.0, 4.0]) / 6.0
    return nodes, np.asarray(np.bincount(place.ravel(), weights=parts.ravel()), dtype=float)


def _ring_solver(
    section: SectionStiffness, body: Body, numbers: Numbers
) -> Callable[[Floats], Floats]:
    """Solver for the displacements of all nodes of a ring of equal sectors."""
    assert isinstance(body.mesh, SectorMesh)
    ring = RecoveredRing.of(section, body.mesh, body.material)
    return lambda forces: ring.in_body(forces, numbers)


def _whole_solver(section: SectionStiffness, mesh: WholeMesh) -> Callable[[Floats], Floats]:
    """Solver for the displacements of all nodes of a whole mesh."""
    recovery, size = Recovery(), len(mesh.nodes)
    condense_nodes(section, mesh, np.zeros((size, section.unknowns, 0)), recovery=recovery)

    def solve(forces: Floats) -> Floats:
        kept, carried = recovery.reduced(forces.reshape(size, -1, 1))
        return recovery.displacements(kept, carried, size).reshape(forces.shape)

    return solve
