"""Unit loads at the nodes of a flank, and tables between them: the near field as the paper has it.

The load of a node falls off to its neighbours by a straight line, and what it moves is read as the
mean with the same weights, so that a table between the nodes is symmetric and all its nodes are
alike: forces on single nodes of quadratic elements would make ends and middles of edges differ.
The nodes are the ends of the edges of the elements; tables are read between them by straight lines,
(21) and (22).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.bodies.body import MeshedFlank, WholeMesh
from flankload.elasticity.near_field import carrying_edges, consistent_loads

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import SectorMesh

    Floats = NDArray[np.float64]


def flank_nodes(flank: SectorMesh | MeshedFlank) -> Floats:
    """Arc lengths of the nodes that carry unit loads.

    Parameters
    ----------
    flank : SectorMesh or MeshedFlank

    Returns
    -------
    (n,) array
        Of the ends of the flank's edges, ascending, mm.
    """
    _, s = carrying_edges(flank)
    return np.append(s[:, 0], s[-1, 1])


def nodes_of(mesh: SectorMesh | WholeMesh) -> Floats:
    """The same of a body: those of the first flank, for all, since loads are functions along it."""
    return flank_nodes(mesh.flanks[0] if isinstance(mesh, WholeMesh) else mesh)


def hat_values(s: Floats, nodes: Floats) -> Floats:
    """Values (k, n) at places s (k,) of the functions that fall from 1 at a node to 0 at the next.

    Beyond the first and the last node they keep their end values.
    """
    at = np.clip(np.searchsorted(nodes, s, side="right") - 1, 0, nodes.size - 2)
    part = np.clip((s - nodes[at]) / (nodes[at + 1] - nodes[at]), 0.0, 1.0)
    values = np.zeros((np.size(s), nodes.size))
    rows = np.arange(np.size(s))
    values[rows, at] = 1.0 - part
    values[rows, at + 1] = part
    return values


def hat_widths(nodes: Floats) -> Floats:
    """Integrals of these functions, mm: for how much of the flank each node stands."""
    around = np.concatenate([nodes[:1], nodes, nodes[-1:]])
    return np.asarray(0.5 * (around[2:] - around[:-2]))


def hat_loads(
    flank: SectorMesh | MeshedFlank,
    nodes: Floats,
    *,
    along: Literal["normal", "tangent"] = "normal",
) -> Floats:
    """Consistent loads of a unit force at each node, out of the material or along the flank.

    Parameters
    ----------
    flank : SectorMesh or MeshedFlank
    nodes : (n,) array
        Arc lengths, mm; of whole bodies the same on every flank.
    along : {"normal", "tangent"}

    Returns
    -------
    (2 N, n) array
        Per mm of width, degree of freedom 2*node + component.
    """
    widths = hat_widths(nodes)
    return consistent_loads(
        flank,
        lambda s: hat_values(s, nodes) / widths,
        count=nodes.size,
        along=along,
        edges=carrying_edges(flank),
    )


def every_second(nodes: Floats) -> tuple[Floats, Floats]:
    """Half as many nodes, and what their unit loads are in those of all.

    Parameters
    ----------
    nodes : (n,) array
        Arc lengths, mm.

    Returns
    -------
    fewer : (m,) array
        Every second one and the last.
    parts : (n, m) array
        Forces of all nodes that make the unit force of each; columns sum up to 1.
    """
    fewer = nodes[::2] if nodes.size % 2 else np.append(nodes[::2], nodes[-1])
    return fewer, hat_values(nodes, fewer) * hat_widths(nodes)[:, None] / hat_widths(fewer)
