"""Unit loads of a flank: pressure modes or forces at its nodes, as columns of nodal forces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from flankload.elasticity.near_field import mode_loads
from flankload.elasticity.nodal_loads import hat_loads

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from flankload.bodies.body import MeshedFlank, SectorMesh
    from flankload.bodies.tip_modes import Tip


def unit_loads(
    mesh: SectorMesh | MeshedFlank,
    mode_range_mm: tuple[float, float],
    n_modes: int,
    *,
    friction: bool,
    closed: bool = False,
    nodes: NDArray[np.float64] | None = None,
    tip: Tip | None = None,
) -> NDArray[np.float64]:
    """Loads of the modes along the normal; with friction followed by those along the tangent.

    Parameters
    ----------
    mode_range_mm : (float, float)
    closed : bool
        The modes' range is a turn around the body.
    nodes : (n_modes,) array, optional
        Arc lengths, mm: unit forces at nodes in place of modes.
    tip : Tip, optional
        Behind the range; the last modes are its own.

    Returns
    -------
    (2 N, n_modes) or (2 N, 2 n_modes) array
    """

    def loads(along: Literal["normal", "tangent"]) -> NDArray[np.float64]:
        if nodes is not None:
            return hat_loads(mesh, nodes, along=along)
        return mode_loads(mesh, mode_range_mm, n_modes, along=along, closed=closed, tip=tip)

    return np.hstack([loads("normal"), loads("tangent")]) if friction else loads("normal")
