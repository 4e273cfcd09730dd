"""Mesh of a whole body: the ring of its sectors, and the layers of its elements along the axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flankload.base.gauss import leggauss
from flankload.base.rotation import turned

if TYPE_CHECKING:
    from flankload.base.arrays import Cells, Floats, Numbers
    from flankload.bodies.body import SectorMesh
    from flankload.elasticity.axial_basis import AxialBasis
    from flankload.elasticity.finite_elements import SectionStiffness

#: Largest distance of matching fixed nodes on both cuts, over the size of the mesh.
CUT_TOLERANCE = 1e-6
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
class BodyPart:
    """Elements of one width: n nodes of the whole section at J axial stations.

    Attributes
    ----------
    nodes : (n,) array
        Numbers in the section of the whole body.
    cells : ((kind, (E, k) array), ...)
        Plane elements, by nodes of the part.
    basis : AxialBasis
        Functions of z over the width.
    """

    nodes: Numbers
    cells: Cells
    basis: AxialBasis

    @property
    def z_mm(self) -> Floats:
        """Stations (J,), ascending; one of a plane body."""
        return np.linspace(*self.basis.range_mm, 2 * -(-self.basis.degree // 2) + 1)

    @property
    def solids(self) -> Cells:
        """Elements of all layers, with points numbered by node, then station."""
        count, found = self.z_mm.size, []
        if count == 1:
            return self.cells
        for kind, cells in self.cells:
            node, level = map(np.array, SOLID_NODES[kind])
            first = 2 * np.arange(count // 2)[:, None, None]
            points = cells[:, node] * count + level + first
            found.append((SOLIDS[kind], points.reshape(-1, node.size)))
        return tuple(found)

    def shares(self, spans_mm: Floats) -> Floats:
        """Means (n, J) over spans (n, 2) of the shape functions of the stations."""
        z = self.z_mm
        found = np.full((len(spans_mm), z.size), float(z.size == 1))
        points, weights = leggauss(2)  # parabolas are exact
        for k in range(0, z.size - 1, 2):
            low, high = (np.clip(spans_mm, z[k], z[k + 2])).T
            places = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * points
            x = (2.0 * places - z[k] - z[k + 2]) / (z[k + 2] - z[k])
            shapes = np.stack([0.5 * x * (x - 1), 1 - x**2, 0.5 * x * (x + 1)], axis=-1)
            inside = (high - low) / (spans_mm[:, 1] - spans_mm[:, 0])
            found[:, k : k + 3] += inside[:, None] * np.einsum("g,ngj->nj", 0.5 * weights, shapes)
        return found


def parts_of(whole: Cells, section: SectionStiffness) -> tuple[BodyPart, ...]:
    """Parts of the whole body by width."""
    bases, _ = section.functions.of_nodes(np.zeros(0, dtype=np.int64))
    found = []
    for region in sorted(set(section.region_of_cells)):
        own = zip(section.region_of_cells, whole, strict=True)
        cells = [block for number, block in own if number == region]
        nodes = np.unique(np.concatenate([data.ravel() for _, data in cells]))
        of_part = tuple((kind, np.searchsorted(nodes, data)) for kind, data in cells)
        found.append(BodyPart(nodes, of_part, bases[region]))
    return tuple(found)


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
