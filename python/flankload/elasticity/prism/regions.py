"""Functions of z of bodies whose webs, rims and hubs have widths of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flankload.elasticity.prism.axial_basis import AxialBasis, AxialRegions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flankload.bodies.body import SectorMesh


def functions_of(
    mesh: SectorMesh, axial: AxialBasis, extents_mm: Mapping[str, tuple[float, float]]
) -> tuple[tuple[int, ...], AxialBasis | AxialRegions]:
    """Region of each entry of the mesh's cells, and the functions of its nodes.

    A node of several regions has the functions of the widest one.

    Parameters
    ----------
    axial : AxialBasis
        Over the width of the teeth.
    extents_mm : mapping of str to (float, float)
        Extent along the axis of named regions; others are as wide as the teeth. Of two regions
        that share nodes, one contains the other.

    Returns
    -------
    numbers : tuple of int
        By entry of `mesh.cells`; empty if all are as wide as the teeth.
    functions : AxialBasis or AxialRegions
    """
    of_cells = [extents_mm.get(name, axial.range_mm) for name in mesh.regions]
    if all(extent == axial.range_mm for extent in of_cells):
        return (), axial
    ranges = sorted({axial.range_mm, *of_cells}, key=lambda extent: extent[0] - extent[1])
    numbers = tuple(ranges.index(extent) for extent in of_cells)
    of_node = np.zeros(len(mesh.nodes), dtype=np.int64)
    for number in range(len(ranges) - 1, -1, -1):  # wider regions after narrower ones
        for own, (_, cells) in zip(numbers, mesh.cells, strict=True):
            if own == number:
                of_node[cells] = number
    return numbers, AxialRegions(
        tuple(AxialBasis(extent, axial.degree) for extent in ranges), of_node
    )
