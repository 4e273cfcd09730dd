"""Regions of an imported sector by their sets: elements of one region together."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import SectorMesh
    from flankload.bodies.imported.mesh_source import MeshSource
    from flankload.scene import MeshBody


def with_named_regions(source: MeshSource, spec: MeshBody, mesh: SectorMesh) -> SectorMesh:
    """The sector with its elements divided by `region_sets`.

    An element belongs to a set that has all its nodes.

    Parameters
    ----------
    source : MeshSource
    spec : MeshBody
    mesh : SectorMesh

    Returns
    -------
    SectorMesh
        With `regions`, if the body has any.

    Raises
    ------
    MeshError
        If a set is missing or has no elements, if regions share elements, or if elements of the
        flank are in one.
    """
    if spec.region_sets is None:
        return mesh
    of_elements = [np.full(len(data), -1) for _, data in mesh.cells]
    for number, name in enumerate(spec.region_sets):
        key, count = f"region_sets[{number}]", 0
        inside = np.zeros(len(mesh.nodes), dtype=bool)
        inside[source.nodes_of(key, name)] = True
        inside[len(source.raw.nodes) :] = True  # nodes that the file does not have are in no set
        for found, (_, data) in zip(of_elements, mesh.cells, strict=True):
            named = inside[data].all(axis=1)
            count += int(named.sum())
            if (found[named] >= 0).any():
                other = spec.region_sets[found[named].max()]
                source.refuse(key, f"elements that are not in {other!r}", f"{name!r} has some")
            found[named] = number
        if not count:
            source.refuse(key, "a set of elements", f"none in {name!r}")
    _check_flank(source, spec, mesh, of_elements)
    cells, regions = [], []
    for number in range(-1, len(spec.region_sets)):
        for found, (kind, data) in zip(of_elements, mesh.cells, strict=True):
            if (found == number).any():
                cells.append((kind, data[found == number]))
                regions.append("" if number < 0 else spec.region_sets[number])
    return replace(mesh, cells=tuple(cells), regions=tuple(regions))


def _check_flank(
    source: MeshSource, spec: MeshBody, mesh: SectorMesh, of_elements: list[NDArray[np.int64]]
) -> None:
    """Refuse a region with elements of the flank: it is as wide as the teeth."""
    assert spec.region_sets is not None
    flank = np.append(mesh.flank_edges, mesh.tip_edges)
    for found, (_, data) in zip(of_elements, mesh.cells, strict=True):
        touched = (found >= 0) & np.isin(data, flank).any(axis=1)
        if touched.any():
            number = int(found[touched].min())
            source.refuse(
                f"region_sets[{number}]",
                "a region without nodes of the flank, which is as wide as the teeth",
                f"{touched.sum()} elements of {spec.region_sets[number]!r} on it",
            )
