"""Displacement and stress at all nodes of a body under forces on its flanks.

For a body of equal sectors, the stiffness of one sector is factorised, the cuts are solved by
sector harmonics, and each sector requires one back substitution. Forces act on edges of elements,
which do not resolve contacts that are narrower than an element.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.rotation import turned
from flankload.bodies.body import SectorMesh
from flankload.elasticity.fe_error import recovered_strains
from flankload.elasticity.finite_elements import (
    lame_parameters,
    stiffness,
)
from flankload.elasticity.fronts.condensation import condense_nodes
from flankload.elasticity.fronts.recovery import Recovery
from flankload.elasticity.near_field import coast_nodes, loaded_edges
from flankload.elasticity.recovered_ring import RecoveredRing

if TYPE_CHECKING:
    from collections.abc import Callable

    from flankload.base.arrays import Cells, Floats, Numbers
    from flankload.bodies.body import Body, WholeMesh

#: Largest distance of matching fixed nodes on both cuts, over the size of the mesh.
CUT_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class LoadedBody:
    """The factorised elements of a whole body, in its frame, for forces on its flanks.

    Attributes
    ----------
    body : Body
        From `Body.for_elements`.
    plane : {"strain", "stress"}
    nodes : (M, 2) array
        Nodes of the whole body, mm, without duplicates on the cuts.
    cells : ((kind, (E, k) array), ...)
        Elements of the whole body.
    numbers : (z, N) array
        Node of the whole body for each node of each sector; one row for a whole mesh.
    solve : callable
        Nodal forces (2M,) per mm of width, N/mm -> displacements (2M,), mm.
    """

    body: Body
    plane: str
    nodes: Floats
    cells: Cells
    numbers: Numbers
    solve: Callable[[Floats], Floats]

    def nodal_forces(
        self, tooth: Numbers, s_mm: Floats, force: Floats, *, coast: bool = False
    ) -> Floats:
        """Consistent nodal forces (2M,) of point forces (n, 2) on flanks, per mm of width.

        In the frame of the body, on teeth (n,) from 0, at arc lengths (n,); forces beyond the
        elements act on the last node. Coast flanks require involutes and equal sectors.
        """
        total = np.zeros((len(self.nodes), 2))
        for each in np.unique(tooth):
            own = tooth == each
            edges, s = self._edges(int(each), coast=coast)
            at, shapes = on_edges(s, s_mm[own])
            np.add.at(total, edges[at], shapes[:, :, None] * force[own][:, None, :])
        return total.ravel()

    def flank_widths(self, tooth: int, *, coast: bool = False) -> tuple[Numbers, Floats]:
        """Nodes (k,) of a flank, and the flank length (k,) of each, mm."""
        return node_widths(*self._edges(tooth, coast=coast))

    def stress_MPa(self, moved: Floats) -> Floats:
        """Stress (M, 4) at the nodes, averaged over elements: xx, yy, zz and xy, frame of the body.

        `moved`: displacements (2M,), mm.
        """
        strain = recovered_strains(self.nodes, self.cells, moved[:, None])
        lame_lambda, lame_mu = lame_parameters(self.body.material, self.plane)
        volume = lame_lambda * (strain[:, 0] + strain[:, 1])
        xx, yy = (volume + 2 * lame_mu * strain[:, i] for i in range(2))
        zz = np.zeros_like(xx)
        if self.plane == "strain":
            zz = self.body.material.poisson_ratio * (xx + yy)
        return np.stack([xx, yy, zz, lame_mu * strain[:, 2]], axis=1)

    def _edges(self, tooth: int, *, coast: bool) -> tuple[Numbers, Floats]:
        """Nodes (m, 3) of the whole body on the edges of a flank, and their arc lengths."""
        mesh = self.body.mesh
        assert mesh is not None
        if not isinstance(mesh, SectorMesh):
            flank = next(flank for flank in mesh.flanks if flank.tooth == tooth)
            return loaded_edges(flank)
        edges, s = loaded_edges(mesh)
        if coast:
            edges, of_sector = coast_edges(self.body, mesh, edges)
            tooth -= of_sector
        return self.numbers[tooth % mesh.teeth][edges], s


def coast_edges(body: Body, mesh: SectorMesh, edges: Numbers) -> tuple[Numbers, int]:
    """Edges of the coast flank in a sector (mirror images), and the number of its tooth."""
    assert body.involute is not None
    nodes, place = np.unique(edges, return_inverse=True)
    images, tooth = coast_nodes(mesh, nodes, body.involute.turn_rad)
    return images[place.reshape(edges.shape)], tooth


def loaded_body(body: Body, plane: str) -> LoadedBody:
    """Factorise the elements of a plane elastic body for forces on its flanks."""
    body = body.for_elements()
    mesh = body.mesh
    assert mesh is not None
    if isinstance(mesh, SectorMesh):
        nodes, cells, numbers = ring_of(mesh)
        return LoadedBody(body, plane, nodes, cells, numbers, _ring_solver(body, plane, numbers))
    numbers = np.arange(len(mesh.nodes))[None]
    solve = _whole_solver(body, mesh, plane)
    return LoadedBody(body, plane, mesh.nodes, mesh.cells, numbers, solve)


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


def ring_of(mesh: SectorMesh) -> tuple[Floats, Cells, Numbers]:
    """Nodes (M, 2) and elements of a whole ring, and numbers (z, N) of the nodes of its sectors."""
    z, n = mesh.teeth, len(mesh.nodes)
    pitch = 2 * np.pi / z
    fixed = mesh.nodes[mesh.fixed_nodes]
    apart = np.linalg.norm(turned(fixed, pitch)[:, None] - fixed, axis=2)
    left, right = np.nonzero(apart < CUT_TOLERANCE * float(np.abs(mesh.nodes).max()))
    left = np.concatenate([mesh.left_nodes, mesh.fixed_nodes[left]])
    right = np.concatenate([mesh.right_nodes, mesh.fixed_nodes[right]])
    own = np.setdiff1d(np.arange(n), right)
    numbers = np.empty((z, n), dtype=np.int64)
    numbers[:, own] = np.arange(z * own.size).reshape(z, own.size)
    numbers[:, right] = np.roll(numbers, -1, axis=0)[:, left]
    cells = tuple((kind, numbers[:, data].reshape(-1, data.shape[1])) for kind, data in mesh.cells)
    return np.concatenate([turned(mesh.nodes[own], k * pitch) for k in range(z)]), cells, numbers


def _ring_solver(body: Body, plane: str, numbers: Numbers) -> Callable[[Floats], Floats]:
    """Solver for the displacements of all nodes of a ring of equal sectors."""
    mesh = body.mesh
    assert isinstance(mesh, SectorMesh)
    section = stiffness(mesh.nodes, mesh.cells, body.material, plane)
    ring = RecoveredRing.of(section, mesh, body.material)
    return lambda forces: ring.in_body(forces.reshape(-1, 1, 2), numbers).ravel()


def _whole_solver(body: Body, mesh: WholeMesh, plane: str) -> Callable[[Floats], Floats]:
    """Solver for the displacements of all nodes of a whole mesh."""
    section, recovery = stiffness(mesh.nodes, mesh.cells, body.material, plane), Recovery()
    condense_nodes(section, mesh, np.zeros((len(mesh.nodes), 2, 0)), recovery=recovery)

    def solve(forces: Floats) -> Floats:
        kept, carried = recovery.reduced(forces.reshape(-1, 2, 1))
        return recovery.displacements(kept, carried, len(mesh.nodes)).ravel()

    return solve
